// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/convert.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The place on a surface that is nearest to a point, and the unit normal there, from the surface to the
/// point, or outward where the point is inside.
struct NearestOnBox {
  Eigen::Vector3d surface, normal;
};

/// In the box's coordinates. Bullet's narrowphase rounds the box's edges with the shape's margin, usually 4
/// cm: a point could be centimetres inside what is drawn, and what the edges and triangles of a surface meet.
inline NearestOnBox nearestOnBox(const btBoxShape& box, const Eigen::Vector3d& point) {
  const Eigen::Vector3d half = toEigen(box.getHalfExtentsWithMargin());
  NearestOnBox nearest;
  nearest.surface = point.cwiseMax(-half).cwiseMin(half);
  const Eigen::Vector3d outward = point - nearest.surface;
  const double distance = outward.norm();
  if (distance > 0.0) {
    nearest.normal = outward / distance;
    return nearest;
  }
  Eigen::Index axis;
  (half - point.cwiseAbs()).minCoeff(&axis);
  const double side = point[axis] < 0.0 ? -1.0 : 1.0;
  nearest.normal = side * Eigen::Vector3d::Unit(axis);
  nearest.surface[axis] = side * half[axis];
  return nearest;
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
