// SPDX-License-Identifier: Zlib
#pragma once

#include "scene_renderer.h"
#include "window/session.h"

#include <limber/render/renderer.h>

#include <functional>
#include <memory>
#include <optional>

namespace limber::demo {

/// Draws a session into the framebuffer of a window, whose OpenGL context is current.
class Stage {
 public:
  /// `getProcAddress` returns the addresses of OpenGL's functions. Throws std::runtime_error with the reason
  /// if the driver lacks something.
  Stage(std::function<void*(const char*)> getProcAddress, const WindowSize& size);

  /// Draws the session at a time between its last two ticks, into the framebuffer of the window.
  void draw(const Session& session, double tickFraction, const WindowSize& size);
  /// Returns the window's framebuffer as it is now.
  render::Image readWindow(const WindowSize& size) const;
  std::string driver() const { return render::describeDriver(renderer_->gl()); }

 private:
  std::unique_ptr<render::GlContext> context_;
  std::unique_ptr<render::Renderer> renderer_;
  render::TextureId checker_;
  std::optional<SceneView> view_;
  int sceneNumber_ = 0;  // of the session, that view_ shows
};

}  // namespace limber::demo
