// SPDX-License-Identifier: Zlib
#include "solver/rigid_state.h"

#include <cmath>

namespace limber {

void RigidState::kick(double dt) {
  velocity += dt * (acceleration + force.cwiseProduct(inverseMass));
  angularVelocity += dt * (angularAcceleration + inverseInertia * torque);
}

void RigidState::drift(double dt) {
  position += dt * velocity;
  rotation = (rotationBy(dt * angularVelocity) * rotation).normalized();
  turn();
}

void RigidState::turn() {
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  inverseInertia = angularFactor.asDiagonal() * (r * inverseInertiaLocal.asDiagonal() * r.transpose());
}

Eigen::Quaterniond rotationBy(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  // sin(x/2)/x by its series where dividing by x would lose digits
  const double ratio = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  const Eigen::Vector3d axis = ratio * v;
  return Eigen::Quaterniond(std::cos(0.5 * angle), axis.x(), axis.y(), axis.z());
}

Eigen::Vector3d rotationBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  Eigen::Quaterniond q = to * from.conjugate();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  const double ratio = sine < 1e-8 ? 2.0 : 2.0 * std::atan2(sine, q.w()) / sine;
  return ratio * q.vec();
}

}  // namespace limber
