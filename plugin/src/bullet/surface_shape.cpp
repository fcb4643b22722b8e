// SPDX-License-Identifier: Zlib
#include "bullet/surface_shape.h"

#include "bullet/bullet_objects.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SurfaceShape::Query {
  btTriangleCallback* callback;
  btVector3 low, high;

  void offer(const btVector3& a, const btVector3& b, const btVector3& c, std::size_t index) const {
    btVector3 corners[3] = {a, b, c}, least = a, most = a;
    for (const btVector3& corner : {b, c}) least.setMin(corner), most.setMax(corner);
    if (TestAabbAgainstAabb2(least, most, low, high))
      callback->processTriangle(corners, 0, static_cast<int>(index));
  }
};

SurfaceShape::SurfaceShape(const SpringNetwork& network, bool mirrored, const Points& positions,
                           btScalar radius)
    : network_(&network), mirrored_(mirrored), positions_(&positions) {
  // not CUSTOM_CONCAVE_SHAPE_TYPE: Bullet takes that for a btSdfCollisionShape
  m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;
  setMargin(radius);
  if (!network.surface.empty()) return;
  for (std::uint32_t s = 0; s < network.springs.size(); ++s)
    if (network.springs[s].kind == SpringKind::Structural) springs_.push_back(s);
}

void SurfaceShape::getAabb(const btTransform& t, btVector3& aabbMin, btVector3& aabbMax) const {
  if (t.getBasis() == pose_.getBasis()) {
    const btVector3 shift = t.getOrigin() - pose_.getOrigin();
    aabbMin = low_ + shift;
    aabbMax = high_ + shift;
  } else {
    // of the box as it was, moved with the owner
    btTransformAabb(low_, high_, btScalar(0), t * pose_.inverse(), aabbMin, aabbMax);
  }
}

btVector3 SurfaceShape::local(std::uint32_t point) const {
  const Eigen::Vector3d origin = toEigen(pose_.getOrigin());
  return toBullet(Eigen::Vector3d(positions_->col(point) - origin)) * pose_.getBasis();
}

void SurfaceShape::processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                                       const btVector3& aabbMax) const {
  const btVector3 margin(getMargin(), getMargin(), getMargin());
  const Query query{callback, aabbMin - margin, aabbMax + margin};
  for (std::size_t t = 0; t < network_->surface.size(); ++t) {
    const Triangle& corners = network_->surface[t];
    const std::size_t second = mirrored_ ? 2 : 1;
    query.offer(local(corners[0]), local(corners[second]), local(corners[3 - second]), t);
  }
  if (!springs_.empty()) reportStrips(query);
}

void SurfaceShape::reportStrips(const Query& query) const {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const NetworkSpring& spring = network_->springs[springs_[s]];
    const btVector3 a = local(spring.a), b = local(spring.b), along = b - a;
    if (along.fuzzyZero()) continue;
    btVector3 sides[2];
    btPlaneSpace1(along.normalized(), sides[0], sides[1]);
    for (std::size_t i = 0; i < 2; ++i) {
      const btVector3 side = sides[i] * getMargin();
      query.offer(a - side, b - side, b + side, 4 * s + 2 * i);
      query.offer(a - side, b + side, a + side, 4 * s + 2 * i + 1);
    }
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
