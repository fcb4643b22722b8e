// SPDX-License-Identifier: Zlib
#include "scene_overlay.h"

#include <limber/view/velocity_arrows.h>

namespace limber::demo {
namespace {

/// Half of what the scene shows is this far, m: marks are drawn in proportion.
double viewRadius(const scenes::View& view) { return 0.5 * view.box.diagonal().norm(); }

constexpr double kContactSize = 0.04;  // of the reach

int modeOf(const OverlayChoice& choice) {
  int mode = btIDebugDraw::DBG_NoDebug;
  if (choice.contacts) mode |= btIDebugDraw::DBG_DrawContactPoints;
  if (choice.constraints) mode |= btIDebugDraw::DBG_DrawConstraints | btIDebugDraw::DBG_DrawConstraintLimits;
  if (choice.boxes) mode |= btIDebugDraw::DBG_DrawAabb;
  return mode;
}

/// Bullet asks its actions, among them the soft bodies, to draw themselves in these modes only.
constexpr int kAsksActions =
    btIDebugDraw::DBG_DrawWireframe | btIDebugDraw::DBG_DrawAabb | btIDebugDraw::DBG_DrawNormals;

}  // namespace

SceneOverlay::SceneOverlay(const scenes::Scene& scene, const OverlayChoice& choice)
    : scene_(scene), choice_(choice) {
  drawer_.setDebugMode(modeOf(choice));
  drawer_.contactSize = static_cast<float>(kContactSize * viewRadius(scene.view));
}

const render::Overlay& SceneOverlay::draw(render::Vec3 eye) {
  drawer_.overlay.clear();
  const int mode = drawer_.getDebugMode();
  if (mode != btIDebugDraw::DBG_NoDebug) {
    btDiscreteDynamicsWorld& world = scene_.world->dynamics;
    world.setDebugDrawer(&drawer_);
    world.debugDrawWorld();
    world.setDebugDrawer(nullptr);
    if ((mode & kAsksActions) == 0) scene_.soft->debugDraw(drawer_);
  }
  if (choice_.velocities) {
    for (std::size_t b = 0; b < scene_.soft->bodyCount(); ++b)
      view::addVelocities(drawer_.overlay, *scene_.soft->body(b), kVelocityArrows, eye);
  }
  return drawer_.overlay;
}

}  // namespace limber::demo
