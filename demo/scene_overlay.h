// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <limber/render/overlay.h>
#include <limber/view/debug_drawer.h>
#include <limber/view/velocity_arrows.h>

namespace limber::demo {

inline const view::VelocityArrows kVelocityArrows;

/// The lines that the options ask for. What Bullet draws is at the end of the last tick.
class SceneOverlay {
 public:
  SceneOverlay(const scenes::Scene& scene, const OverlayChoice& choice);

  /// For a picture taken from `eye`; valid until the next call.
  const render::Overlay& draw(render::Vec3 eye);

 private:
  const scenes::Scene& scene_;
  OverlayChoice choice_;
  view::DebugDrawer drawer_;
};

}  // namespace limber::demo
