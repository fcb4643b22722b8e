// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/render/overlay.h>

#include <LinearMath/btIDebugDraw.h>

#include <functional>
#include <string>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {

/// A btIDebugDraw whose lines become the overlay of a picture:
///
///     limber::view::DebugDrawer drawer;
///     drawer.setDebugMode(btIDebugDraw::DBG_DrawConstraints | btIDebugDraw::DBG_DrawContactPoints);
///     world.setDebugDrawer(&drawer);
///     drawer.overlay.clear();  world.debugDrawWorld();                  // each frame
///     renderer.draw(frame, camera, light, options, drawer.overlay);
///
/// It shows all that Bullet draws through its debug interface: rigid bodies, constraints, contacts, and the
/// soft bodies of a SoftBodySystem. Text is not drawn. A contact is a cross and a line along its normal.
class DebugDrawer final : public btIDebugDraw {
 public:
  render::Overlay overlay;    ///< The lines drawn since the last clear().
  float contactSize = 0.05f;  ///< Length of a contact's normal, m.
  float contactWidth = 2.5f;  ///< Pixels.

  /// Receives Bullet's warnings. Default: a line on standard error.
  std::function<void(const std::string&)> onWarning;

  void drawLine(const btVector3& from, const btVector3& to, const btVector3& colour) override;
  void drawContactPoint(const btVector3& at, const btVector3& normal, btScalar distance, int lifeTime,
                        const btVector3& colour) override;
  void reportErrorWarning(const char* text) override;
  void draw3dText(const btVector3&, const char*) override {}
  void setDebugMode(int mode) override { mode_ = mode; }
  int getDebugMode() const override { return mode_; }

 private:
  int mode_ = DBG_NoDebug;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view
