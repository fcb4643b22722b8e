// SPDX-License-Identifier: Zlib

// This file tells what a surface meets of static and kinematic objects: the triangles of concave ones around
// a body, and the edges and corners that more than its points touch.

#include "bullet/bullet_objects.h"
#include "bullet/kinematic_motion.h"
#include "bullet/rigid_shapes.h"
#include "bullet/surface_gather.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

bool holds(const LocalBox& box, const LocalBox& other) {
  for (int i = 0; i < 3; ++i)
    if (other.low[i] < box.low[i] || other.high[i] > box.high[i]) return false;
  return true;
}

/// The box of the body's motion in the coordinates of the partner, at the start and the end of its own.
LocalBox boxIn(const btCollisionObject& partner, const SweptBox& world) {
  const Eigen::Vector3d low = world.low.head<3>(), high = world.high.head<3>();
  LocalBox box = localBoxOf(partner.getWorldTransform(), low, high);
  if (!isKinematic(partner)) return box;
  const LocalBox end = localBoxOf(partner.getInterpolationWorldTransform(), low, high);
  box.low.setMin(end.low), box.high.setMax(end.high);
  return box;
}

/// So much larger than the body it is made for that a body that slides or rolls needs a new one only now and
/// then.
LocalBox enlarged(const LocalBox& box) {
  const btVector3 more = btScalar(0.25) * (box.high - box.low);
  return {box.low - more, box.high + more};
}

ConcavePatch* findPatch(SoftBodyData& body, int partner) {
  std::deque<ConcavePatch>& patches = body.surface.patches;
  const auto isPartner = [&](const ConcavePatch& patch) { return patch.partner == partner; };
  const auto it = std::find_if(patches.begin(), patches.end(), isPartner);
  return it != patches.end() ? &*it : nullptr;
}

/// The patch of the last tick, or the memory of one that is no longer near.
ConcavePatch& patchOf(SoftBodyData& body, int partner) {
  ConcavePatch* patch = findPatch(body, partner);
  if (!patch) {
    patch = findPatch(body, 0);
    if (!patch) patch = &body.surface.patches.emplace_back();
    patch->partner = partner;
    patch->surface.topology.elements.clear();
    patch->low = btVector3(1, 1, 1), patch->high = btVector3(0, 0, 0);
  }
  patch->used = true;
  return *patch;
}

/// Where its triangles are at the start of the tick, and how they move in it.
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
  if (!patch.part || !holds({patch.low, patch.high}, box))
    makePatch(patch, partner, enlarged(box));
  else if (isKinematic(partner) || !(patch.pose == partner.getWorldTransform()))
    placePatch(patch, partner);
  return patch.surface.topology.elements.empty() ? nullptr : patch.part.get();
}

// --- where edges and triangles touch more than their corners do --------------------------------------------

namespace {

using Eigen::Vector3d;

/// Of the radius: how far an edge or triangle may be in a static surface on which all its corners rest. It
/// sinks into round ones between its corners.
constexpr double kSagging = 0.5;

/// Cosine between the normals of a contact and of those of the corners that bear for it.
constexpr double kSameSide = 0.9;

/// Whether edges and triangles sink into something round by less than kSagging where their corners rest on
/// it: no place is farther than c = L / sqrt(3) from a corner if the longest edge is L, and c^2 / (2 R) is
/// how deep that is under a sphere of radius R. Returns the largest L^2 (m^2).
double longestSquared(const MovingSurface& soft, double radius) {
  return 6.0 * kSagging * soft.radius * (radius + soft.radius);
}

/// By the partner itself, or a tile beside it, no farther away than `gap` (m).
bool isBorne(const SoftBodyData& body, std::uint32_t point, const Vector3d& normal, double gap) {
  const ContactRange rows = contactsOfPoint(body.contacts, point);
  for (std::size_t r = rows.begin; r < rows.end; ++r) {
    const PlaneContact& row = body.contacts[r];
    const bool isNear = row.normal.dot(body.state.position.col(point) - row.touch) <= gap;
    if (!row.away && isNear && row.normal.dot(normal) > kSameSide) return true;
  }
  return false;
}

/// The static objects around a contact of this body, as findContacts() sees them.
class HeldAround {
 public:
  HeldAround(const SoftBodyData& body, const Vector3d& place, double radius, std::vector<HeldPiece>& pieces)
      : pieces_(pieces), place_(place), radius_(radius) {
    pieces.clear();
    const Eigen::AlignedBox3d box(place.array() - radius, place.array() + radius);
    std::uint32_t owner = 0;
    for (const btCollisionObject* partner : body.partners)
      if (!isMoved(*partner)) owner = addPieces(*partner, box, *body.shapes, owner, pieces);
  }

  bool covers(const Vector3d& normal) const {
    return isCovered(pieces_.data(), pieces_.data() + pieces_.size(), place_, normal, radius_);
  }

  /// Whether the surface is flat there, or bends inward, whichever way across `normal` one looks.
  bool isFlat(const Vector3d& normal, const Vector3d& across) const {
    // rad: twice the least that covers() sees, for it may not have seen that `normal` is tilted by as much
    constexpr double kTilt = 0.14;
    return covers((normal + kTilt * across).normalized()) && covers((normal - kTilt * across).normalized());
  }

  /// m, radius of the cylinder whose side it is; 0: of none.
  double radiusAround(const Vector3d& normal) const {
    constexpr double kAlongAxis = 0.1, kOnSide = 0.01;  // cosine; share of the radius
    for (const HeldPiece& piece : pieces_) {
      if (piece.kind != HeldPiece::Kind::Cylinder) continue;
      const double radius = piece.size[0] + piece.margin;
      const bool isSide = std::abs(normal.dot(piece.axes.col(1))) < kAlongAxis;
      if (isSide && std::abs(nearestOn(&piece, &piece + 1, place_).height) < kOnSide * radius) return radius;
    }
    return 0.0;
  }

 private:
  std::vector<HeldPiece>& pieces_;
  Vector3d place_;
  double radius_;
};

/// The same of the edge or triangle that touches a cylinder's side. The polyhedron that stands for it has
/// edges, which brake.
bool staysCloseToRound(const MovingSurface& soft, const SurfaceContact& c, double radius) {
  double longest = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    longest = std::max(
        longest,
        (soft.position->col(c.a.points[i]) - soft.position->col(c.a.points[(i + 1) % 3])).squaredNorm());
  return longest <= longestSquared(soft, radius);
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
  const double most = longestSquared(soft, part.surface->radius);
  const auto& edges = soft.topology->edges;
  return std::all_of(edges.begin(), edges.end(), [&](const Edge& e) {
    return (soft.position->col(e[1]) - soft.position->col(e[0])).squaredNorm() <= most;
  });
}

bool cornersCarryContact(const SoftBodyData& body, const SurfaceContact& c, double margin) {
  const double radius = double(body.masses.shape->getRadius());
  if (c.gap < -kSagging * radius) return false;
  for (const std::uint32_t point : c.a.points)
    if (!isBorne(body, point, c.normal, std::max(c.gap, 0.0) + margin)) return false;
  return true;
}

bool isInternalEdge(const SoftBodyData& body, const MovingSurface& soft, const RigidPart& part,
                    const SurfaceContact& c, SurfaceSearch& s) {
  const Vector3d place = positionOf(part.moving, c.b) + part.moving.radius * c.normal;
  const HeldAround around(body, place, soft.radius, s.pieces);
  if (around.covers(c.normal)) return true;
  if (const double rounded = around.radiusAround(c.normal);
      rounded > 0.0 && staysCloseToRound(soft, c, rounded))
    return true;
  const Vector3d u = c.normal.unitOrthogonal(), v = c.normal.cross(u);
  if (c.b.kind != FeatureKind::OnEdge) return around.isFlat(c.normal, u) && around.isFlat(c.normal, v);
  const Vector3d along = part.moving.position->col(c.b.points[1]) - part.moving.position->col(c.b.points[0]);
  return around.isFlat(c.normal, c.normal.cross(along).normalized());
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
