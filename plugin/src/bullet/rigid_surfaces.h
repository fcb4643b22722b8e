// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/shape_cache.h"
#include "core/surface_tree.h"

#include <deque>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A convex part of a rigid object in the present tick.
struct RigidPart {
  const ShapeSurface* surface = nullptr;
  Points position, motion;  ///< m, 3 x #points
  SurfaceBoxes boxes;
  MovingSurface moving;  ///< a view of the above
};

/// The surfaces of the rigid objects near soft bodies in a tick: each is worked out when it is first asked
/// for. Compounds have a part for each convex child; planes and concave shapes have none.
class RigidSurfaces {
 public:
  explicit RigidSurfaces(ShapeCache& shapes) : shapes_(&shapes) {}

  /// The numbers of the object's parts.
  struct Range {
    std::size_t begin = 0, end = 0;
  };
  Range partsOf(const btCollisionObject& object, double tick);
  const RigidPart& part(std::size_t number) const { return parts_[number]; }

  /// Before a tick: forgets the objects, not the memory.
  void clear();

 private:
  void addParts(const btCollisionObject& object, const btCollisionShape& shape, const btTransform& pose,
                double tick);
  void addPart(const btCollisionObject& object, const ShapeSurface& surface, const btTransform& pose,
               double tick);

  ShapeCache* shapes_;
  std::deque<RigidPart> parts_;  // of any tick: their memory is kept
  std::size_t used_ = 0;
  std::vector<Range> known_;        // by place in the world's list of objects; empty: not asked for
  std::vector<std::size_t> asked_;  // places
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
