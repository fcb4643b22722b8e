// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <vector>

#include "frame_passes.h"
#include "instance_table.h"
#include "shape_table.h"

namespace limber::render {

/// The obvious way to draw many bodies, kept to measure and to check the real one against: positions
/// are written to plain memory, then each instance is uploaded into a buffer of its own and drawn by
/// itself.
class NaiveStream {
 public:
  explicit NaiveStream(const Gl& gl) : gl_(gl) {}

  /// Where the points of the layout's instances are to be written.
  float* begin(const FrameLayout& layout);
  /// Uploads them and fills `items`, one for each instance; `places` is where skins are computed.
  void upload(const FrameLayout& layout, const ShapeTable& shapes, const GlBuffer& places,
              std::vector<DrawItem>& items);
  std::size_t bytes() const;

 private:
  GLuint bufferFor(std::size_t instance, std::size_t bytes);

  const Gl& gl_;
  std::vector<float> staging_;
  std::vector<GlBuffer> buffers_;
};

}  // namespace limber::render
