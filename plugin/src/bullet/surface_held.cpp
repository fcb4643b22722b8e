// SPDX-License-Identifier: Zlib

// This file helps to find the contacts of surfaces with static and kinematic objects: the triangles of
// concave objects around a body, and tests of contacts with edges and corners that the contacts of the points
// do not cover.

#include "bullet/bullet_objects.h"
#include "bullet/kinematic_motion.h"
#include "bullet/rigid_shapes.h"
#include "bullet/surface_gather.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

bool contains(const LocalBox& box, const LocalBox& other) {
  for (int i = 0; i < 3; ++i)
    if (other.low[i] < box.low[i] || other.high[i] > box.high[i]) return false;
  return true;
}

/// Returns the box of the body's motion in the partner's coordinates, for the partner's poses at the start
/// and the end of the tick.
LocalBox boxIn(const btCollisionObject& partner, const SweptBox& world) {
  const Eigen::Vector3d low = world.low.head<3>(), high = world.high.head<3>();
  LocalBox box = localBoxOf(partner.getWorldTransform(), low, high);
  if (!isKinematic(partner)) return box;
  const LocalBox endBox = localBoxOf(partner.getInterpolationWorldTransform(), low, high);
  box.low.setMin(endBox.low), box.high.setMax(endBox.high);
  return box;
}

/// Returns a box with a margin, so that a body that slides or rolls rarely needs a new patch.
LocalBox enlarged(const LocalBox& box) {
  const btVector3 margin = btScalar(0.25) * (box.high - box.low);
  return {box.low - margin, box.high + margin};
}

ConcavePatch* findPatch(SoftBodyData& body, int partner) {
  const auto& patches = body.surface.patches;
  const auto isPartner = [&](const auto& patch) { return patch->partner == partner; };
  const auto it = std::find_if(patches.begin(), patches.end(), isPartner);
  return it != patches.end() ? it->get() : nullptr;
}

/// Returns the patch of the last tick, or an empty one in the memory of one that is no longer near.
ConcavePatch& patchOf(SoftBodyData& body, int partner) {
  ConcavePatch* patch = findPatch(body, partner);
  if (!patch) {
    patch = findPatch(body, 0);
    if (!patch) patch = body.surface.patches.emplace_back(std::make_unique<ConcavePatch>()).get();
    patch->partner = partner;
    patch->surface.topology.elements.clear();
    patch->low = btVector3(1, 1, 1), patch->high = btVector3(0, 0, 0);
  }
  patch->used = true;
  return *patch;
}

/// Sets the positions of the patch's triangles at the start of the tick, and their motion in it.
void placePatch(ConcavePatch& patch, const btCollisionObject& partner) {
  const btTransform& pose = partner.getWorldTransform();
  patch.pose = pose;
  RigidPart& part = *patch.part;
  part.moved = false;
  const Points& rest = patch.surface.topology.rest;
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    part.position.col(i) = toEigen(pose * toBullet(Eigen::Vector3d(rest.col(i))));
    part.motion.col(i) = kinematicDisplacement(partner, part.position.col(i));
  }
  fitBoxes(part.moving, part.boxes);
}

void makePatch(ConcavePatch& patch, const btCollisionObject& partner, const LocalBox& box) {
  patch.low = box.low, patch.high = box.high;
  patch.surface =
      makePatchSurface(*static_cast<const btConcaveShape*>(partner.getCollisionShape()), box.low, box.high);
  if (!patch.part) patch.part = std::make_unique<RigidPart>();
  RigidPart& part = *patch.part;
  const Points& rest = patch.surface.topology.rest;
  part.surface = &patch.surface;
  part.position.resize(3, rest.cols());
  part.motion.resize(3, rest.cols());
  part.moving = {&patch.surface.topology, &part.position, &part.motion, patch.surface.radius, &part.boxes};
  placePatch(patch, partner);
}

}  // namespace

RigidPart* patchAround(SoftBodyData& body, const btCollisionObject& partner, const MovingSurface& soft) {
  if (soft.boxes->nodes.empty()) return nullptr;
  const LocalBox box = boxIn(partner, soft.boxes->nodes[0]);
  ConcavePatch& patch = patchOf(body, partner.getBroadphaseHandle()->m_uniqueId);
  if (!patch.part || !contains({patch.low, patch.high}, box))
    makePatch(patch, partner, enlarged(box));
  else if (isKinematic(partner) || !(patch.pose == partner.getWorldTransform()))
    placePatch(patch, partner);
  return patch.surface.topology.elements.empty() ? nullptr : patch.part.get();
}

// --- contacts of edges and triangles that their corners do not cover ---------------------------------------

namespace {

using Eigen::Vector3d;

/// Fraction of the radius: the largest depth of an edge or triangle in a static surface on which all its
/// corners rest. It sinks into round surfaces between its corners.
constexpr double kMaxSagging = 0.5;

/// Smallest cosine between the normal of a contact and those of the corners' contacts that replace it.
constexpr double kMinSameSide = 0.9;

/// Returns the largest squared length (m^2) of edges that sink into a round surface by less than kMaxSagging
/// if their corners rest on it. If the longest edge has length L, no point is farther than c = L / sqrt(3)
/// from a corner, and its depth under a sphere of radius R is c^2 / (2 R).
double maxEdgeSquared(const MovingSurface& soft, double radius) {
  return 6.0 * kMaxSagging * soft.radius * (radius + soft.radius);
}

/// Returns whether the point has a contact of this direction with a gap of at most `gap` (m): with the
/// partner or an object beside it.
bool hasContactAlong(const SoftBodyData& body, std::uint32_t point, const Vector3d& normal, double gap) {
  const ContactRange rows = contactsOfPoint(body.contacts, point);
  for (std::size_t r = rows.begin; r < rows.end; ++r) {
    const PlaneContact& row = body.contacts[r];
    const bool isNear = row.normal.dot(body.state.position.col(point) - row.touch) <= gap;
    if (!row.away && isNear && row.normal.dot(normal) > kMinSameSide) return true;
  }
  return false;
}

/// The static objects around a contact of this body, as findContacts() finds them.
class StaticSurroundings {
 public:
  StaticSurroundings(const SoftBodyData& body, const Vector3d& position, double radius,
                     std::vector<HeldPiece>& pieces)
      : pieces_(pieces), position_(position), radius_(radius) {
    pieces.clear();
    const Eigen::AlignedBox3d box(position.array() - radius, position.array() + radius);
    std::uint32_t owner = 0;
    for (const btCollisionObject* partner : body.partners)
      if (!isMoved(*partner)) owner = addPieces(*partner, box, *body.shapes, owner, pieces);
  }

  bool covers(const Vector3d& normal) const {
    return isCovered(pieces_.data(), pieces_.data() + pieces_.size(), position_, normal, radius_);
  }

  /// Returns whether the surface is flat or concave on both sides in the direction `across`, which is normal
  /// to `normal`.
  bool isFlat(const Vector3d& normal, const Vector3d& across) const {
    // rad: twice the smallest tilt that covers() detects, because `normal` itself may have an undetected tilt
    // of that size
    constexpr double kTilt = 0.14;
    return covers((normal + kTilt * across).normalized()) && covers((normal - kTilt * across).normalized());
  }

  /// Returns the radius (m) of the cylinder whose side contains the contact; 0: there is none.
  double radiusAround(const Vector3d& normal) const {
    constexpr double kAlongAxis = 0.1, kOnSide = 0.01;  // cosine; fraction of the radius
    for (const HeldPiece& piece : pieces_) {
      if (piece.kind != HeldPiece::Kind::Cylinder) continue;
      const double radius = piece.size[0] + piece.margin;
      const bool isSide = std::abs(normal.dot(piece.axes.col(1))) < kAlongAxis;
      if (isSide && std::abs(nearestOn(&piece, &piece + 1, position_).height) < kOnSide * radius)
        return radius;
    }
    return 0.0;
  }

 private:
  std::vector<HeldPiece>& pieces_;
  Vector3d position_;
  double radius_;
};

/// Returns whether the edge or triangle that touches a cylinder's side sinks into it by little. The cylinder
/// is represented by a polyhedron, whose edges would brake the body.
bool staysCloseToRound(const MovingSurface& soft, const SurfaceContact& c, double radius) {
  double longest = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    longest = std::max(
        longest,
        (soft.position->col(c.a.points[i]) - soft.position->col(c.a.points[(i + 1) % 3])).squaredNorm());
  return longest <= maxEdgeSquared(soft, radius);
}

}  // namespace

bool hasSharpFeatureNear(const SweptBox& box, const RigidPart& part) {
  const SurfaceTopology& t = part.surface->topology;
  if (t.edges.empty()) return true;
  for (const std::uint32_t e : part.surface->sharpEdges) {
    const Edge& edge = t.edges[e];
    const SweptBox edgeBox = merged(part.boxes.points[edge[0]], part.boxes.points[edge[1]]);
    if (separation(box, edgeBox) <= 0.0) return true;
  }
  return false;
}

bool staysCloseToRound(const MovingSurface& soft, const RigidPart& part) {
  if (!part.surface->topology.triangles.empty()) return false;
  const double maxSquared = maxEdgeSquared(soft, part.surface->radius);
  const auto& edges = soft.topology->edges;
  return std::all_of(edges.begin(), edges.end(), [&](const Edge& e) {
    return (soft.position->col(e[1]) - soft.position->col(e[0])).squaredNorm() <= maxSquared;
  });
}

bool cornersCarryContact(const SoftBodyData& body, const SurfaceContact& c, double margin) {
  const double radius = double(body.masses.shape->getRadius());
  if (c.gap < -kMaxSagging * radius) return false;
  for (const std::uint32_t point : c.a.points)
    if (!hasContactAlong(body, point, c.normal, std::max(c.gap, 0.0) + margin)) return false;
  return true;
}

bool isInternalEdge(const SoftBodyData& body, const MovingSurface& soft, const RigidPart& part,
                    const SurfaceContact& c, SurfaceSearch& s) {
  const Vector3d position = positionOf(part.moving, c.b) + part.moving.radius * c.normal;
  const StaticSurroundings around(body, position, soft.radius, s.pieces);
  if (around.covers(c.normal)) return true;
  if (const double cylinderRadius = around.radiusAround(c.normal);
      cylinderRadius > 0.0 && staysCloseToRound(soft, c, cylinderRadius))
    return true;
  const Vector3d u = c.normal.unitOrthogonal(), v = c.normal.cross(u);
  if (c.b.kind != FeatureKind::OnEdge) return around.isFlat(c.normal, u) && around.isFlat(c.normal, v);
  const Vector3d along = part.moving.position->col(c.b.points[1]) - part.moving.position->col(c.b.points[0]);
  return around.isFlat(c.normal, c.normal.cross(along).normalized());
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
