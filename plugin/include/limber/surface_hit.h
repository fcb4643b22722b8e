// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/soft_body.h>

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The soft body of a surface object, found from any collision object that Bullet reports.
struct SurfaceReference {
  SoftBody* body = nullptr;  ///< nullptr: the object is not the surface object of an existing soft body
};
SurfaceReference findSurface(const btCollisionObject* object);

/// The point of a soft body that a ray, sweep or contact has hit.
struct SurfaceHit {
  SoftBody* body = nullptr;    ///< nullptr: no surface, or no such triangle
  std::uint32_t triangle = 0;  ///< index into network().surface; for a body without one (a rope), the index
                               ///< of the spring in network().springs
  std::array<std::uint32_t, 3> points{};              ///< the corners; of a spring a, b, b
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< barycentric coordinates, 0 or more, sum 1, of the
                                                      ///< point of the triangle or spring nearest to the hit
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();   ///< unit, by the winding of the triangle; for a spring,
                                                      ///< from the spring to the hit; 0 if there is none
};

/// Returns the hit for a `triangleIndex` as Bullet reports it (LocalShapeInfo::m_triangleIndex, or the index
/// of contact tests) and a point `place` in world coordinates.
SurfaceHit surfaceHit(const btCollisionObject* object, int triangleIndex, const btVector3& place);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
