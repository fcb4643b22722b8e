// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"
#include "scenes/scene.h"

#include <limber/render/camera.h>
#include <limber/render/gl_context.h>
#include <limber/render/gl_functions.h>
#include <limber/render/image.h>
#include <limber/render/light.h>
#include <limber/render/overlay.h>
#include <limber/render/renderer.h>
#include <limber/render/rigid_shape.h>
#include <limber/view/debug_drawer.h>
#include <limber/view/rigid_view.h>
#include <limber/view/soft_view.h>
#include <limber/view/velocity_arrows.h>

#include <memory>

namespace limber::demo {

/// Returns the camera at a fraction (0 to 1) of the run: the one of the options, or one that frames
/// View::box.
render::Camera cameraAt(const scenes::View& view, const DemoOptions& options, double share);

render::Light lightOf(const scenes::View& view);

inline render::Vec3 toVec3(const Eigen::Vector3d& v) {
  const Eigen::Vector3f f = v.cast<float>();
  return {f.x(), f.y(), f.z()};
}
inline render::Vec3 toVec3(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

/// Return the looks of the scene's bodies; `checker` is the texture of checkered ones. The scene must outlive
/// the result.
view::SoftView::Look softLooks(const scenes::Scene& scene, render::TextureId checker);
/// Returns the colour of the bodies of an island (SoftBody::island()): grey for sleeping ones.
render::Vec3 islandColour(int island);
/// It also knows the bodies that come into the scene later.
view::RigidView::Look rigidLooks(const scenes::Scene& scene);

inline const view::VelocityArrows kVelocityArrows;

/// Lines that show forces and bounds. Bullet's lines show the end of the last tick.
class SceneOverlay {
 public:
  explicit SceneOverlay(const scenes::Scene& scene);

  /// Returns the chosen lines for a picture from `eye`; the caller may add to them until the next call.
  render::Overlay& draw(const OverlayChoice& choice, render::Vec3 eye);

 private:
  const scenes::Scene& scene_;
  view::DebugDrawer drawer_;
};

/// One picture of a scene.
struct Shot {
  render::Camera camera;
  double tickFraction = 1.0;  ///< of the last tick
  PictureMode mode = PictureMode::Shaded;
  OverlayChoice overlay;
  render::Light light;
  render::Overlay marks;  ///< further lines
};

/// Returns white and grey squares, which the colour of a body multiplies, as a texture.
render::TextureId addCheckerTexture(render::Renderer& renderer);

/// Returns how a renderer draws the shot.
render::DrawOptions drawOptions(const Shot& shot, render::Quality quality);

/// The floor of a scene in a renderer, which must outlive it.
class FloorView {
 public:
  FloorView(render::Renderer& renderer, const scenes::Scene& scene);
  ~FloorView();
  FloorView(const FloorView&) = delete;
  FloorView& operator=(const FloorView&) = delete;

  void write(const render::FrameWriter& frame) const;

 private:
  render::Renderer& renderer_;
  render::ShapeId shape_;
  float scale_ = 1.0f;
  render::InstanceId instance_;
};

/// Shows a scene with a renderer; both must outlive it. All members throw std::runtime_error with the reason
/// if the driver fails.
class SceneView {
 public:
  SceneView(const scenes::Scene& scene, render::Renderer& renderer, render::TextureId checker);
  SceneView(const SceneView&) = delete;
  SceneView& operator=(const SceneView&) = delete;

  /// Draws a picture; positions are written straight into memory that the GPU reads.
  void draw(const Shot& shot);

 private:
  view::SoftView::Look looks(render::TextureId checker) const;

  const scenes::Scene& scene_;
  render::Renderer& renderer_;
  bool islands_ = false;  // colours are those of islands
  view::SoftView softBodies_;
  view::RigidView rigidBodies_;
  FloorView floor_;
  SceneOverlay overlay_;
};

/// The time of a picture.
struct Moment {
  double tickFraction = 1.0;  ///< of the last tick
  double share = 0.0;         ///< of the run, 0 to 1
};

/// Draws a scene, which must outlive it, in a context of its own. Errors as of SceneView.
class SceneRenderer {
 public:
  SceneRenderer(const scenes::Scene& scene, const DemoOptions& options);

  void draw(const Moment& moment, render::Image& image);

  std::size_t gpuBufferBytes() const { return renderer_.gpuBufferBytes(); }
  render::RingStats ring() const { return renderer_.ringStats(); }
  const render::FrameStats& lastFrame() const { return renderer_.lastFrame(); }
  std::string driver() const;

 private:
  const scenes::Scene& scene_;
  scenes::View seen_;
  DemoOptions options_;
  std::unique_ptr<render::GlContext> context_;
  render::Renderer renderer_;
  SceneView view_;
};

}  // namespace limber::demo
