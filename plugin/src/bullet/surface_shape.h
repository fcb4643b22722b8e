// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/spring_network.h>

#include "solver/point_state.h"

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The surface of a soft body as it is now, for Bullet's queries: its triangles, or, without any, two crossed
/// strips along each structural spring, as wide as its points.
///
/// Triangle t of Bullet is triangle t of the surface; or strip triangle t % 4 of spring springs()[t / 4].
class SurfaceShape final : public btConcaveShape {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  /// `positions` (3 x #points, m) must outlive it. `radius` in metres. `mirrored`: the body's triangles are its
  /// network's turned over.
  SurfaceShape(const SpringNetwork& network, bool mirrored, const Points& positions, btScalar radius);

  /// The box (world coordinates, m) that the broadphase gets.
  void setBox(const btVector3& low, const btVector3& high) { low_ = low, high_ = high; }
  const btVector3& low() const { return low_; }
  const btVector3& high() const { return high_; }

  /// Where the owner is when the points are where `positions` says: once it has been moved, the points will be.
  void setPose(const btTransform& pose) { pose_ = pose; }

  const std::vector<std::uint32_t>& springs() const { return springs_; }

  void getAabb(const btTransform& t, btVector3& aabbMin, btVector3& aabbMax) const override;
  void processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                           const btVector3& aabbMax) const override;

  void setLocalScaling(const btVector3&) override {}  ///< a soft body has its scale in its settings
  const btVector3& getLocalScaling() const override { return scaling_; }
  void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
  const char* getName() const override { return "SoftSurface"; }

 private:
  struct Query;
  btVector3 local(std::uint32_t point) const;
  void reportStrips(const Query& query) const;

  const SpringNetwork* network_;
  bool mirrored_;
  const Points* positions_;
  std::vector<std::uint32_t> springs_;  ///< those that are shown as strips
  btVector3 low_ = btVector3(0, 0, 0), high_ = btVector3(0, 0, 0);
  btTransform pose_ = btTransform::getIdentity();
  btVector3 scaling_ = btVector3(1, 1, 1);
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
