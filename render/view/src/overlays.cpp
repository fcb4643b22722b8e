// SPDX-License-Identifier: Zlib
#include "limber/view/debug_drawer.h"

#include "limber/view/convert.h"
#include "limber/view/velocity_arrows.h"

#include <array>
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

inline namespace LIMBER_BULLET_PRECISION {
namespace {

render::Vec3 vec3Of(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

render::Legend speedLegend(const VelocityArrows& arrows) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g m/s", arrows.fullSpeed);
  return {render::ColourMap::Share, "0", "", text.data()};
}

void addVelocities(render::Overlay& overlay, const SoftBody& body, const VelocityArrows& arrows,
                   render::Vec3 eye) {
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    const Eigen::Vector3d from = body.position(i), velocity = body.velocity(i);
    const double speed = velocity.norm();
    if (speed < arrows.leastSpeed) continue;
    const Eigen::Vector3d to = from + arrows.seconds * velocity;
    const render::Vec3 colour = render::shareColour(static_cast<float>(speed / arrows.fullSpeed));
    render::addArrow(overlay, vec3Of(from), vec3Of(to), colour, eye);
  }
}

}  // namespace LIMBER_BULLET_PRECISION

}  // namespace limber::view
