// SPDX-License-Identifier: Zlib

// This file splits static and kinematic objects into pieces that points can touch, and finds where they are
// flat. It also tells which contacts of surfaces with these objects count: those with edges and corners that
// the contacts of the points do not cover.

#include "bullet/kinematic_motion.h"
#include "bullet/point_contacts.h"
#include "bullet/rigid_shapes.h"
#include "bullet/surface_gather.h"
#include "mesh/surface.h"

#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

// --- pieces ------------------------------------------------------------------------------------------------

using Eigen::Vector3d;
using Kind = HeldPiece::Kind;

/// Hulls of fewer faces are not culled.
constexpr std::size_t kMinFacesForCulling = 64;

HeldPiece pieceAt(Kind kind, const btTransform& pose, double margin) {
  HeldPiece piece;
  piece.kind = kind;
  piece.axes = toEigen(pose.getBasis()).colwise().normalized();
  piece.center = toEigen(pose.getOrigin());
  piece.margin = margin;
  return piece;
}

HeldPiece planePiece(const btStaticPlaneShape& plane, const btTransform& pose) {
  HeldPiece piece = pieceAt(Kind::Plane, pose, 0.0);
  piece.axes.col(1) = toEigen(pose.getBasis() * plane.getPlaneNormal()).normalized();
  piece.center = worldPoint(pose, toEigen(plane.getPlaneNormal() * plane.getPlaneConstant()));
  return piece;
}

HeldPiece boxPiece(const btBoxShape& box, const btTransform& pose) {
  HeldPiece piece = pieceAt(Kind::Box, pose, 0.0);
  piece.size = toEigen(box.getHalfExtentsWithMargin());
  return piece;
}

/// Returns a shape that is round about its own axis `axis`; `half` is half its height.
HeldPiece roundPiece(Kind kind, const btTransform& pose, double margin, int axis, double radius,
                     double half) {
  HeldPiece piece = pieceAt(kind, pose, margin);
  const Eigen::Matrix3d axes = piece.axes;
  for (int i = 0; i < 3; ++i) piece.axes.col(i) = axes.col((axis + i + 2) % 3);
  piece.size = {radius, half, radius};
  return piece;
}

HeldPiece cylinderPiece(const btCylinderShape& cylinder, const btTransform& pose) {
  const int axis = cylinder.getUpAxis();
  const btVector3 half = cylinder.getHalfExtentsWithoutMargin();
  return roundPiece(Kind::Cylinder, pose, double(cylinder.getMargin()), axis, double(half[axis == 0 ? 1 : 0]),
                    double(half[axis]));
}

/// Collects the pieces of one object in a box.
struct PieceCollector {
  const Eigen::AlignedBox3d& box;
  ShapeCache& shapes;
  std::uint32_t owner;
  std::vector<HeldPiece>& pieces;
  std::size_t limit = kNoLimit;  ///< of pieces.size(); what is beyond it is left out

  bool isFull() const { return pieces.size() >= limit; }

  void add(const btCollisionShape& shape, const btTransform& pose) {
    if (isFull()) return;
    if (const std::optional<HeldPiece> solid = solidOf(shape, pose)) return push(*solid);
    if (shape.isCompound()) return addChildren(static_cast<const btCompoundShape&>(shape), pose);
    if (shape.isConcave()) return addSheet(static_cast<const btConcaveShape&>(shape), pose);
    if (shape.isConvex()) addConvex(static_cast<const btConvexShape&>(shape), pose);
  }

  void push(const HeldPiece& solid) {
    pieces.push_back(solid);
    pieces.back().owner = owner++;
  }

  void addConvex(const btConvexShape& shape, const btTransform& pose) {
    const ShapeSurface& surface = shapes.surfaceOf(shape);
    if (!surface.topology.triangles.empty()) return addHull(surface, pose);
    if (shape.isPolyhedral()) addSegment(static_cast<const btPolyhedralConvexShape&>(shape), pose);
  }

  /// Adds a hull of one or two points.
  void addSegment(const btPolyhedralConvexShape& shape, const btTransform& pose) {
    const int count = shape.getNumVertices();
    if (count == 0) return;
    btVector3 from, to;
    shape.getVertex(0, from);
    shape.getVertex(count - 1, to);
    const Vector3d a = worldPoint(pose, toEigen(from)), b = worldPoint(pose, toEigen(to));
    HeldPiece piece = pieceAt(Kind::Capsule, pose, double(shape.getMargin()));
    piece.center = 0.5 * (a + b);
    piece.size = {0.0, 0.5 * (b - a).norm(), 0.0};
    if (piece.size[1] > 0.0) {
      piece.axes.col(0) = (b - a).unitOrthogonal();
      piece.axes.col(1) = (b - a).normalized();
    }
    push(piece);
  }

  /// Returns whether the hull has no volume.
  static bool isFlatHull(const SurfaceTopology& t) {
    constexpr double kFlatTolerance = 1e-6;  // fraction of its size
    const Triangle& first = t.triangles.front();
    const Vector3d a = t.rest.col(first[0]);
    const Vector3d normal = (t.rest.col(first[1]) - a).cross(t.rest.col(first[2]) - a).normalized();
    const double size = (t.rest.colwise() - a).colwise().norm().maxCoeff();
    return (normal.transpose() * (t.rest.colwise() - a)).cwiseAbs().maxCoeff() <= kFlatTolerance * size;
  }

  /// Adds a triangle, unless it has no area.
  void addTriangle(Kind kind, const Vector3d (&corners)[3], double margin) {
    const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    if (!(normal.squaredNorm() > 0.0)) return;
    HeldPiece& piece = pieces.emplace_back();
    piece.kind = kind;
    piece.owner = owner;
    for (int i = 0; i < 3; ++i) piece.axes.col(i) = corners[i];
    piece.center = normal.normalized();
    piece.margin = margin;
  }

  void addHull(const ShapeSurface& surface, const btTransform& pose) {
    const SurfaceTopology& t = surface.topology;
    const LocalBox own = localBoxOf(pose, box.min(), box.max());
    const Eigen::AlignedBox3d region(toEigen(own.low).array() - surface.radius,
                                     toEigen(own.high).array() + surface.radius);
    const bool all = t.triangles.size() < kMinFacesForCulling;
    const Kind kind = isFlatHull(t) ? Kind::Sheet : Kind::Face;
    const std::size_t before = pieces.size();
    for (const Triangle& corners : t.triangles) {
      Vector3d x[3];
      for (std::size_t i = 0; i < 3; ++i) x[i] = t.rest.col(corners[i]);
      if (!all && !region.intersects(Eigen::AlignedBox3d(x[0]).extend(x[1]).extend(x[2]))) continue;
      for (Vector3d& corner : x) corner = worldPoint(pose, corner);
      addTriangle(kind, x, surface.radius);
    }
    if (pieces.size() > before) ++owner;
  }

  void addChildren(const btCompoundShape& compound, const btTransform& pose) {
    forEachChildIn(localBoxOf(pose, box.min(), box.max()), compound,
                   [&](int i) { add(*compound.getChildShape(i), pose * compound.getChildTransform(i)); });
  }

  void addSheet(const btConcaveShape& shape, const btTransform& pose) {
    struct Visit final : btTriangleCallback {
      PieceCollector* self;
      const btTransform* pose;
      LocalBox own;
      double margin;
      void processTriangle(btVector3* triangle, int, int) override {
        if (self->isFull()) return;
        // height fields and some other shapes report whole cells
        if (!TestTriangleAgainstAabb2(triangle, own.low, own.high)) return;
        Vector3d corners[3];
        for (int i = 0; i < 3; ++i) corners[i] = worldPoint(*pose, toEigen(triangle[i]));
        self->addTriangle(Kind::Sheet, corners, margin);
      }
    } visit;
    visit.self = this, visit.pose = &pose, visit.margin = double(shape.getMargin());
    visit.own = localBoxOf(pose, box.min().array() - visit.margin, box.max().array() + visit.margin);
    const std::size_t before = pieces.size();
    const std::unique_lock<std::mutex> lock = shapes.lockMesh(shape);
    shape.processAllTriangles(&visit, visit.own.low, visit.own.high);
    if (pieces.size() > before) ++owner;
  }
};

// --- flat pieces -------------------------------------------------------------------------------------------

/// Returns whether the point of a solid that is nearest to x is on a flat face.
bool isFlatSolid(const HeldPiece& piece, const Vector3d& x, double searchRegion) {
  const Vector3d local = piece.axes.transpose() * (x - piece.center);
  if (piece.kind == Kind::Plane) return true;
  if (piece.kind == Kind::Box) {
    int axesOutside = 0;
    for (int i = 0; i < 3; ++i) axesOutside += std::abs(local[i]) + searchRegion > piece.size[i];
    return axesOutside == 1 && piece.margin == 0.0;
  }
  if (piece.kind != Kind::Cylinder) return false;
  return std::abs(local[1]) > piece.size[1] && std::hypot(local[0], local[2]) + searchRegion < piece.size[0];
}

bool isNearEdge(const Vector3d& from, const Vector3d& to, const Vector3d& x, double searchRegion) {
  const Vector3d nearest = from + nearestOnSegment(from, to, x) * (to - from);
  return (nearest - x).squaredNorm() < searchRegion * searchRegion;
}

std::uint64_t hashOf(const Vector3d& corner) {
  std::uint64_t hash = 0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double number = corner[i] + 0.0;  // of two zeros one
    std::uint64_t bits;
    std::memcpy(&bits, &number, sizeof bits);
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  return hash;
}

/// Adds hashes of the triangle's edges near x, the same for the triangle on the edge's other side.
void addNearEdges(const HeldPiece& t, const Vector3d& x, double searchRegion,
                  std::vector<std::uint64_t>& keys) {
  const std::uint64_t hashes[] = {hashOf(t.axes.col(0)), hashOf(t.axes.col(1)), hashOf(t.axes.col(2))};
  for (int edge = 0; edge < 3; ++edge) {
    int from = edge, to = (edge + 1) % 3;
    if (hashes[from] > hashes[to]) std::swap(from, to);  // near or not, regardless of rounding
    if (isNearEdge(t.axes.col(from), t.axes.col(to), x, searchRegion))
      keys.push_back(hashes[from] * 0xbf58476d1ce4e5b9u + hashes[to]);
  }
}

/// Returns whether each key occurs at least twice. Sorts them.
bool occurTwice(std::vector<std::uint64_t>& keys) {
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const bool isLikeLast = i > 0 && keys[i - 1] == keys[i];
    const bool isLikeNext = i + 1 < keys.size() && keys[i + 1] == keys[i];
    if (!isLikeLast && !isLikeNext) return false;
  }
  return true;
}

/// Returns whether x is on the triangle.
bool isOnTriangle(const HeldPiece& t, const Vector3d& x, double tolerance) {
  const Vector3d weights = nearestBarycentric({t.axes.col(0), t.axes.col(1), t.axes.col(2)}, x);
  return (t.axes * weights - x).squaredNorm() < tolerance * tolerance;
}

/// Returns whether the triangles lie in one plane and leave no gap around the foot of x. `keys` is scratch.
bool areFlatTriangles(const HeldPiece* begin, const HeldPiece* end, const Vector3d& x, double searchRegion,
                      std::vector<std::uint64_t>& keys) {
  constexpr double kFlatTolerance = 1e-7;  // m, and 1 - cosine
  const Vector3d normal = begin->center, foot = x - normal.dot(x - begin->axes.col(0)) * normal;
  bool isAbove = false;
  for (const HeldPiece* t = begin; t != end; ++t) {
    const double oneMinusCosine = 1.0 - std::abs(t->center.dot(normal)),
                 distance = t->center.dot(foot - t->axes.col(0));
    if (oneMinusCosine > kFlatTolerance || std::abs(distance) > kFlatTolerance) return false;
    isAbove = isAbove || isOnTriangle(*t, foot, kFlatTolerance);
  }
  if (!isAbove) return false;
  keys.clear();
  for (const HeldPiece* t = begin; t != end; ++t) addNearEdges(*t, foot, searchRegion, keys);
  return occurTwice(keys);
}

}  // namespace

std::optional<HeldPiece> solidOf(const btCollisionShape& shape, const btTransform& pose) {
  switch (shape.getShapeType()) {
    case STATIC_PLANE_PROXYTYPE:
      return planePiece(static_cast<const btStaticPlaneShape&>(shape), pose);
    case BOX_SHAPE_PROXYTYPE:
      return boxPiece(static_cast<const btBoxShape&>(shape), pose);
    case SPHERE_SHAPE_PROXYTYPE:
      return roundPiece(Kind::Capsule, pose, double(static_cast<const btSphereShape&>(shape).getRadius()), 1,
                        0.0, 0.0);
    case CAPSULE_SHAPE_PROXYTYPE: {
      const auto& capsule = static_cast<const btCapsuleShape&>(shape);
      return roundPiece(Kind::Capsule, pose, double(capsule.getRadius()), capsule.getUpAxis(), 0.0,
                        double(capsule.getHalfHeight()));
    }
    case CYLINDER_SHAPE_PROXYTYPE:
      return cylinderPiece(static_cast<const btCylinderShape&>(shape), pose);
    case CONE_SHAPE_PROXYTYPE: {
      const auto& cone = static_cast<const btConeShape&>(shape);
      return roundPiece(Kind::Cone, pose, double(shape.getMargin()), cone.getConeUpIndex(),
                        double(cone.getRadius()), 0.5 * double(cone.getHeight()));
    }
    default:
      return std::nullopt;
  }
}

std::optional<HeldPiece> solidOf(const btCollisionObject& object) {
  return solidOf(*object.getCollisionShape(), object.getWorldTransform());
}

bool findNearestOutside(const btConvexShape& shape, const btTransform& pose, const Vector3d& x,
                        HeldPoint& nearest) {
  constexpr double kResolution = 1e-5;  // of the distance from its centre
  static const btSphereShape kPoint(btScalar(0));
  btVoronoiSimplexSolver simplex;
  btGjkPairDetector detector(&kPoint, &shape, &simplex, nullptr);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = btTransform(btQuaternion::getIdentity(), toBullet(x));
  input.m_transformB = pose;
  btPointCollector found;
  detector.getClosestPoints(input, found, nullptr);
  const double fromCore = double(found.m_distance + shape.getMargin());
  if (!found.m_hasResult || fromCore < kResolution * (x - toEigen(pose.getOrigin())).norm()) return false;
  nearest = {toEigen(found.m_normalOnBInWorld).normalized(), double(found.m_distance), false};
  return true;
}

bool findNearestOnFaces(const btConvexShape& shape, const btTransform& pose, ShapeCache& shapes,
                        const Vector3d& x, double reach, std::vector<HeldPiece>& scratch,
                        HeldPoint& nearest) {
  const std::size_t before = scratch.size();
  const Eigen::AlignedBox3d box(x.array() - reach, x.array() + reach);
  PieceCollector{box, shapes, 0, scratch}.add(shape, pose);
  const bool any = scratch.size() > before;
  if (any) nearest = nearestOn(scratch.data() + before, scratch.data() + scratch.size(), x);
  scratch.resize(before);
  return any;
}

std::uint32_t addPieces(const btCollisionObject& object, const Eigen::AlignedBox3d& box, ShapeCache& shapes,
                        std::uint32_t owner, std::vector<HeldPiece>& pieces, std::size_t limit) {
  PieceCollector collector{box, shapes, owner, pieces, limit};
  collector.add(*object.getCollisionShape(), object.getWorldTransform());
  return collector.owner;
}

bool areFlatAround(const HeldPiece* begin, const HeldPiece* end, const Vector3d& x, double radius,
                   double searchRegion, std::vector<std::uint64_t>& keys) {
  for (const HeldPiece *first = begin, *next = begin; first != end; first = next) {
    if (first->kind == Kind::Sheet) {
      while (next != end && next->kind == Kind::Sheet && next->owner == first->owner) ++next;
      if (!areFlatTriangles(first, next, x, radius + searchRegion, keys)) return false;
      continue;
    }
    next = endOfSolid(first, end);
    if (isFlatSolid(*first, x, searchRegion)) continue;
    if (nearestOn(first, next, x).height <= radius + searchRegion) return false;
  }
  return true;
}

// --- contacts of edges and triangles that their corners do not cover ---------------------------------------

namespace {

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
  const Points& present = *body.surface.moving.position;  // within a step, body.state may be behind
  for (std::size_t r = rows.begin; r < rows.end; ++r) {
    const PlaneContact& row = body.contacts[r];
    const bool isNear = row.normal.dot(present.col(point) - row.touch) <= gap;
    if (!row.away && isNear && row.normal.dot(normal) > kMinSameSide) return true;
  }
  return false;
}

/// The static objects around a contact of this body, as findContacts() finds them.
class StaticSurroundings {
  static constexpr double kOnSide = 0.01;  // of the radius of a cylinder

 public:
  StaticSurroundings(const SoftBodyData& body, const TouchedPoint& touched, double radius,
                     std::vector<HeldPiece>& pieces)
      : pieces_(pieces), touched_(touched), radius_(radius) {
    pieces.clear();
    const Vector3d position = touched.onSurface();
    const Eigen::AlignedBox3d box(position.array() - radius, position.array() + radius);
    std::uint32_t owner = 0;
    for (const HeldPartner& held : body.heldPartners)
      if (!isMoved(held.object()) && isNear(held.box))
        owner = addPieces(held.object(), box, *body.shapes, owner, pieces);
  }

  bool covers(const Vector3d& normal) const {
    return isCovered(pieces_.data(), pieces_.data() + pieces_.size(), touched_, normal, radius_);
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
    constexpr double kAlongAxis = 0.1;  // cosine
    for (const HeldPiece& piece : pieces_) {
      if (piece.kind != HeldPiece::Kind::Cylinder) continue;
      const double radius = piece.size[0] + piece.margin;
      const bool isSide = std::abs(normal.dot(piece.axes.col(1))) < kAlongAxis;
      if (isSide && std::abs(nearestOn(&piece, &piece + 1, touched_.onSurface()).height) < kOnSide * radius)
        return radius;
    }
    return 0.0;
  }

 private:
  bool isNear(const Eigen::AlignedBox3d& box) const {
    const double reach = std::max(radius_, kOnSide * box.sizes().maxCoeff());
    const Vector3d position = touched_.onSurface();
    return box.intersects({position.array() - reach, position.array() + reach});
  }

  std::vector<HeldPiece>& pieces_;
  TouchedPoint touched_;
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

bool isRound(const RigidPart& part) { return part.surface->topology.triangles.empty(); }

/// Returns whether all edges sink into a round surface of this radius (m) by little between their corners.
bool staysCloseToRound(const MovingSurface& soft, double radius) {
  const double maxSquared = maxEdgeSquared(soft, radius);
  const auto& edges = soft.topology->edges;
  return std::all_of(edges.begin(), edges.end(), [&](const Edge& e) {
    return (soft.position->col(e[1]) - soft.position->col(e[0])).squaredNorm() <= maxSquared;
  });
}

}  // namespace

bool staysCloseToRound(const MovingSurface& soft, const RigidPart& part) {
  return isRound(part) && staysCloseToRound(soft, part.surface->radius);
}

Covered coveredFeatures(const MovingSurface& soft, const RigidPart& part) {
  const double radius = part.surface->sideRadius;
  const bool hasRoundSide = radius > 0.0 && staysCloseToRound(soft, radius);
  return {true, hasRoundSide ? &part.surface->sideEdges : nullptr};
}

bool hasSharpFeatureNear(const SweptBox& box, const RigidPart& part, const Covered& covered) {
  const SurfaceTopology& t = part.surface->topology;
  if (t.edges.empty()) return true;
  for (const std::uint32_t e : part.surface->sharpEdges) {
    if (covered.edges && (*covered.edges)[e]) continue;
    const Edge& edge = t.edges[e];
    const SweptBox edgeBox = merged(part.boxes.points[edge[0]], part.boxes.points[edge[1]]);
    if (separation(box, edgeBox) <= 0.0) return true;
  }
  return false;
}

namespace {

RoundSupport supportOf(const SurfaceCandidate& m) {
  return {m.part->moving.radius + m.body->surface.moving.radius, kMaxSagging * radiusOf(*m.body)};
}

double saggingOf(const SurfaceCandidate& m, const SurfaceContact& c) {
  const Points& x = *m.body->surface.moving.position;
  return sagging({x.col(c.a.points[0]), x.col(c.a.points[1]), x.col(c.a.points[2])}, c.a.weights.data(),
                 supportOf(m));
}

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
  const TouchedPoint touched{positionOf(rigid, c.b), c.normal, rigid.radius};
  const StaticSurroundings around(*m.body, touched, soft.radius, s.pieces);
  if (around.covers(c.normal)) return true;
  if (const double cylinderRadius = around.radiusAround(c.normal);
      cylinderRadius > 0.0 && staysCloseToRound(soft, c, cylinderRadius))
    return true;
  const Vector3d u = c.normal.unitOrthogonal(), v = c.normal.cross(u);
  if (c.b.kind != FeatureKind::OnEdge) return around.isFlat(c.normal, u) && around.isFlat(c.normal, v);
  const Vector3d along = rigid.position->col(c.b.points[1]) - rigid.position->col(c.b.points[0]);
  return around.isFlat(c.normal, c.normal.cross(along).normalized());
}

/// Returns the share of the held object's rotation that the surroundings of a contact have.
double turningOf(const SurfaceCandidate& m, const SurfaceContact& c, const Vector3d& spin) {
  const LocalSpins& local = m.body->localSpins;
  if (!local.areKnown) return 0.0;
  Vector3d own = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    own += c.a.weights[static_cast<Eigen::Index>(i)] * local.spins.col(c.a.points[i]);
  return turningShare(own, spin, c.normal);
}

}  // namespace

bool isHeldContact(const SurfaceCandidate& m, const SurfaceContact& c, double margin, SurfaceSearch& s) {
  if (c.a.kind == FeatureKind::OnVertex) return false;
  if (isRound(*m.part) ? saggingOf(m, c) <= supportOf(m).maxDepth : cornersCarryContact(*m.body, c, margin))
    return false;
  return isMoved(*m.held) || !isInternalEdge(m, c, s);
}

void setHeldSide(const SurfaceCandidate& m, const SurfaceContact& c, double seconds, double tick,
                 Contact& contact) {
  const double radiusSum = m.part->moving.radius + m.body->surface.moving.radius;
  contact.gap += standingDepth(*m.body->world, *m.held, c.normal);
  if (isRound(*m.part)) contact.gap += allowedDepth(saggingOf(m, c), supportOf(m));
  if (isMoved(*m.held)) {
    Vector3d displacement = Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i)
      displacement += c.b.weights[static_cast<Eigen::Index>(i)] * m.part->motion.col(c.b.points[i]);
    const Vector3d spin = spinOf(*m.held, tick);
    const double height = m.part->moving.radius + turningOf(m, c, spin) * m.body->surface.moving.radius;
    const Vector3d mean = displacement / seconds + spin.cross(height * c.normal);
    const SurfaceVelocity motion = surfaceVelocityOf(*m.held, tick * mean, c.normal, tick);
    contact.b.velocity = motion.velocity, contact.b.acceleration = motion.acceleration;
  } else if (c.b.kind != FeatureKind::OnTriangle) {
    contact.corners.count = c.b.kind == FeatureKind::OnEdge ? 2 : 1;
    for (std::size_t i = 0; i < 2; ++i) contact.corners.at[i] = m.part->moving.position->col(c.b.points[i]);
    contact.corners.radiusSum = radiusSum;
    if (isRound(*m.part)) contact.corners.maxDepth = supportOf(m).maxDepth;
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
