// SPDX-License-Identifier: Zlib
#include "solver/plane_contacts.h"

#include "mesh/surface.h"

namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Kind = HeldPiece::Kind;

using kernel::kNoImpact, kernel::kTouching;

/// Share of the radius: radius of a ball that must fit at the contact point without an overlap. It fits
/// beside a step of any height where the point itself fits.
constexpr double kBallRadius = 0.5;

/// Share of that ball's radius by which other pieces may overlap it: tiles flush to 1e-5 m count as flat.
constexpr double kOverlap = 0.002;

/// Cosine: if the normals of two contacts are closer, only the nearer contact counts.
constexpr double kSameContact = 0.995;

/// Cosine between the normals of a round shape and of a polyhedron that approximates it.
constexpr double kRoundNormalCosine = 0.98;

/// Depth of its chords, as a fraction of the radius: 1 - cos(pi / 32) and rounding.
constexpr double kRoundDepth = 0.0051;

bool isOfRevolution(Kind kind) {
  return kind == Kind::Capsule || kind == Kind::Cylinder || kind == Kind::Cone;
}

// --- nearest points on the pieces --------------------------------------------------------------------------

/// Returns the nearest point for a point outside. `away` leads from the nearest point to that point.
HeldPoint outside(const Vector3d& away, const HeldPiece& piece, bool onFace) {
  const double distance = away.norm();
  return {away / distance, distance - piece.margin, onFace};
}

HeldPoint nearestOnPlane(const HeldPiece& plane, const Vector3d& x) {
  const Vector3d normal = plane.axes.col(1);
  return {normal, normal.dot(x - plane.center), true};
}

HeldPoint nearestOnBox(const HeldPiece& box, const Vector3d& x) {
  const Vector3d local = box.axes.transpose() * (x - box.center);
  const Vector3d outward = local - local.cwiseMax(-box.size).cwiseMin(box.size);
  if (!outward.isZero(0.0)) return outside(box.axes * outward, box, (outward.array() != 0.0).count() == 1);
  Eigen::Index axis;
  const double depth = (box.size - local.cwiseAbs()).minCoeff(&axis);
  return {(local[axis] < 0.0 ? -1.0 : 1.0) * box.axes.col(axis), -depth - box.margin, true};
}

HeldPoint nearestOnCapsule(const HeldPiece& capsule, const Vector3d& x) {
  const kernel::Nearest<double> nearest = kernel::nearestOn(capsuleOf(capsule), x.data());
  return {Vector3d::Map(nearest.normal), nearest.height, false};
}

/// A point in the half plane of a solid of revolution: distance from the axis, height along it.
struct HalfPlane {
  Vector3d axis, radial;
  Vector2d at;

  HalfPlane(const HeldPiece& piece, const Vector3d& x) : axis(piece.axes.col(1)) {
    const Vector3d to = x - piece.center;
    const double along = axis.dot(to);
    radial = to - along * axis;
    at = {radial.norm(), along};
    radial = at[0] > 0.0 ? Vector3d(radial / at[0]) : Vector3d(piece.axes.col(0));
  }
  Vector3d inSpace(const Vector2d& v) const { return v[0] * radial + v[1] * axis; }
};

HeldPoint nearestOnCylinder(const HeldPiece& cylinder, const Vector3d& x) {
  const HalfPlane plane(cylinder, x);
  const double radius = cylinder.size[0], half = cylinder.size[1];
  const Vector2d nearest(std::min(plane.at[0], radius), std::clamp(plane.at[1], -half, half));
  const Vector2d outward = plane.at - nearest;
  if (!outward.isZero(0.0)) return outside(plane.inSpace(outward), cylinder, outward[0] == 0.0);
  const double toSide = radius - plane.at[0], toCap = half - std::abs(plane.at[1]);
  if (toSide < toCap) return {plane.radial, -toSide - cylinder.margin, false};
  return {(plane.at[1] < 0.0 ? -1.0 : 1.0) * plane.axis, -toCap - cylinder.margin, true};
}

HeldPoint nearestOnCone(const HeldPiece& cone, const Vector3d& x) {
  const HalfPlane plane(cone, x);
  const double radius = cone.size[0], half = cone.size[1];
  const Vector2d tip(0.0, half), slope = Vector2d(radius, -half) - tip;
  const Vector2d normal = Vector2d(2.0 * half, radius).normalized();
  const double aboveSlope = normal.dot(plane.at - tip), aboveBase = -half - plane.at[1];
  if (aboveSlope <= 0.0 && aboveBase <= 0.0) {
    if (aboveSlope > aboveBase) return {plane.inSpace(normal), aboveSlope - cone.margin, false};
    return {-plane.axis, aboveBase - cone.margin, true};
  }
  const Vector2d onSlope =
      tip + std::clamp(slope.dot(plane.at - tip) / slope.squaredNorm(), 0.0, 1.0) * slope;
  const Vector2d onBase(std::min(plane.at[0], radius), -half);
  const bool baseIsNearer = (plane.at - onBase).squaredNorm() < (plane.at - onSlope).squaredNorm();
  const Vector2d away = plane.at - (baseIsNearer ? onBase : onSlope);
  if (away.isZero(0.0)) return {plane.inSpace(normal), -cone.margin, false};
  return outside(plane.inSpace(away), cone, baseIsNearer && plane.at[0] < radius);
}

struct OnTriangle {
  Vector3d away;        ///< m, from the nearest point of the triangle
  double height = 0.0;  ///< m, above its plane
  bool inside = false;  ///< the foot is in the triangle, not on its edges
  bool above = false;   ///< the foot is in it or, within rounding, on its edges
};

double heightAbove(const HeldPiece& t, const Vector3d& x) { return t.center.dot(x - t.axes.col(0)); }

OnTriangle nearestOnTriangle(const HeldPiece& t, const Vector3d& x) {
  constexpr double kOnTriangle = 1e-9;  // m
  const Vector3d weights = nearestBarycentric({t.axes.col(0), t.axes.col(1), t.axes.col(2)}, x);
  const Vector3d away = x - t.axes * weights;
  const double height = heightAbove(t, x);
  const bool inside = weights.minCoeff() > 0.0;
  return {away, height, inside, inside || (away - height * t.center).norm() < kOnTriangle};
}

HeldPoint nearestOnSheet(const HeldPiece& sheet, const OnTriangle& on) {
  const auto [away, height, inside, above] = on;
  const double side = sheet.metAbove ? sheet.side : height < 0.0 ? -1.0 : 1.0;
  if (above) return {side * sheet.center, side * height - sheet.margin, inside};
  return outside(away, sheet, false);
}

HeldPoint nearestOnHull(const HeldPiece* first, const HeldPiece* end, const Vector3d& x) {
  const HeldPiece* shallowest = first;
  double maxHeight = -HUGE_VAL;
  for (const HeldPiece* t = first; t != end; ++t)
    if (const double height = heightAbove(*t, x); height > maxHeight) maxHeight = height, shallowest = t;
  if (maxHeight <= 0.0) return {shallowest->center, maxHeight - first->margin, true};
  OnTriangle nearest{Vector3d::Constant(HUGE_VAL), false};
  const HeldPiece* face = first;
  for (const HeldPiece* t = first; t != end; ++t) {
    if (heightAbove(*t, x) <= 0.0) continue;
    const OnTriangle on = nearestOnTriangle(*t, x);
    if (on.away.squaredNorm() < nearest.away.squaredNorm()) nearest = on, face = t;
  }
  // also exact for a face far from the world's origin, or coplanar with its neighbour
  const double height = heightAbove(*face, x);
  if (height * height >= nearest.away.squaredNorm() * (1.0 - 1e-12))
    return {face->center, height - first->margin, true};
  return outside(nearest.away, *first, false);
}

// --- contacts of a point -----------------------------------------------------------------------------------

/// The path of the point: from + t displacement, for t from `start` to 1.
struct Path {
  Vector3d from, displacement;
  double start = 0.0;

  Vector3d at(double t) const { return from + t * displacement; }
};

struct Approach {
  const HeldPiece *first, *end;
  const Vector3d& x;
  const Path& path;
  double radius;
};

HeldContact contactAt(const Approach& m, const HeldPoint& nearest, const Vector3d& at) {
  HeldContact c;
  c.owner = m.first->owner;
  c.onFace = nearest.onFace;
  c.normal = nearest.normal;
  c.touch = at + (m.radius - nearest.height) * nearest.normal;
  c.gap = c.normal.dot(m.x - c.touch);
  return c;
}

/// Follows the point until it hits the solid. Returns the time of impact on the path, or kNoImpact.
double advanceToImpact(const Approach& m, HeldContact& c) {
  HeldPoint at;
  const auto nearestAt = [&](const double* x) -> kernel::Nearest<double> {
    at = nearestOn(m.first, m.end, Vector3d::Map(x));
    return {{at.normal[0], at.normal[1], at.normal[2]}, at.height};
  };
  kernel::Nearest<double> nearest = nearestAt(m.path.at(m.path.start).data());
  const double time =
      kernel::advanceToImpact(m.path.from.data(), m.path.displacement.data(), m.path.start,
                              kernel::kImpactDistance * m.radius, m.radius, nearestAt, nearest);
  c = contactAt(m, at, m.path.at(time));
  return time;
}

/// Whether the triangle is between the point `x` and `target`.
bool isHidden(const HeldPiece& sheet, const Vector3d& x, const Vector3d& target) {
  constexpr double kOnTriangle = 1e-7;  // m
  const double from = heightAbove(sheet, x), to = heightAbove(sheet, target);
  if (from * to >= 0.0 || std::abs(to) < kOnTriangle) return false;
  const Vector3d crossing = x + from / (from - to) * (target - x);
  return nearestOnTriangle(sheet, crossing).away.norm() < kOnTriangle;
}

/// Whether the plane or the box of a sheet shows that it is at least `distance` (m) from the point x, as
/// those of most do.
bool isFar(const HeldPiece& piece, const Vector3d& x, double distance) {
  if (piece.kind != Kind::Sheet) return false;
  const double above = heightAbove(piece, x), least = distance + piece.margin;
  const double height = piece.metAbove ? piece.side * above : std::abs(above);
  if (height >= least || height < 0.0) return height > 0.0;
  const Vector3d low = piece.axes.rowwise().minCoeff(), high = piece.axes.rowwise().maxCoeff();
  return std::max((low - x).maxCoeff(), (x - high).maxCoeff()) >= least;
}

/// Whether other pieces hide or cover the contact.
bool isBlocked(const HeldNeighbourhood& around, const Approach& m, const HeldContact& c) {
  const HeldPiece* begin = around.all->pieces.data() + around.begin;
  const HeldPiece* end = around.all->pieces.data() + around.end;
  const double ball = kBallRadius * m.radius;
  const Vector3d point = c.touch - m.radius * c.normal, center = point + ball * c.normal;
  for (const HeldPiece *other = begin, *next = begin; other != end; other = next) {
    next = endOfSolid(other, end);
    if (other == m.first) continue;
    if (other->kind == Kind::Sheet && m.first->kind == Kind::Sheet && isHidden(*other, m.x, point))
      return true;
    if (c.onFace || isFar(*other, center, (1.0 - kOverlap) * ball)) continue;
    if (nearestOn(other, next, center).height < (1.0 - kOverlap) * ball) return true;
  }
  return false;
}

/// Finds the contact with one solid or triangle, at `nearest` or where the point will hit it. Returns whether
/// the point can touch it.
bool findContact(const Approach& m, const HeldPoint& nearest, double maxDistance, HeldContact& c) {
  const double gap = nearest.height - m.radius;
  if (gap > maxDistance) return false;
  const bool hitsLater = gap > kTouching * m.radius && gap + nearest.normal.dot(m.path.displacement) < 0.0;
  if (hitsLater) return advanceToImpact(m, c) != kNoImpact;
  c = contactAt(m, nearest, m.x);
  return true;
}

/// Share of the radius by which an edge stands out from a face, at least.
constexpr double kMinStanding = 0.02 * kTouching;

/// Whether x is kept, of two contacts with about the same normal. An edge that is flush with a face is no
/// contact: it must stand out from the face. Gaps cannot decide this while the point is far away and the
/// normals differ slightly.
bool isBetter(const HeldContact& x, const HeldContact& y, double radius) {
  const double minHeight = kMinStanding * radius;
  if (x.onFace == y.onFace) return x.gap <= y.gap;
  const HeldContact &face = x.onFace ? x : y, &edge = x.onFace ? y : x;
  return x.onFace == (face.normal.dot(edge.touch - face.touch) < minHeight);
}

void addContact(std::vector<HeldContact>& contacts, const HeldContact& c, double radius) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].normal.dot(c.normal) <= kSameContact) continue;
    if (isBetter(contacts[i], c, radius)) return;
    contacts.erase(contacts.begin() + static_cast<std::ptrdiff_t>(i--));
  }
  contacts.push_back(c);
}

/// Whether the point touches one of the faces before the edge: that does not stand out from the face. This
/// spares the search for what covers it.
bool isFlushWithFace(const std::vector<HeldContact>& contacts, const HeldContact& edge, double radius) {
  const double minHeight = kMinStanding * radius;
  return std::any_of(contacts.begin(), contacts.end(), [&](const HeldContact& face) {
    return face.onFace && face.gap <= edge.gap &&
           face.normal.dot(edge.touch - radius * edge.normal - face.touch + radius * face.normal) < minHeight;
  });
}

/// Returns the nearest point on a sheet, whose side on which the point x is it updates. The side stays the
/// same while the point is above or below the triangle: a point that has penetrated it is pushed back.
HeldPoint meetSheet(HeldPiece& sheet, const Vector3d& x) {
  const OnTriangle nearest = nearestOnTriangle(sheet, x);
  if (!nearest.above || !sheet.metAbove) sheet.side = nearest.height < 0.0 ? -1 : 1;
  sheet.metAbove = nearest.above;
  return nearestOnSheet(sheet, nearest);
}

/// Returns the path of a point that slides on the face that it hits first. Pieces on the straight path beyond
/// that face may be buried, as the sides of flush tiles.
Path slidingPath(const HeldPiece* begin, const HeldPiece* end, const Vector3d& x,
                 const Vector3d& displacement, double radius) {
  Path straight{x, displacement};
  if (begin == end || endOfSolid(begin, end) == end) return straight;
  Vector3d normal = Vector3d::Zero();
  double time = kNoImpact;
  const double reach = radius + displacement.norm();
  for (const HeldPiece *first = begin, *next = begin; first != end; first = next) {
    next = endOfSolid(first, end);
    if (isFar(*first, x, reach)) continue;
    HeldContact c;
    const double impact = advanceToImpact({first, next, x, straight, radius}, c);
    if (impact < time && c.onFace && c.normal.dot(displacement) < 0.0) time = impact, normal = c.normal;
  }
  if (time == kNoImpact) return straight;
  const Vector3d into = normal.dot(displacement) * normal;
  return {x + time * into, displacement - into, time};
}

/// Multiple of the distance within which contacts are searched. A triangle beyond it is far.
constexpr double kFar = 4.0;

/// Whether the point has stayed clear of all pieces since the last search. Then it has not changed sides of a
/// sheet either.
bool isClear(const HeldNeighbourhood& around, const Vector3d& x, double maxDistance) {
  return around.clear > maxDistance && (x - around.clearAt).norm() < around.clear - maxDistance;
}

}  // namespace

const HeldPiece* endOfSolid(const HeldPiece* first, const HeldPiece* end) {
  const HeldPiece* next = first + 1;
  if (first->kind == Kind::Face)
    while (next != end && next->owner == first->owner && next->kind == Kind::Face) ++next;
  return next;
}

HeldPoint nearestOn(const HeldPiece* first, const HeldPiece* end, const Vector3d& x) {
  switch (first->kind) {
    case Kind::Plane:
      return nearestOnPlane(*first, x);
    case Kind::Box:
      return nearestOnBox(*first, x);
    case Kind::Capsule:
      return nearestOnCapsule(*first, x);
    case Kind::Cylinder:
      return nearestOnCylinder(*first, x);
    case Kind::Cone:
      return nearestOnCone(*first, x);
    case Kind::Face:
      return nearestOnHull(first, end, x);
    case Kind::Sheet:
      break;
  }
  return nearestOnSheet(*first, nearestOnTriangle(*first, x));
}

kernel::Capsule<double> capsuleOf(const HeldPiece& piece) {
  kernel::Capsule<double> capsule{};
  for (Eigen::Index c = 0; c < 3; ++c) {
    capsule.center[c] = piece.center[c];
    capsule.axis[c] = piece.axes(c, 1);
    capsule.side[c] = piece.axes(c, 0);
  }
  capsule.half = piece.size[1], capsule.radius = piece.margin;
  return capsule;
}

const HeldPiece* singleSolid(const HeldNeighbourhood& around) {
  if (around.end != around.begin + 1) return nullptr;
  const HeldPiece& piece = around.all->pieces[around.begin];
  return piece.kind != Kind::Face && piece.kind != Kind::Sheet ? &piece : nullptr;
}

bool findContact(const HeldPiece& solid, double radius, const Vector3d& x, const Vector3d& displacement,
                 double within, HeldContact& contact) {
  const HeldPiece* end = &solid + 1;
  const Path path{x, displacement};
  const Approach approach{&solid, end, x, path, radius};
  return findContact(approach, nearestOn(&solid, end, x), within + displacement.norm(), contact);
}

void findContacts(HeldNeighbourhood& around, const Vector3d& x, const Vector3d& displacement, double within) {
  std::vector<HeldContact>& contacts = around.contacts;
  contacts.clear();
  around.edges.clear();
  HeldPiece* begin = around.all->pieces.data() + around.begin;
  const HeldPiece* end = around.all->pieces.data() + around.end;
  const double maxDistance = within + displacement.norm();
  if (isClear(around, x, maxDistance)) return;
  // farther triangles are not looked at; their sides of the point are those of the last look
  const double far = kFar * maxDistance;
  double minGap = far;
  const Path path = slidingPath(begin, end, x, displacement, around.radius);
  for (HeldPiece *first = begin, *next = begin; first != end; first = next) {
    next = const_cast<HeldPiece*>(endOfSolid(first, end));
    if (isFar(*first, x, around.radius + far)) continue;
    const HeldPoint nearest = first->kind == Kind::Sheet ? meetSheet(*first, x) : nearestOn(first, next, x);
    minGap = std::min(minGap, nearest.height - around.radius);
    const Approach approach{first, next, x, path, around.radius};
    HeldContact c;
    if (!findContact(approach, nearest, maxDistance, c)) continue;
    if (!c.onFace)
      around.edges.emplace_back(c, static_cast<std::size_t>(first - begin));
    else if (!isBlocked(around, approach, c))
      addContact(contacts, c, around.radius);
  }
  for (const auto& [c, piece] : around.edges) {
    const HeldPiece* first = begin + piece;
    if (isFlushWithFace(contacts, c, around.radius)) continue;
    if (!isBlocked(around, {first, endOfSolid(first, end), x, path, around.radius}, c))
      addContact(contacts, c, around.radius);
  }
  around.clearAt = x;
  around.clear = std::max(minGap, 0.0);
}

namespace {

/// Returns whether the point may be on the polyhedron that stands for a round piece: on the chord of a rim,
/// where the piece's normal jumps.
bool isJustInside(const HeldPiece* piece, const HeldPiece* end, const Vector3d& point) {
  const double height = nearestOn(piece, end, point).height, size = piece->size.x() + piece->margin;
  return height < kRoundDepth * size && height > -kRoundDepth * size;
}

}  // namespace

bool isCovered(const HeldPiece* begin, const HeldPiece* end, const TouchedPoint& touched,
               const Vector3d& normal, double radius) {
  const double ball = kBallRadius * radius;
  const Vector3d point = touched.onSurface();
  for (const HeldPiece *other = begin, *next = begin; other != end; other = next) {
    next = endOfSolid(other, end);
    const double margin = other->margin == touched.margin ? touched.margin : 0.0;
    const Vector3d center = (margin > 0.0 ? touched.core : point) + ball * normal;
    if (isFar(*other, center, (1.0 - kOverlap) * ball - margin)) continue;
    HeldPoint nearest = nearestOn(other, next, center);
    nearest.height += margin;
    const bool isItself = isOfRevolution(other->kind) && (nearest.normal.dot(normal) > kRoundNormalCosine ||
                                                          isJustInside(other, next, point));
    if (!isItself && nearest.height < (1.0 - kOverlap) * ball) return true;
  }
  return false;
}

}  // namespace limber
