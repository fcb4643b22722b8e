// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/shape_cache.h"
#include "collide/surface.h"
#include "solver/links.h"

#include <deque>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A convex part of a rigid object in the present tick.
struct RigidPart {
  std::uint64_t number = 0;  ///< which part of the object it is, the same in every tick
  const ShapeSurface* surface = nullptr;
  Points position, motion;  ///< m, 3 x #points
  Points start, whole;      ///< m, 3 x #points, position and motion as the tick began; see movePart()
  bool moved = false;       ///< since then
  SurfaceBoxes boxes;
  MovingSurface moving;  ///< a view of the above
};

/// Within a step: the part of a body that has come from `from` to `to`, and its motion of the coming `ahead`
/// seconds.
void movePart(RigidPart& part, const btTransform& from, const RigidState& to, double ahead);
/// Of an object that moves as told: at `share` of the tick, and its motion of the coming `ahead` shares.
void movePart(RigidPart& part, double share, double ahead);

/// The surfaces of the rigid objects near soft bodies in a tick. A convex object has one part, a compound one
/// for each convex child; planes and concave shapes have none. A part is made when something comes near it,
/// and once a tick.
class RigidSurfaces {
 public:
  explicit RigidSurfaces(ShapeCache& shapes) : shapes_(&shapes) {}

  /// Whether the shape has any parts at all.
  bool hasParts(const btCollisionShape& shape);

  /// The only part of a convex object; of a compound those that can meet the box in this tick, by the order of
  /// its children. Valid until the next call.
  const std::vector<RigidPart*>& partsNear(const btCollisionObject& object, const SweptBox& box,
                                                 double tick);

  /// How many parts were made in this tick.
  std::size_t size() const { return used_; }

  /// Before a tick: forgets the objects, not the memory.
  void clear();

 private:
  struct Known {
    std::uint64_t number;
    RigidPart* part;
  };
  void addNear(const btCollisionObject& object, const btCollisionShape& shape, const btTransform& pose,
               std::uint64_t number, const SweptBox& box, double tick);
  void addPart(const btCollisionObject& object, const btCollisionShape& shape, const btTransform& pose,
               std::uint64_t number, double tick);
  RigidPart& makePart(const btCollisionObject& object, const ShapeSurface& surface, const btTransform& pose,
                      double tick);

  ShapeCache* shapes_;
  std::deque<RigidPart> parts_;  // of any tick: their memory is kept
  std::size_t used_ = 0;
  std::vector<std::vector<Known>> known_;  // of this tick, sorted, by place in the world's list of objects
  std::vector<std::size_t> asked_;         // places
  std::vector<RigidPart*> near_;
  std::vector<int> children_;  // scratch of partsNear
  btAlignedObjectArray<const btDbvtNode*> stack_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
