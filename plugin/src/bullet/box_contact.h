// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/bullet_objects.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The place on a box that is nearest to a point (m, in the world), and the unit normal there, from the box
/// to the point, or outward where the point is inside.
struct NearestOnBox {
  Eigen::Vector3d surface, normal;
};

/// In closed form. Bullet's general narrowphase rounds the box's edges with the shape's margin, usually 4 cm:
/// a point could be centimetres inside what is drawn, and what the edges and triangles of a surface meet. In
/// single precision it also now and then finds a point that rests on a box centimetres above it.
inline NearestOnBox nearestOnBox(const btBoxShape& box, const btTransform& pose,
                                 const Eigen::Vector3d& point) {
  const Eigen::Vector3d half = toEigen(box.getHalfExtentsWithMargin());
  const Eigen::Vector3d local = toEigen(pose.invXform(toBullet(point)));
  Eigen::Vector3d surface = local.cwiseMax(-half).cwiseMin(half);
  Eigen::Vector3d outward = local - surface;
  if (outward.isZero(0.0)) {
    Eigen::Index axis;
    (half - local.cwiseAbs()).minCoeff(&axis);
    const double side = local[axis] < 0.0 ? -1.0 : 1.0;
    outward = side * Eigen::Vector3d::Unit(axis);
    surface[axis] = side * half[axis];
  }
  const btVector3 normal = pose.getBasis() * toBullet(Eigen::Vector3d(outward.normalized()));
  return {toEigen(pose * toBullet(surface)), toEigen(normal).normalized()};
}

/// m: how much farther than it is a box that is a part of the shape may be for Bullet's narrowphase. The core
/// that it sweeps a ball of the margin m around has its corners sqrt(3) m within the box's: sqrt(3) m - m.
inline btScalar roundingOf(const btCollisionShape& shape) {
  constexpr double kCorner = 0.7320508075688772;
  if (shape.getShapeType() == BOX_SHAPE_PROXYTYPE) return btScalar(kCorner) * shape.getMargin();
  btScalar rounding = 0;
  if (!shape.isCompound()) return rounding;
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i)
    rounding = btMax(rounding, roundingOf(*compound.getChildShape(i)));
  return rounding;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
