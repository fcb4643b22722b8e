// SPDX-License-Identifier: Zlib
#pragma once

#include "window/controls.h"
#include "window/history.h"
#include "window/session.h"

#include <string>
#include <vector>

namespace limber::demo {

/// What the panel shows besides the session.
struct FrameFigures {
  double framesPerSecond = 0.0;
  double drawMs = 0.0;  ///< of the picture and the panel
};

/// Where a slider is, for scripts that move the mouse; pixels.
struct SliderPlace {
  std::string name;
  double x, y, width, height;
};

/// Draws the panel of ImGui. Between ImGui::NewFrame() and ImGui::Render().
class Panel {
 public:
  void draw(Session& session, Controls& controls, const History& history, const FrameFigures& figures,
            bool interactive);
  /// Returns where the sliders are, if that has changed since the last call.
  std::vector<SliderPlace> takeMovedSliders();
  /// Shows a line, until the next one.
  void setMessage(std::string message) { message_ = std::move(message); }

 private:
  void drawSetting(Session& session, std::size_t setting);
  void drawSettings(Session& session);
  void drawBulletSettings(Session& session);

  std::string message_;
  std::vector<SliderPlace> sliders_, reported_;
};

}  // namespace limber::demo
