// SPDX-License-Identifier: Zlib
#include "limber/view/velocity_arrows.h"

#include <array>
#include <cstdio>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

render::Vec3 toVec3(const Eigen::Vector3d& v) {
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
    render::addArrow(overlay, toVec3(from), toVec3(to), colour, eye);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view
