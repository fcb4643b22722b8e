// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/soft_body_system.h>

#include <btBulletDynamicsCommon.h>

#include <algorithm>

namespace limber::test {

inline Eigen::Vector3d eigen(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }

inline Eigen::Vector3d momentumOf(const btRigidBody& body) {
  return eigen(body.getLinearVelocity()) / double(body.getInvMass());
}

/// Returns the angular momentum about the origin.
inline Eigen::Vector3d angularMomentumOf(const btRigidBody& body) {
  const btVector3 spin = body.getInvInertiaTensorWorld().inverse() * body.getAngularVelocity();
  return eigen(body.getCenterOfMassPosition()).cross(momentumOf(body)) + eigen(spin);
}

inline double kineticEnergyOf(const btRigidBody& body) {
  const btVector3 spin = body.getAngularVelocity();
  return 0.5 * double(body.getLinearVelocity().length2()) / double(body.getInvMass()) +
         0.5 * double(spin.dot(body.getInvInertiaTensorWorld().inverse() * spin));
}

/// Returns the kinetic and elastic energy and, with a gravity (m/s^2), the potential one.
inline double energyOf(const SoftBody& body, double gravity = 0.0) {
  return body.kineticEnergy() + body.elasticEnergy() + gravity * body.totalMass() * body.centerOfMass().y();
}

inline double energyOf(const btRigidBody& body, double gravity) {
  return kineticEnergyOf(body) +
         gravity / double(body.getInvMass()) * double(body.getCenterOfMassPosition().y());
}

/// Returns the height (m) of the body's centre.
inline double heightOf(const btRigidBody& body) { return double(body.getCenterOfMassPosition().y()); }

/// Returns one hash of the states of all bodies.
inline std::uint64_t stateHashOf(const SoftBodySystem& system) {
  std::uint64_t hash = 0;
  for (std::size_t i = 0; i < system.bodyCount(); ++i) hash = hash * 31 + system.body(i)->stateHash();
  return hash;
}

/// Returns the smallest y (m) of the body's points.
inline double lowest(const SoftBody& body) {
  double y = 1e9;
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) y = std::min(y, body.position(i).y());
  return y;
}

/// Returns the largest y (m) of the body's points.
inline double highest(const SoftBody& body) {
  double y = -1e9;
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) y = std::max(y, body.position(i).y());
  return y;
}

/// Returns the signed volume (m^3) within the surface.
inline double volumeOf(const SoftBody& body) {
  double six = 0.0;
  for (const Triangle& t : body.network().surface)
    six += body.position(t[0]).dot(body.position(t[1]).cross(body.position(t[2])));
  return six / 6.0;
}

/// Returns the positions (m) of the points, one column each.
inline Eigen::Matrix3Xd placesOf(const SoftBody& body) {
  Eigen::Matrix3Xd places(3, body.pointCount());
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) places.col(i) = body.position(i);
  return places;
}

}  // namespace limber::test
