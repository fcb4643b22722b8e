// SPDX-License-Identifier: Zlib
#pragma once

#include <LinearMath/btQuaternion.h>
#include <LinearMath/btVector3.h>

#include <Eigen/Geometry>

namespace limber {

/// The one place where btScalar (float or double) and the step's double meet.
inline Eigen::Vector3d toEigen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
/// In double, whatever Bullet's own precision.
inline Eigen::Vector3d difference(const btVector3& now, const btVector3& before) {
  return toEigen(now) - toEigen(before);
}

inline Eigen::Quaterniond toEigen(const btQuaternion& q) {
  return Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized();
}

inline btVector3 toBullet(const Eigen::Vector3d& v) {
  return btVector3(static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z()));
}

inline btQuaternion toBullet(const Eigen::Quaterniond& q) {
  return btQuaternion(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                      static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w()));
}

}  // namespace limber
