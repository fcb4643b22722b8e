// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet_soft/bullet_twin.h"
#include "scene_renderer.h"
#include "window/session.h"

#include <limber/render/renderer.h>
#include <limber/view/rigid_view.h>

#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace limber::demo {

/// Shows a BulletTwin with a renderer of its own, as SceneView shows a scene; both must outlive it. Of a Shot
/// it has camera, mode, shadows, marks and the time.
class TwinView {
 public:
  TwinView(const bullet_soft::BulletTwin& twin, render::Renderer& renderer, render::TextureId checker);
  ~TwinView();
  TwinView(const TwinView&) = delete;
  TwinView& operator=(const TwinView&) = delete;

  void draw(const Shot& shot);

 private:
  void addBodies(render::TextureId checker);

  const bullet_soft::BulletTwin& twin_;
  render::Renderer& renderer_;
  view::RigidView rigidBodies_;
  FloorView floor_;
  std::vector<render::ShapeId> shapes_;        // #bodies
  std::vector<render::InstanceId> instances_;  // #bodies
};

/// Draws a session into the framebuffer of a window, whose OpenGL context is current.
class Stage {
 public:
  /// `getProcAddress` returns the addresses of OpenGL's functions. Throws std::runtime_error with the reason
  /// if the driver lacks something.
  Stage(std::function<void*(const char*)> getProcAddress, const WindowSize& size);

  /// Draws the session at a time between its last two ticks, into the framebuffer of the window, whose size
  /// is `size`. With the split each engine has a view; `scale`: pixels for one of the mouse's coordinates.
  void draw(const Session& session, double tickFraction, const WindowSize& size, double scale);
  /// Returns the window's framebuffer as it is now.
  render::Image readWindow(const WindowSize& size) const;
  std::string driver() const { return render::describeDriver(left_->renderer.gl()); }

 private:
  /// A renderer of one view.
  struct Pane {
    Pane(render::GlContext& context, const WindowSize& size, render::Quality quality);
    void resize(const WindowSize& size);

    render::Renderer renderer;
    render::TextureId checker;
  };

  void choose(render::Quality quality, const WindowSize& size);
  void update(const Session& session, const WindowSize& size);

  std::unique_ptr<render::GlContext> context_;
  render::Quality quality_ = render::Quality::Fast;
  std::unique_ptr<Pane> left_, right_;  // right_: nullptr before the first split
  std::optional<SceneView> view_;
  std::optional<TwinView> twinView_;
  const bullet_soft::BulletTwin* twin_ = nullptr;  // that twinView_ shows
  int sceneNumber_ = 0;                            // of the session, that view_ and twinView_ show
};

}  // namespace limber::demo
