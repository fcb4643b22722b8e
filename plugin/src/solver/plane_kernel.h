// SPDX-License-Identifier: Zlib
#pragma once

// The laws of contact, and the contacts of points with planes, for a number type V (pack.h).

#include "solver/pack.h"

namespace limber::kernel {

/// The points: three entries per point in each array.
template <class V>
struct Points {
  Index count;
  V* position;
  V* velocity;
  V* force;
  const V* acceleration;
  const V* inverseMass;
};

// --- laws --------------------------------------------------------------------------------------------------

/// Share of an overlap that is removed per substep.
constexpr double kRecovery = 0.2;

/// Returns the least speed (m/s) along the normal in a substep of dt seconds. A gap (m) may close. An overlap
/// gets smaller by a share of it, but not faster than `maxSpeed`: a body that was placed inside an object
/// must come out slowly.
template <class V>
inline V minSpeed(V gap, V maxSpeed, V dt) {
  return select(gap >= all(V(), 0.0), -gap / dt, smaller(all(V(), -kRecovery) * gap / dt, maxSpeed));
}

/// Returns the factor that shortens a friction to the radius `limit` of Coulomb's cone; 1 inside the cone.
template <class V>
inline V coneFactor(V squaredFriction, V limit) {
  const auto outside = squaredFriction > limit * limit;
  const V one = all(V(), 1.0);
  if (!any(outside)) return one;
  return select(outside, limit / squareRoot(select(outside, squaredFriction, one)), one);
}

template <class V>
inline V dot(const V* a, const V* b) {
  return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]);
}

/// Computes the impulse (N s) on a point that brings its speed along the normal up to `target`, with Coulomb
/// friction against sliding. `relative` is its velocity relative to the surface, `speed` the part along the
/// normal, `mass` that along the normal. Returns the impulse's component along the normal.
template <class V>
inline V contactImpulse(const V* normal, const V* relative, V speed, V target, V mass, V friction,
                        V* impulse) {
  const V along = (target - speed) * mass;
  V sticking[3];
  for (Index c = 0; c < 3; ++c) sticking[c] = (speed * normal[c] - relative[c]) * mass;
  const V factor = coneFactor(dot(sticking, sticking), friction * along);
  for (Index c = 0; c < 3; ++c) impulse[c] = along * normal[c] + factor * sticking[c];
  return along;
}

// --- points that come to a solid ---------------------------------------------------------------------------

/// The nearest point of a solid: x minus `height` times `normal`.
template <class V>
struct Nearest {
  V normal[3];  ///< unit, outward
  V height;     ///< m, below 0 inside
};

/// Share of a point's radius: contacts nearer than this are evaluated at its present position, not at impact.
constexpr double kTouching = 0.05;

/// Share of a point's radius: the distance from a solid at which a moving point is taken to hit it.
constexpr double kImpactDistance = 0.01 * kTouching;

constexpr int kMaxAdvances = 12;

/// Share of a displacement, over 1: the point does not come to the solid.
constexpr double kNoImpact = 2.0;

/// Follows a point of this radius (m) from x by conservative advancement until it is `near` (m) the solid, or
/// has made its displacement. Starts at the share `start` of the displacement, where nearestAt(position)
/// gives `nearest`, and updates that. Returns the share at impact, or kNoImpact.
template <class V, class NearestAt>
inline V advanceToImpact(const V* x, const V* displacement, V start, V near, V radius, NearestAt nearestAt,
                         Nearest<V>& nearest) {
  const V zero = all(V(), 0.0), one = all(V(), 1.0), none = all(V(), kNoImpact);
  V share = start;
  for (int i = 0; i < kMaxAdvances; ++i) {
    const V gap = nearest.height - radius, approach = zero - dot(nearest.normal, displacement);
    const V needed = select(approach > zero, gap / approach, none);
    const V step = select(gap > near, select(share > one, zero, needed), zero);
    if (!any(step > zero)) break;
    share = select(share + step > one, none, share + step);
    V at[3];
    for (Index c = 0; c < 3; ++c) at[c] = x[c] + share * displacement[c];
    nearest = nearestAt(at);
  }
  return share;
}

/// A ball or a capsule.
template <class V>
struct Capsule {
  V center[3];         ///< m
  V axis[3], side[3];  ///< unit, along its segment and across it
  V half;              ///< m, half the length of the segment
  V radius;            ///< m
};

template <class V>
inline Nearest<V> nearestOn(const Capsule<V>& capsule, const V* x) {
  V to[3], away[3];
  for (Index c = 0; c < 3; ++c) to[c] = x[c] - capsule.center[c];
  const V zero = all(V(), 0.0), half = capsule.half;
  const V along = larger(zero - half, smaller(half, dot(capsule.axis, to)));
  for (Index c = 0; c < 3; ++c) away[c] = to[c] - along * capsule.axis[c];
  const V distance = squareRoot(dot(away, away));
  Nearest<V> nearest;
  for (Index c = 0; c < 3; ++c)
    nearest.normal[c] = select(distance > zero, away[c] / distance, capsule.side[c]);
  nearest.height = distance - capsule.radius;
  return nearest;
}

/// Sets the plane in which a point at x, of this radius (m), touches the capsule, or will hit it within the
/// displacement (m). Returns over 1 if it stays farther away than `within` (m) beyond the displacement, and
/// leaves the plane as it is.
template <class V>
inline V followCapsule(const Capsule<V>& capsule, const V* x, const V* displacement, V within, V radius,
                       V* normal, V* touch) {
  const V zero = all(V(), 0.0), none = all(V(), kNoImpact);
  Nearest<V> nearest = nearestOn(capsule, x);
  const V gap = nearest.height - radius, never = all(V(), 1e300);
  const V hits =
      select(gap + dot(nearest.normal, displacement) < zero, all(V(), kImpactDistance) * radius, never);
  const V near = select(gap > all(V(), kTouching) * radius, hits, never);
  V share = zero;
  if (any(near < never))
    share = advanceToImpact(
        x, displacement, zero, near, radius, [&](const V* at) { return nearestOn(capsule, at); }, nearest);
  share = select(gap > within + squareRoot(dot(displacement, displacement)), none, share);
  const auto away = share > all(V(), 1.0);
  for (Index c = 0; c < 3; ++c) {
    const V at = x[c] + share * displacement[c];
    touch[c] = select(away, touch[c], at + (radius - nearest.height) * nearest.normal[c]);
    normal[c] = select(away, normal[c], nearest.normal[c]);
  }
  return share;
}

// --- points on planes --------------------------------------------------------------------------------------

/// m/s, slower than any point: the least speed of a point that does not touch.
constexpr double kNoLeast = -1e300;

/// A PlaneContact that does not let points bounce.
template <class V>
struct Plane {
  V normal[3], touch[3], surfaceVelocity[3];
  V friction, recoverySpeed;
  V mass;                            ///< 0: no contact in this lane; kAway: the point is far from its capsule
  V least;                           ///< m/s along the normal after the second kick
  V impulse[3], pressing[3], along;  ///< the TickImpulse
};

constexpr double kAway = -1.0;

/// The planes of a body, at most one per point, or those of one body per lane.
template <class V>
struct Planes {
  Index count = 0;
  const Index* points = nullptr;  ///< #planes
  Plane<V>* planes = nullptr;
};

/// Contacts of points with a plane each, in groups of four, and those points, each with four doubles. Points
/// that fill up a group repeat its first one, without a contact.
struct PlaneBody {
  static constexpr unsigned kFixed = static_cast<unsigned>(-1);

  const unsigned* points;     ///< 4 x #groups
  double* planes;             ///< #groups x a Plane of four doubles per number
  const unsigned* capsuleOf;  ///< #groups: the capsule that the planes follow; kFixed: none
  const Capsule<double>* capsules;
  double radius;  ///< m, of points on capsules
  const double* position;
  double* velocity;
  const double* inverseMass;
};

/// Pushes a point out of the plane where it is slower than `least`. Stores the least speed after the next
/// kick: 0 where it touches.
template <class V>
inline void push(Plane<V>& plane, V least, V* velocity, const V* inverseMass) {
  V relative[3];
  for (Index c = 0; c < 3; ++c) relative[c] = velocity[c] - plane.surfaceVelocity[c];
  const V speed = dot(plane.normal, relative), zero = all(V(), 0.0);
  const auto touches = speed < least;
  plane.least = select(touches, zero, all(V(), kNoLeast));
  if (!any(touches)) return;
  V impulse[3];
  const V along = contactImpulse(plane.normal, relative, speed, least, plane.mass, plane.friction, impulse);
  const V pressing = select(touches, along, zero);
  plane.along = plane.along + pressing;
  for (Index c = 0; c < 3; ++c) {
    velocity[c] = select(touches, velocity[c] + inverseMass[c] * impulse[c], velocity[c]);
    plane.impulse[c] = plane.impulse[c] + select(touches, impulse[c], zero);
    plane.pressing[c] = plane.pressing[c] + pressing * plane.normal[c];
  }
}

/// The regions in which contacts of points are known, see ContactWatch::Regions.
template <class V>
struct SearchRegions {
  Index points = 0;
  const V* center = nullptr;    ///< 3 x #points
  const V* distance = nullptr;  ///< #points
};

/// Returns whether a point leaves its region in a drift of dt.
template <class V>
inline bool anyLeaves(const SearchRegions<V>& regions, const Points<V>& p, double dt) {
  V most = all(V(), 0.0);
  for (Index i = 0; i < regions.points; ++i) {
    V offset[3];
    for (Index c = 0; c < 3; ++c)
      offset[c] = p.position[3 * i + c] + all(V(), dt) * p.velocity[3 * i + c] - regions.center[3 * i + c];
    most = larger(most, dot(offset, offset) - regions.distance[i] * regions.distance[i]);
  }
  return any(most > all(V(), 0.0));
}

/// Stops a point at its plane before a drift of dt from `time`.
template <class V>
inline void stopAtPlane(Plane<V>& plane, const V* position, V* velocity, const V* inverseMass, double time,
                        double dt) {
  V offset[3];
  for (Index c = 0; c < 3; ++c)
    offset[c] = position[c] - plane.touch[c] - all(V(), time) * plane.surfaceVelocity[c];
  const V least = minSpeed(dot(plane.normal, offset), plane.recoverySpeed, all(V(), dt));
  push(plane, select(plane.mass > all(V(), 0.0), least, all(V(), kNoLeast)), velocity, inverseMass);
}

/// See solvePositions() of plane_contacts.h.
template <class V>
inline void stopAtPlanes(const Planes<V>& rows, const Points<V>& p, double time, double dt) {
  for (Index i = 0; i < rows.count; ++i) {
    const Index at = 3 * rows.points[i];
    stopAtPlane(rows.planes[i], p.position + at, p.velocity + at, p.inverseMass + at, time, dt);
  }
}

/// See solveVelocities() of plane_contacts.h.
template <class V>
inline void settleAtPlanes(const Planes<V>& rows, const Points<V>& p) {
  for (Index i = 0; i < rows.count; ++i) {
    const Index at = 3 * rows.points[i];
    push(rows.planes[i], rows.planes[i].least, p.velocity + at, p.inverseMass + at);
  }
}

/// Shares of the radius. Surfaces are followed to the first distance beyond a point's displacement, since
/// other contacts may push it there. Surfaces within the second support the point at the end of a substep.
constexpr double kSearchBeyond = 1.0 / 3.0, kSupportDistance = 0.01;

/// Lets planes follow a capsule at rest, in the lanes with `mask` over 0. Arguments as of followCapsule().
template <class V>
inline void follow(Plane<V>& plane, const Capsule<V>& capsule, V radius, const V* x, const V* displacement,
                   V within, const V* inverseMass, V mask) {
  const V zero = all(V(), 0.0), one = all(V(), 1.0);
  V normal[3], touch[3], across[3];
  for (Index c = 0; c < 3; ++c) normal[c] = plane.normal[c], touch[c] = plane.touch[c];
  const V share = followCapsule(capsule, x, displacement, within, radius, normal, touch);
  for (Index c = 0; c < 3; ++c) across[c] = inverseMass[c] * normal[c];
  const V mobility = dot(normal, across), into = dot(normal, plane.surfaceVelocity);
  const V mass = select(mobility > zero, one / mobility, zero);
  const auto follows = mask > zero;
  const V there = select(share > one, zero, mask);
  plane.mass = select(follows, select(share > one, all(V(), kAway), mass), plane.mass);
  for (Index c = 0; c < 3; ++c) {
    plane.normal[c] = select(follows, normal[c], plane.normal[c]);
    plane.touch[c] = select(follows, touch[c], plane.touch[c]);
    plane.surfaceVelocity[c] = plane.surfaceVelocity[c] - select(there > zero, into * normal[c], zero);
  }
}

}  // namespace limber::kernel
