// SPDX-License-Identifier: Zlib

// This header declares the geometry of rigid objects for contacts with soft bodies: surfaces of shapes, which
// are cached across ticks; surfaces of rigid objects in a tick; pieces of static and kinematic objects.

#pragma once

#include "collide/surface.h"
#include "solver/links.h"
#include "solver/plane_contacts.h"

#include <limber/bullet_precision.h>

#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- surfaces of shapes ------------------------------------------------------------------------------------

/// The surface of a convex Bullet shape as vertices, edges and triangles with a radius around them, in the
/// shape's coordinates. A sphere is one vertex, a capsule one edge. Boxes and hulls are polyhedra. Other
/// round shapes (cylinders, cones, ...) are approximated by polyhedra. A GImpact mesh is a sheet of
/// triangles.
struct ShapeSurface {
  SurfaceTopology topology;
  double radius = 0.0;                    ///< m
  std::vector<std::uint32_t> sharpEdges;  ///< those that are not flat
  double sideRadius = 0.0;                ///< m, of a cylinder, 0 of others
  std::vector<std::uint8_t> sideEdges;    ///< #edges, of a cylinder: those on its side
};

/// A box in a shape's coordinates. Empty at first.
struct LocalBox {
  btVector3 low = btVector3(1, 1, 1), high = btVector3(0, 0, 0);
};

/// Returns the smallest such box around a box in the world with the corners `low` and `high` (m).
LocalBox localBoxOf(const btTransform& pose, const Eigen::Vector3d& low, const Eigen::Vector3d& high);

template <class Visit>
void forEachLeafIn(const btDbvtVolume& box, const btDbvtNode* node, Visit visit) {
  if (!node || !Intersect(node->volume, box)) return;
  if (node->isleaf()) return visit(node->dataAsInt);
  for (const int i : {1, 0}) forEachLeafIn(box, node->childs[i], visit);
}

/// Calls visit(index) for the children of a compound whose boxes overlap `box`.
template <class Visit>
void forEachChildIn(const LocalBox& box, const btCompoundShape& compound, Visit visit) {
  const btDbvtVolume volume = btDbvtVolume::FromMM(box.low, box.high);
  if (const btDbvt* tree = compound.getDynamicAabbTree()) return forEachLeafIn(volume, tree->m_root, visit);
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    btVector3 low, high;
    compound.getChildShape(i)->getAabb(compound.getChildTransform(i), low, high);
    if (Intersect(volume, btDbvtVolume::FromMM(low, high))) visit(i);
  }
}

/// Returns a number that differs between convex objects, and changes with the object's shape. Objects and
/// shapes may be changed, or deleted and replaced at the same address, and some broadphases reuse their ids.
/// 0: not convex.
std::uint64_t stampOf(const btCollisionObject& object);

/// Caches the surfaces of convex shapes near soft bodies until they have not been used for a long time. A
/// hash detects, once a tick, a shape that was changed, or deleted and replaced at the same address. Any
/// thread may call surfaceOf() and lockMesh().
class ShapeCache {
 public:
  const ShapeSurface& surfaceOf(const btCollisionShape& shape);

  /// Returns a lock to hold while the triangles of a shape are read. Bullet counts the readers of a GImpact
  /// mesh, not for several threads; for other shapes nothing is locked.
  std::unique_lock<std::mutex> lockMesh(const btCollisionShape& shape);

  /// Removes the surfaces that have not been used for a long time. Call it before a tick, when no surface is
  /// in use.
  void forgetOld();

 private:
  struct Entry {
    std::uint64_t hash = 0;
    std::unique_ptr<ShapeSurface> surface;
    std::uint64_t lastUsed = 0;
  };

  std::mutex mutex_;
  std::unordered_map<const btCollisionShape*, Entry> entries_;
  std::uint64_t tick_ = 0;
};

// --- surfaces of objects in a tick -------------------------------------------------------------------------

/// A convex part of a rigid object in the present tick.
struct RigidPart {
  std::uint64_t number = 0;  ///< index of the part in the object, the same in every tick
  const ShapeSurface* surface = nullptr;
  Points position, motion;  ///< m, 3 x #points
  Points start, whole;      ///< m, 3 x #points, position and motion at the start of the tick; see movePart()
  bool moved = false;       ///< since the start of the tick
  SurfaceBoxes boxes;
  MovingSurface moving;  ///< a view of the above
};

/// Moves the part of a body within a step: the body moved from `from` to `to`. Sets its motion to that of the
/// coming `ahead` seconds.
void movePart(RigidPart& part, const btTransform& from, const RigidState& to, double ahead);
/// Moves the part of a kinematic object to the fraction `share` of the tick. Sets its motion to that of the
/// coming fraction `ahead`.
void movePart(RigidPart& part, double share, double ahead);

/// The surfaces of the rigid objects near soft bodies in a tick. Convex objects and GImpact meshes have one
/// part, compounds one per such child; planes and static meshes have none. A part is made when a body comes
/// near it, once per tick.
class RigidSurfaces {
 public:
  explicit RigidSurfaces(ShapeCache& shapes) : shapes_(&shapes) {}

  bool hasParts(const btCollisionShape& shape);

  /// Returns the part of a convex object, or those parts of a compound that can touch the box in this tick,
  /// in the order of its children. Valid until the next call.
  const std::vector<RigidPart*>& partsNear(const btCollisionObject& object, const SweptBox& box, double tick);

  /// Returns the number of parts made in this tick.
  std::size_t size() const { return used_; }

  /// Removes the objects but keeps the memory. Call it before a tick.
  void clear();

 private:
  struct NumberedPart {
    std::uint64_t number;
    RigidPart* part;
  };
  void addNear(const btCollisionObject& object, const btCollisionShape& shape, const btTransform& pose,
               std::uint64_t number, const SweptBox& box, double tick);
  void addPart(const btCollisionObject& object, const btCollisionShape& shape, const btTransform& pose,
               std::uint64_t number, double tick);

  ShapeCache* shapes_;
  std::deque<RigidPart> parts_;  // of any tick: their memory is reused
  std::size_t used_ = 0;
  std::vector<std::vector<NumberedPart>> partsOfObject_;  // by world index of the object; sorted
  std::vector<std::size_t> usedIndices_;                  // of partsOfObject_
  std::vector<RigidPart*> near_;
  std::vector<int> children_;  // scratch of partsNear
};

// --- concave objects ---------------------------------------------------------------------------------------

/// The triangles of a concave static object around a body. They are kept while the body stays in the box and
/// they stay the same.
struct ConcavePatch {
  LocalBox box;            ///< m, in the object's coordinates: the patch has all triangles that overlap it
  btTransform pose;        ///< of the object when it was made
  std::uint64_t hash = 0;  ///< of the triangles
  ShapeSurface surface;
  RigidPart part;  ///< a view of `surface`
};

/// Returns the triangles of a static or kinematic object around the box (m) in this tick, or nullptr if there
/// are none. Makes them again when the box or the object has moved away, or the triangles have changed.
RigidPart* trianglesIn(const SweptBox& box, const btCollisionObject& object, ConcavePatch& patch);

// --- static and kinematic objects --------------------------------------------------------------------------

/// Returns the piece of a convex solid, but not of a hull, or of an object whose shape is one. Owner 0.
std::optional<HeldPiece> solidOf(const btCollisionShape& shape, const btTransform& pose);
std::optional<HeldPiece> solidOf(const btCollisionObject& object);

/// Finds the nearest point on any convex shape by Bullet's GJK. Returns false if `x` (m) is inside the shape
/// without its margin. Nearer to that than a millimetre, btGjkPairDetector ends before it has the nearest
/// point.
bool findNearestOutside(const btConvexShape& shape, const btTransform& pose, const Eigen::Vector3d& x,
                        HeldPoint& nearest);

/// Finds it exactly on a convex polyhedron. Returns false if the shape has no faces within `reach` (m).
/// Leaves `scratch` as it was.
bool findNearestOnFaces(const btConvexShape& shape, const btTransform& pose, ShapeCache& shapes,
                        const Eigen::Vector3d& x, double reach, std::vector<HeldPiece>& scratch,
                        HeldPoint& nearest);

constexpr std::size_t kNoLimit = static_cast<std::size_t>(-1);

/// Adds the pieces of an object's shape in a box (m, in the world): convex solids whole, hulls of many faces
/// and sheets as triangles. Each solid and each sheet is one owner, numbered from `owner` on. Returns the
/// next number. Stops at about `limit` pieces.
std::uint32_t addPieces(const btCollisionObject& object, const Eigen::AlignedBox3d& box, ShapeCache& shapes,
                        std::uint32_t owner, std::vector<HeldPiece>& pieces, std::size_t limit = kNoLimit);

/// Returns whether the pieces are flat within `searchRegion` of their points nearest to `x`, or farther away
/// than that. `radius` is that of the point at x.
bool areFlatAround(const HeldPiece* begin, const HeldPiece* end, const Eigen::Vector3d& x, double radius,
                   double searchRegion, std::vector<std::uint64_t>& keys);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
