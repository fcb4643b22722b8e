// SPDX-License-Identifier: Zlib
#pragma once

#include "window/orbit_camera.h"

namespace limber::demo {

/// Where a window shows the scene: all of it, or with the split two views of one size, right of the panel if
/// there is space.
struct ViewLayout {
  int left = 0;     ///< pixels before the first view
  WindowSize view;  ///< of each view
  bool split = false;

  /// Returns the pixel of a view for one of the window.
  Pixel inFirst(Pixel window) const { return {window.x - left, window.y}; }
  Pixel inSecond(Pixel window) const { return {window.x - left - view.width, window.y}; }
  bool isSecond(Pixel window) const { return split && window.x >= left + view.width; }
};

/// Pixels that the panel takes from the left, in coordinates of the mouse.
constexpr int kPanelStrip = 326;

/// Returns the layout of a window; `scale` is the number of its pixels for one of the mouse's coordinates.
inline ViewLayout layoutOf(const WindowSize& window, bool split, bool panel, double scale = 1.0) {
  constexpr int kNarrow = 3;  // the panel leaves two thirds of the window
  ViewLayout layout;
  layout.view = window;
  layout.split = split;
  if (!split) return layout;
  const int strip = static_cast<int>(kPanelStrip * scale);
  if (panel && window.width >= kNarrow * strip) layout.left = strip;
  layout.view.width = (window.width - layout.left) / 2;
  return layout;
}

}  // namespace limber::demo
