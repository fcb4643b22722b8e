// SPDX-License-Identifier: Zlib
#include "bullet/shape_cache.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

ShapeCache::Look ShapeCache::lookOf(const btCollisionShape& shape) {
  Look look;
  look.type = shape.getShapeType();
  look.margin = shape.getMargin();
  shape.getAabb(btTransform::getIdentity(), look.low, look.high);
  if (shape.isPolyhedral())
    look.vertices = static_cast<const btPolyhedralConvexShape&>(shape).getNumVertices();
  return look;
}

const ShapeSurface& ShapeCache::surfaceOf(const btCollisionShape& shape) {
  Entry& entry = entries_[&shape];
  const Look look = lookOf(shape);
  const bool same = entry.surface && entry.look.type == look.type && entry.look.vertices == look.vertices &&
                    entry.look.margin == look.margin && entry.look.low == look.low &&
                    entry.look.high == look.high;
  if (!same) {
    entry.look = look;
    entry.surface = std::make_unique<ShapeSurface>(makeShapeSurface(shape));
  }
  return *entry.surface;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
