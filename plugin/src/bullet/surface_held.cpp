// SPDX-License-Identifier: Zlib

// This file tells which contacts of surfaces with static and kinematic objects count: those with edges and
// corners that the contacts of the points do not cover.

#include "bullet/bullet_objects.h"
#include "bullet/kinematic_motion.h"
#include "bullet/rigid_shapes.h"
#include "bullet/surface_gather.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
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

namespace {

/// Returns whether contacts of the corners replace the contact `c` of an edge or triangle.
bool cornersCarryContact(const SoftBodyData& body, const SurfaceContact& c, double margin) {
  const double radius = radiusOf(body);
  return c.gap >= -kMaxSagging * radius &&
         std::all_of(c.a.points.begin(), c.a.points.end(), [&](std::uint32_t point) {
           return hasContactAlong(body, point, c.normal, std::max(c.gap, 0.0) + margin);
         });
}

/// Returns whether other objects cover the touched edge or corner of the part.
bool isInternalEdge(const SurfaceCandidate& m, const SurfaceContact& c, SurfaceSearch& s) {
  const MovingSurface &soft = m.body->surface.moving, &rigid = m.part->moving;
  const Vector3d position = positionOf(rigid, c.b) + rigid.radius * c.normal;
  const StaticSurroundings around(*m.body, position, soft.radius, s.pieces);
  if (around.covers(c.normal)) return true;
  if (const double cylinderRadius = around.radiusAround(c.normal);
      cylinderRadius > 0.0 && staysCloseToRound(soft, c, cylinderRadius))
    return true;
  const Vector3d u = c.normal.unitOrthogonal(), v = c.normal.cross(u);
  if (c.b.kind != FeatureKind::OnEdge) return around.isFlat(c.normal, u) && around.isFlat(c.normal, v);
  const Vector3d along = rigid.position->col(c.b.points[1]) - rigid.position->col(c.b.points[0]);
  return around.isFlat(c.normal, c.normal.cross(along).normalized());
}

/// Returns the angular velocity (rad/s) of a kinematic object.
Vector3d spinOf(const btCollisionObject& object, double tick) {
  return rotationBetween(toEigen(object.getWorldTransform().getRotation()),
                         toEigen(object.getInterpolationWorldTransform().getRotation())) /
         tick;
}

}  // namespace

bool isHeldContact(const SurfaceCandidate& m, const SurfaceContact& c, double margin, SurfaceSearch& s) {
  if (c.a.kind == FeatureKind::OnVertex || cornersCarryContact(*m.body, c, margin)) return false;
  return isMoved(*m.held) || !isInternalEdge(m, c, s);
}

void setHeldSide(const SurfaceCandidate& m, const SurfaceContact& c, double seconds, double tick,
                 Contact& contact) {
  const double radiusSum = m.part->moving.radius + m.body->surface.moving.radius;
  if (isMoved(*m.held)) {
    Vector3d displacement = Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i)
      displacement += c.b.weights[static_cast<Eigen::Index>(i)] * m.part->motion.col(c.b.points[i]);
    contact.b.velocity = displacement / seconds + spinOf(*m.held, tick).cross(radiusSum * c.normal);
  } else if (c.b.kind != FeatureKind::OnTriangle) {
    contact.corners.count = c.b.kind == FeatureKind::OnEdge ? 2 : 1;
    for (std::size_t i = 0; i < 2; ++i) contact.corners.at[i] = m.part->moving.position->col(c.b.points[i]);
    contact.corners.radiusSum = radiusSum;
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
