// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Geometry>

namespace limber {

/// A rigid body that springs or anchors join to soft ones, carried along in their substeps.
struct RigidState {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, of the centre of mass
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();             ///< m/s
  Eigen::Vector3d angularVelocity = Eigen::Vector3d::Zero();      ///< rad/s
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();         ///< m/s^2, constant over a tick
  Eigen::Vector3d angularAcceleration = Eigen::Vector3d::Zero();  ///< rad/s^2, constant over a tick
  Eigen::Vector3d inverseMass = Eigen::Vector3d::Zero();          ///< 1/kg per axis; 0: held or static
  Eigen::Vector3d inverseInertiaLocal = Eigen::Vector3d::Zero();  ///< 1/(kg m^2), principal axes
  Eigen::Vector3d angularFactor = Eigen::Vector3d::Ones();        ///< 0 locks a world axis
  Eigen::Vector3d force = Eigen::Vector3d::Zero();                ///< N, from springs
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();               ///< N m, from springs
  Eigen::Matrix3d inverseInertia = Eigen::Matrix3d::Zero();  ///< 1/(kg m^2), about world axes, see turn()

  /// Makes inverseInertia that of the present rotation. Call it once the fields above are set; drift() does.
  void turn();

  void kick(double dt);
  void drift(double dt);

  /// Adds an impulse (N s) at `arm` (m) from the centre of mass.
  void applyImpulse(const Eigen::Vector3d& impulse, const Eigen::Vector3d& arm) {
    velocity += impulse.cwiseProduct(inverseMass);
    angularVelocity += inverseInertia * arm.cross(impulse);
  }

  Eigen::Vector3d velocityAt(const Eigen::Vector3d& arm) const {
    return velocity + angularVelocity.cross(arm);
  }
};

/// The rotation by |v| radians about v.
Eigen::Quaterniond rotationBy(const Eigen::Vector3d& v);

/// The vector of the rotation that leads from `from` to `to`, at most pi long.
Eigen::Vector3d rotationBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to);

}  // namespace limber
