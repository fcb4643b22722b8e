// SPDX-License-Identifier: Zlib
#pragma once

#include "render/baselines/baseline.h"
#include "renderer_parts.h"

#include <cstddef>
#include <stdexcept>
#include <vector>

namespace limber::bench {

/// A baseline that keeps the points of its frame in plain memory, in the order of the renderer's layout.
class StagedBaseline : public Baseline {
 public:
  explicit StagedBaseline(render::Renderer& renderer) : parts_(render::RendererAccess::parts(renderer)) {}

  float* points(render::InstanceId instance) const final {
    const render::FrameLayout::Slice* slice = parts_.layout.find(instance);
    if (!open_ || slice == nullptr)
      throw std::runtime_error("points(): this instance is not part of an open frame of the baseline");
    return points_ + 3 * std::size_t{slice->firstPoint};
  }

  void draw(const render::Camera& camera, const render::Light& light,
            const render::DrawOptions& options) override {
    if (!open_) throw std::logic_error("draw() of a baseline without beginFrame()");
    render::Stopwatch watch;
    const render::GlStateGuard guard(parts_.gl, parts_.sharedContext);
    uploadAll();
    parts_.uploadFrameData(camera, light, options, {});
    parts_.stats.uploadMs = watch.lap();
    drawPicture(options, light.shadows);
    parts_.stats.submitMs = watch.lap();
    open_ = false;
  }

 protected:
  virtual void uploadAll() = 0;
  virtual void drawPicture(const render::DrawOptions& options, bool shadows) = 0;

  /// Orders the instances as the renderer does.
  void layOut() {
    if (parts_.frame.open)
      throw std::logic_error("a baseline cannot draw while a frame of the renderer is open");
    parts_.layOutInstances();
  }
  void openFrame() {
    floats_.resize(3 * parts_.layout.pointCount);
    points_ = floats_.data();
    parts_.stats.waitMs = 0.0;  // It never waits for the GPU here.
    open_ = true;
  }
  /// The points from this one on.
  const float* staged(std::size_t firstPoint) const { return points_ + 3 * firstPoint; }

  render::RendererAccess::Parts& parts_;

 private:
  std::vector<float> floats_;
  float* points_ = nullptr;
  bool open_ = false;
};

}  // namespace limber::bench
