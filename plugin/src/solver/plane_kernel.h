// SPDX-License-Identifier: Zlib
#pragma once

// The laws of contact, and the contacts of points with fixed planes, for a number type V (pack.h).

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

// --- points on fixed planes --------------------------------------------------------------------------------

/// m/s, slower than any point: the least speed of a point that does not touch.
constexpr double kNoLeast = -1e300;

/// A PlaneContact whose plane is fixed and does not let points bounce.
template <class V>
struct Plane {
  V normal[3], touch[3], surfaceVelocity[3];
  V friction, recoverySpeed, mass;   ///< mass 0: no contact in this lane
  V least;                           ///< m/s along the normal after the second kick
  V impulse[3], pressing[3], along;  ///< the TickImpulse
};

/// The planes of a body, at most one per point, or those of one body per lane.
template <class V>
struct Planes {
  Index count = 0;
  const Index* points = nullptr;  ///< #planes
  Plane<V>* planes = nullptr;
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

/// See solvePositions() of plane_contacts.h.
template <class V>
inline void stopAtPlanes(const Planes<V>& rows, const Points<V>& p, double time, double dt) {
  for (Index i = 0; i < rows.count; ++i) {
    Plane<V>& plane = rows.planes[i];
    const Index at = 3 * rows.points[i];
    V offset[3];
    for (Index c = 0; c < 3; ++c)
      offset[c] = p.position[at + c] - plane.touch[c] - all(V(), time) * plane.surfaceVelocity[c];
    const V least = minSpeed(dot(plane.normal, offset), plane.recoverySpeed, all(V(), dt));
    push(plane, select(plane.mass > all(V(), 0.0), least, all(V(), kNoLeast)), p.velocity + at,
         p.inverseMass + at);
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

}  // namespace limber::kernel
