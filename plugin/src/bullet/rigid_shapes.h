// SPDX-License-Identifier: Zlib

// Soft bodies touch Bullet's shapes by these: surfaces of shapes, which are kept from tick to tick, surfaces
// of rigid objects in a tick, and pieces of static and kinematic objects.

#pragma once

#include "collide/surface.h"
#include "solver/held_surface.h"
#include "solver/links.h"

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <deque>
#include <memory>
#include <unordered_map>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- surfaces of shapes ------------------------------------------------------------------------------------

/// The surface of a convex shape of Bullet's as vertices, edges and triangles with a radius around them, in
/// the shape's own coordinates: a sphere is one vertex, a capsule one edge, boxes and hulls are polyhedra,
/// and what is round otherwise (cylinders, cones, ...) is a polyhedron close to it.
struct ShapeSurface {
  SurfaceTopology topology;
  double radius = 0.0;                    ///< m
  std::vector<std::uint32_t> sharpEdges;  ///< those that are not flat
};

/// The triangles of a concave shape that overlap a box in the shape's own coordinates, two-sided; corners in
/// the same place are one vertex.
ShapeSurface makePatchSurface(const btConcaveShape& shape, const btVector3& low, const btVector3& high);

/// A box in a shape's own coordinates.
struct LocalBox {
  btVector3 low, high;
};

/// The one that holds a box of the world; `low` and `high` (m) are that box's corners.
LocalBox localBoxOf(const btTransform& pose, const Eigen::Vector3d& low, const Eigen::Vector3d& high);

inline void addToHash(std::uint64_t& hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
  hash ^= hash >> 29;
}

/// Of everything that makes a convex shape what it is now: type, margin, and corners, scaling included.
std::uint64_t hashOfShape(const btCollisionShape& shape);

/// The surfaces of convex shapes that soft bodies have come near, until nobody asks for them any more. A
/// shape that has been changed, or deleted and another one made in its place, is seen by its hash.
class ShapeCache {
 public:
  const ShapeSurface& surfaceOf(const btCollisionShape& shape);

  /// Before a tick, when nobody holds a surface: forgets those that nobody has asked for in a long time.
  void forgetOld();

 private:
  struct Entry {
    std::uint64_t hash = 0;
    std::unique_ptr<ShapeSurface> surface;
    std::uint64_t lastUsed = 0;
  };

  std::unordered_map<const btCollisionShape*, Entry> entries_;
  std::uint64_t tick_ = 0;
};

// --- surfaces of objects in a tick -------------------------------------------------------------------------

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

  /// The only part of a convex object; of a compound those that can meet the box in this tick, by the order
  /// of its children. Valid until the next call.
  const std::vector<RigidPart*>& partsNear(const btCollisionObject& object, const SweptBox& box, double tick);

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

// --- concave objects ---------------------------------------------------------------------------------------

/// The part of a concave static object that is around a body. It is kept while the body stays within it.
struct ConcavePatch {
  int partner = 0;      ///< unique id in the broadphase; 0: none
  bool used = false;    ///< in the present tick
  btTransform pose;     ///< of the partner when it was made
  btVector3 low, high;  ///< m, of the partner's coordinates: all triangles in there
  ShapeSurface surface;
  std::unique_ptr<RigidPart> part;  ///< a view of it
};

// --- static and kinematic objects --------------------------------------------------------------------------

/// Whether a static or kinematic object moves in this tick; while kinematic ones are Rewound.
bool isMoved(const btCollisionObject& object);

/// Adds what an object's shape has in a box (m, in the world): convex solids as a whole, hulls of many faces
/// and sheets by triangles. Each solid is an owner of its own, numbered from `owner` on, and so is each
/// sheet. Returns the next number.
std::uint32_t addPieces(const btCollisionObject& object, const Eigen::AlignedBox3d& box, ShapeCache& shapes,
                        std::uint32_t owner, std::vector<HeldPiece>& pieces);

/// Whether the pieces are flat within `searchRegion` of the place on each that is nearest to `x`, or farther
/// away than that; `radius` is that of the point at x.
bool areFlatAround(const HeldPiece* begin, const HeldPiece* end, const Eigen::Vector3d& x, double radius,
                   double searchRegion);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
