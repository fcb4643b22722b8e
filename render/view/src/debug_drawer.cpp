// SPDX-License-Identifier: Zlib
#include "limber/view/debug_drawer.h"

#include "limber/view/convert.h"

#include <cstdio>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {

void DebugDrawer::drawLine(const btVector3& from, const btVector3& to, const btVector3& colour) {
  overlay.push_back({toVec3(from), toVec3(to), toVec3(colour)});
}

void DebugDrawer::drawContactPoint(const btVector3& at, const btVector3& normal, btScalar, int,
                                   const btVector3& colour) {
  const render::Vec3 tip = toVec3(at + btScalar(contactSize) * normal);
  overlay.push_back({toVec3(at), tip, toVec3(colour), contactWidth});
  render::addCross(overlay, toVec3(at), 0.2f * contactSize, toVec3(colour), contactWidth);
}

void DebugDrawer::reportErrorWarning(const char* text) {
  if (onWarning) return onWarning(text);
  std::fprintf(stderr, "bullet: %s\n", text);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view
