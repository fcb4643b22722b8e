// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"
#include "scene_shapes.h"
#include "scenes/scene.h"

#include <limber/render/gl_context.h>
#include <limber/render/gl_functions.h>
#include <limber/render/renderer.h>

#include <memory>
#include <utility>
#include <vector>

namespace limber::demo {

/// Draws a scene. The scene must outlive it and keep its bodies. All members throw std::runtime_error with
/// the reason when the driver fails.
class SceneRenderer {
 public:
  SceneRenderer(const scenes::Scene& scene, const DemoOptions& options);

  /// The scene as it is now: its positions are written straight into memory that the GPU reads.
  void draw(render::Image& image);

  std::size_t gpuBufferBytes() const { return renderer_.gpuBufferBytes(); }
  const render::FrameStats& lastFrame() const { return renderer_.lastFrame(); }
  std::string driver() const;

 private:
  using BodyShape = std::pair<const SpringNetwork*, render::ShapeId>;

  render::ShapeId shapeFor(const SoftBody& body, const scenes::BodyLook& look);
  void addBodies();
  void addProps();

  const scenes::Scene& scene_;
  std::unique_ptr<render::GlContext> context_;
  render::Renderer renderer_;
  render::Camera camera_;
  render::Light light_;
  render::DrawOptions drawOptions_;
  std::vector<BodyShape> shapes_;           // one per network
  std::vector<render::InstanceId> bodies_;  // in the order of the scene's bodies
  std::vector<std::pair<render::InstanceId, Prop>> props_;
};

}  // namespace limber::demo
