// SPDX-License-Identifier: Zlib
#include "core/contact_place.h"

namespace limber {

Eigen::Matrix3d mobility(const LinkedBodies& bodies, const ContactPlace& place) {
  const RigidState& rigid = bodies.rigids[place.body];
  const Eigen::Vector3d& r = place.arm;
  Eigen::Matrix3d cross;
  cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  Eigen::Matrix3d m = -cross * rigid.inverseInertia * cross;
  m.diagonal() += rigid.inverseMass;
  return m;
}

}  // namespace limber
