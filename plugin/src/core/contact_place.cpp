// SPDX-License-Identifier: Zlib
#include "core/contact_place.h"

namespace limber {

Eigen::Matrix3d mobility(const LinkedBodies& bodies, const ContactPlace& place) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  if (place.kind == ContactPlace::Kind::Soft) {
    const PointState& p = *bodies.points[place.body];
    for (std::uint32_t i = 0; i < place.count; ++i)
      m.diagonal() += place.weight[i] * place.weight[i] * p.inverseMass.col(place.point[i]);
  } else if (place.kind == ContactPlace::Kind::Rigid) {
    const RigidState& rigid = bodies.rigids[place.body];
    const Eigen::Vector3d& r = place.arm;
    Eigen::Matrix3d cross;
    cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
    m = -cross * rigid.inverseInertia * cross;
    m.diagonal() += rigid.inverseMass;
  }
  return m;
}

}  // namespace limber
