// SPDX-License-Identifier: Zlib
#include "solver/held_surface.h"

#include "solver/closest_points.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Kind = HeldPiece::Kind;

/// Of the radius: contacts nearer than this are looked at where the point is, not where it will meet them.
constexpr double kTouching = 0.05;

/// Of the radius: the size of the ball that must find room where a point touches. It does so beside a step of
/// any height that the point itself could stand beside.
constexpr double kBall = 0.5;

/// Share of that ball's radius by which others may reach into it: tiles that are flush to 1e-5 m are flat.
constexpr double kOverlap = 0.002;

/// Cosine: of two contacts whose normals are closer, only the nearer counts.
constexpr double kSameContact = 0.995;

/// Cosine between the normals of something round and of a polyhedron that stands for it.
constexpr double kAboutSame = 0.98;

constexpr int kMaxPointAdvances = 12;

bool isOfRevolution(Kind kind) {
  return kind == Kind::Capsule || kind == Kind::Cylinder || kind == Kind::Cone;
}

// --- nearest places on the pieces --------------------------------------------------------------------------

/// `away` leads from the nearest place to the point, which is outside.
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
  const Vector3d axis = capsule.axes.col(1), to = x - capsule.center;
  const Vector3d away = to - std::clamp(axis.dot(to), -capsule.size[1], capsule.size[1]) * axis;
  if (away.isZero(0.0)) return {capsule.axes.col(0), -capsule.margin, false};
  return outside(away, capsule, false);
}

/// A place in the half plane of a solid of revolution: distance from the axis, height along it.
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
  Vector3d away;        ///< m, from the nearest place to the point
  double height = 0.0;  ///< m, above its plane
  bool inside = false;  ///< the foot is in the triangle, not on its edges
  bool above = false;   ///< the foot is in it or, to rounding, on its edges
};

double heightAbove(const HeldPiece& t, const Vector3d& x) { return t.center.dot(x - t.axes.col(0)); }

OnTriangle nearestOnTriangle(const HeldPiece& t, const Vector3d& x) {
  constexpr double kOnIt = 1e-9;  // m
  const Vector3d weights = nearestBarycentric({t.axes.col(0), t.axes.col(1), t.axes.col(2)}, x);
  const Vector3d away = x - t.axes * weights;
  const double height = heightAbove(t, x);
  const bool inside = weights.minCoeff() > 0.0;
  return {away, height, inside, inside || (away - height * t.center).norm() < kOnIt};
}

HeldPoint nearestOnSheet(const HeldPiece& sheet, const Vector3d& x) {
  const auto [away, height, inside, above] = nearestOnTriangle(sheet, x);
  const double side = sheet.metAbove ? sheet.side : height < 0.0 ? -1.0 : 1.0;
  if (above) return {side * sheet.center, side * height - sheet.margin, inside};
  return outside(away, sheet, false);
}

HeldPoint nearestOnHull(const HeldPiece* first, const HeldPiece* end, const Vector3d& x) {
  const HeldPiece* shallowest = first;
  double most = -HUGE_VAL;
  for (const HeldPiece* t = first; t != end; ++t)
    if (const double height = heightAbove(*t, x); height > most) most = height, shallowest = t;
  if (most <= 0.0) return {shallowest->center, most - first->margin, true};
  OnTriangle nearest{Vector3d::Constant(HUGE_VAL), false};
  const HeldPiece* face = first;
  for (const HeldPiece* t = first; t != end; ++t) {
    if (heightAbove(*t, x) <= 0.0) continue;
    const OnTriangle on = nearestOnTriangle(*t, x);
    if (on.away.squaredNorm() < nearest.away.squaredNorm()) nearest = on, face = t;
  }
  // exact where the face is far from the world's origin, or flat against its neighbour
  const double height = heightAbove(*face, x);
  if (height * height >= nearest.away.squaredNorm() * (1.0 - 1e-12))
    return {face->center, height - first->margin, true};
  return outside(nearest.away, *first, false);
}

// --- contacts of a point -----------------------------------------------------------------------------------

/// Where the point goes: from + t way, for t from `start` to 1.
struct Path {
  Vector3d from, displacement;
  double start = 0.0;

  Vector3d at(double t) const { return from + t * displacement; }
};

struct Meeting {
  const HeldPiece *first, *end;
  const Vector3d& x;
  const Path& path;
  double radius;
};

HeldContact contactAt(const Meeting& m, const HeldPoint& place, const Vector3d& at) {
  HeldContact c;
  c.owner = m.first->owner;
  c.onFace = place.onFace;
  c.normal = place.normal;
  c.touch = at + (m.radius - place.height) * place.normal;
  c.gap = c.normal.dot(m.x - c.touch);
  return c;
}

constexpr double kNoMeeting = 2.0;

/// Follows the point until it meets the solid, by conservative advancement; returns when, kNoMeeting if it
/// does not.
double advance(const Meeting& m, HeldContact& c) {
  double time = m.path.start;
  HeldPoint place = nearestOn(m.first, m.end, m.path.at(time));
  for (int i = 0; i < kMaxPointAdvances; ++i) {
    const double gap = place.height - m.radius;
    if (gap <= 0.01 * kTouching * m.radius) break;
    const double approach = -place.normal.dot(m.path.displacement);
    if (!(approach > 0.0) || time + gap / approach > 1.0) return kNoMeeting;
    time += gap / approach;
    place = nearestOn(m.first, m.end, m.path.at(time));
  }
  c = contactAt(m, place, m.path.at(time));
  return time;
}

/// Whether another triangle of a sheet is between the point and the place.
bool isHidden(const HeldPiece& sheet, const Vector3d& x, const Vector3d& place) {
  constexpr double kOnIt = 1e-7;  // m
  const double from = heightAbove(sheet, x), to = heightAbove(sheet, place);
  if (from * to >= 0.0 || std::abs(to) < kOnIt) return false;
  const Vector3d crossing = x + from / (from - to) * (place - x);
  return nearestOnTriangle(sheet, crossing).away.norm() < kOnIt;
}

bool isOurs(const Meeting& m, const HeldPiece* other) { return other == m.first; }

/// Whether the contact is not one with what is nearest there.
bool isBlocked(const HeldNeighbourhood& around, const Meeting& m, const HeldContact& c) {
  const HeldPiece* begin = around.all->pieces.data() + around.begin;
  const HeldPiece* end = around.all->pieces.data() + around.end;
  const double ball = kBall * m.radius;
  const Vector3d place = c.touch - m.radius * c.normal, center = place + ball * c.normal;
  for (const HeldPiece *other = begin, *next = begin; other != end; other = next) {
    next = endOfSolid(other, end);
    if (isOurs(m, other)) continue;
    if (other->kind == Kind::Sheet && m.first->kind == Kind::Sheet && isHidden(*other, m.x, place))
      return true;
    if (c.onFace) continue;
    if (nearestOn(other, next, center).height < (1.0 - kOverlap) * ball) return true;
  }
  return false;
}

/// Whether x is to be kept, of two contacts that say about the same. An edge that is flush with a face is
/// none: it must stand out from it. Gaps would not tell, where the point is still far and the normals are not
/// quite equal.
bool isBetter(const HeldContact& x, const HeldContact& y, double radius) {
  const double least = 0.02 * kTouching * radius;
  if (x.onFace == y.onFace) return x.gap <= y.gap;
  const HeldContact &face = x.onFace ? x : y, &edge = x.onFace ? y : x;
  return x.onFace == (face.normal.dot(edge.touch - face.touch) < least);
}

void addContact(std::vector<HeldContact>& contacts, const HeldContact& c, double radius) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].normal.dot(c.normal) <= kSameContact) continue;
    if (isBetter(contacts[i], c, radius)) return;
    contacts.erase(contacts.begin() + static_cast<std::ptrdiff_t>(i--));
  }
  contacts.push_back(c);
}

/// Whose side of a sheet the point is on stays as it was as long as it is above it: what has got into it is
/// pushed out again.
void keepSide(HeldPiece& sheet, const Vector3d& x) {
  const OnTriangle nearest = nearestOnTriangle(sheet, x);
  if (!nearest.above || !sheet.metAbove) sheet.side = nearest.height < 0.0 ? -1 : 1;
  sheet.metAbove = nearest.above;
}

/// The path of a point that slides on the face that it meets first. What is met on the straight way beyond it
/// may be buried, as the sides of flush tiles are.
Path pathAlong(const HeldPiece* begin, const HeldPiece* end, const Vector3d& x, const Vector3d& displacement,
               double radius) {
  const Path straight{x, displacement};
  if (begin == end || endOfSolid(begin, end) == end) return straight;
  Vector3d normal = Vector3d::Zero();
  double time = kNoMeeting;
  for (const HeldPiece *first = begin, *next = begin; first != end; first = next) {
    next = endOfSolid(first, end);
    HeldContact c;
    const double met = advance({first, next, x, straight, radius}, c);
    if (met < time && c.onFace && c.normal.dot(displacement) < 0.0) time = met, normal = c.normal;
  }
  if (time == kNoMeeting) return straight;
  const Vector3d into = normal.dot(displacement) * normal;
  return {x + time * into, displacement - into, time};
}

/// Whether the point has come nowhere near since it was last looked at. It cannot have changed sides of a
/// sheet either.
bool isClear(const HeldNeighbourhood& around, const Vector3d& x, double most) {
  return around.clear > most && (x - around.clearAt).norm() < around.clear - most;
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
  return nearestOnSheet(*first, x);
}

void findContacts(HeldNeighbourhood& around, const Vector3d& x, const Vector3d& displacement, double within) {
  std::vector<HeldContact>& contacts = around.all->contacts;
  contacts.clear();
  HeldPiece* begin = around.all->pieces.data() + around.begin;
  const HeldPiece* end = around.all->pieces.data() + around.end;
  const double most = within + displacement.norm();
  if (isClear(around, x, most)) return;
  double least = HUGE_VAL;
  const Path path = pathAlong(begin, end, x, displacement, around.radius);
  for (HeldPiece *first = begin, *next = begin; first != end; first = next) {
    next = const_cast<HeldPiece*>(endOfSolid(first, end));
    if (first->kind == Kind::Sheet) keepSide(*first, x);
    const HeldPoint place = nearestOn(first, next, x);
    const double gap = place.height - around.radius;
    least = std::min(least, gap);
    if (gap > most) continue;
    const Meeting meeting{first, next, x, path, around.radius};
    HeldContact c = contactAt(meeting, place, x);
    const bool meetsLater = gap > kTouching * around.radius && gap + place.normal.dot(displacement) < 0.0;
    if (meetsLater && advance(meeting, c) == kNoMeeting) continue;
    if (!isBlocked(around, meeting, c)) addContact(contacts, c, around.radius);
  }
  around.clearAt = x;
  around.clear = std::max(least, 0.0);
}

bool isCovered(const HeldPiece* begin, const HeldPiece* end, const Vector3d& place, const Vector3d& normal,
               double radius) {
  const double ball = kBall * radius;
  const Vector3d center = place + ball * normal;
  for (const HeldPiece *other = begin, *next = begin; other != end; other = next) {
    next = endOfSolid(other, end);
    const HeldPoint nearest = nearestOn(other, next, center);
    // what is touched may be a polyhedron slightly within something round
    const bool isItself = isOfRevolution(other->kind) && nearest.normal.dot(normal) > kAboutSame;
    if (!isItself && nearest.height < (1.0 - kOverlap) * ball) return true;
  }
  return false;
}

}  // namespace limber
