// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"
#include "scene_overlay.h"

#include <limber/render/gl_context.h>
#include <limber/render/gl_functions.h>
#include <limber/render/renderer.h>
#include <limber/render/rigid_shape.h>
#include <limber/view/rigid_view.h>
#include <limber/view/soft_view.h>

#include <memory>

namespace limber::demo {

/// Which picture of a run.
struct Moment {
  double tickFraction = 1.0;  ///< of the last tick
  double share = 0.0;         ///< of the run, 0 to 1
};

/// Draws a scene, which must outlive it. All members throw std::runtime_error with the reason when the driver
/// fails.
class SceneRenderer {
 public:
  SceneRenderer(const scenes::Scene& scene, const DemoOptions& options);

  /// Positions are written straight into memory that the GPU reads.
  void draw(const Moment& moment, render::Image& image);

  std::size_t gpuBufferBytes() const { return renderer_.gpuBufferBytes(); }
  render::RingStats ring() const { return renderer_.ringStats(); }
  const render::FrameStats& lastFrame() const { return renderer_.lastFrame(); }
  std::string driver() const;

 private:
  render::InstanceId addFloor();

  const scenes::Scene& scene_;
  DemoOptions options_;
  std::unique_ptr<render::GlContext> context_;
  render::Renderer renderer_;
  render::TextureId checker_;
  view::SoftView softBodies_;
  view::RigidView rigidBodies_;
  float floorReach_ = 1.0f;
  render::InstanceId floor_;
  SceneOverlay overlay_;
};

}  // namespace limber::demo
