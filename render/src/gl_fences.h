// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/gl_functions.h"
#include "limber/render/stream_ring.h"

namespace limber::render {

/// OpenGL's sync objects as the ring's fences.
class GlFences final : public FenceSource {
 public:
  explicit GlFences(const Gl& gl) : gl_(gl) {}

  Fence insert() override;
  bool wait(Fence fence, std::chrono::nanoseconds timeout) override;
  void destroy(Fence fence) noexcept override;

 private:
  const Gl& gl_;
};

}  // namespace limber::render
