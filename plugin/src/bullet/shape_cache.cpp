// SPDX-License-Identifier: Zlib
#include "bullet/shape_cache.h"

#include <cstring>
#include <iterator>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

namespace {

void addVector(std::uint64_t& hash, const btVector3& v) {
  for (int i = 0; i < 3; ++i) {
    const double value = double(v[i]);
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    addToHash(hash, bits);
  }
}

/// Tells round shapes with one bounding box from each other, as cylinders along different axes.
void addSupports(std::uint64_t& hash, const btConvexShape& shape) {
  for (int i = 0; i < 8; ++i)
    addVector(hash, shape.localGetSupportingVertex(btVector3(i & 1 ? btScalar(1) : btScalar(-1),
                                                             i & 2 ? btScalar(0.8) : btScalar(-0.8),
                                                             i & 4 ? btScalar(0.6) : btScalar(-0.6))));
}

void addCorners(std::uint64_t& hash, const btPolyhedralConvexShape& shape) {
  for (int i = 0; i < shape.getNumVertices(); ++i) {
    btVector3 corner;
    shape.getVertex(i, corner);
    addVector(hash, corner);
  }
}

}  // namespace

std::uint64_t hashOfShape(const btCollisionShape& shape) {
  std::uint64_t hash = static_cast<std::uint64_t>(shape.getShapeType());
  btVector3 low, high;
  shape.getAabb(btTransform::getIdentity(), low, high);
  for (const btVector3& v : {low, high, btVector3(shape.getMargin(), 0, 0)}) addVector(hash, v);
  const int type = shape.getShapeType();
  // all is in the bounding box
  if (type == BOX_SHAPE_PROXYTYPE || type == SPHERE_SHAPE_PROXYTYPE || !shape.isConvex()) return hash;
  const bool cornersKnown =
      shape.isPolyhedral() && static_cast<const btPolyhedralConvexShape&>(shape).getNumVertices() > 0;
  if (cornersKnown)
    addCorners(hash, static_cast<const btPolyhedralConvexShape&>(shape));
  else
    addSupports(hash, static_cast<const btConvexShape&>(shape));
  return hash;
}

const ShapeSurface& ShapeCache::surfaceOf(const btCollisionShape& shape) {
  Entry& entry = entries_[&shape];
  entry.lastUsed = tick_;
  const std::uint64_t hash = hashOfShape(shape);
  if (!entry.surface || entry.hash != hash) {
    entry.hash = hash;
    entry.surface = std::make_unique<ShapeSurface>(makeShapeSurface(shape));
  }
  return *entry.surface;
}

void ShapeCache::forgetOld() {
  constexpr std::uint64_t kLongTime = 512;
  if (++tick_ % kLongTime != 0) return;
  for (auto it = entries_.begin(); it != entries_.end();)
    it = it->second.lastUsed + kLongTime < tick_ ? entries_.erase(it) : std::next(it);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
