// SPDX-License-Identifier: Zlib
#pragma once

// The arithmetic of a Verlet substep, written once for a number `V` that is a double or a pack of doubles of
// several bodies (pack.h). Every operation is one IEEE operation per lane, so all give the same bits.
// Included by sources that are compiled for different instruction sets: nothing here but templates on V,
// which the sets' own types keep apart, and no standard header.

#include "solver/pack.h"
#include "solver/tetrahedron_kernel.h"
#include "solver/volume_kernel.h"

namespace limber::kernel {

/// The springs: one entry each, but three of `direction`.
template <class V>
struct Springs {
  Index count;
  const Index* a;
  const Index* b;
  const V* restLength;
  const V* extensionStiffness;
  const V* compressionStiffness;
  V* direction;
};

/// The points: three entries each.
template <class V>
struct Points {
  Index count;
  V* position;
  V* velocity;
  V* force;
  const V* acceleration;
  const V* inverseMass;
};

/// m^2: below it the ends of a spring coincide, 1/length would lose its digits.
constexpr double kCoincidentSquared = 1e-200;

/// What a spring does: its force (above 0 pulls) and one over its length, which makes the way between its
/// ends its direction. Both 0 while it is slack or its ends coincide.
template <class V>
struct Pull {
  V force, scale;
};

///     F = kE (l - L) if l > L, else kC (l - L)
template <class V>
inline Pull<V> pullOf(V squaredLength, V restLength, V extensionStiffness, V compressionStiffness) {
  const auto apart = squaredLength > all(V(), kCoincidentSquared);
  const V length = squareRoot(select(apart, squaredLength, all(V(), 1.0)));
  const V stretch = length - restLength;
  const V stiffness = select(stretch > all(V(), 0.0), extensionStiffness, compressionStiffness);
  const V inverse = select(stiffness > all(V(), 0.0), all(V(), 1.0) / length, all(V(), 0.0));
  return {stiffness * stretch, select(apart, inverse, all(V(), 0.0))};
}

/// Writes the direction from a to b and adds the force to both ends.
template <class V>
inline void addForce(const Springs<V>& s, Index i, const Points<V>& p) {
  const V* xa = p.position + 3 * s.a[i];
  const V* xb = p.position + 3 * s.b[i];
  const V dx = xb[0] - xa[0], dy = xb[1] - xa[1], dz = xb[2] - xa[2];
  const Pull<V> pull = pullOf(dx * dx + (dy * dy + dz * dz), s.restLength[i], s.extensionStiffness[i],
                              s.compressionStiffness[i]);
  V* n = s.direction + 3 * i;
  n[0] = dx * pull.scale, n[1] = dy * pull.scale, n[2] = dz * pull.scale;
  const V fx = pull.force * n[0], fy = pull.force * n[1], fz = pull.force * n[2];
  V* fa = p.force + 3 * s.a[i];
  V* fb = p.force + 3 * s.b[i];
  fa[0] = fa[0] + fx, fa[1] = fa[1] + fy, fa[2] = fa[2] + fz;
  fb[0] = fb[0] - fx, fb[1] = fb[1] - fy, fb[2] = fb[2] - fz;
}

template <class V>
inline void computeForces(const Springs<V>& s, const Points<V>& p) {
  for (Index i = 0; i < 3 * p.count; ++i) p.force[i] = all(V(), 0.0);
  for (Index i = 0; i < s.count; ++i) addForce(s, i, p);
}

/// Takes the impulse `factor` (kg) times closing speed from either end.
template <class V>
inline void damp(const Springs<V>& s, Index i, const V& factor, const Points<V>& p) {
  const V* n = s.direction + 3 * i;
  const Index a = 3 * s.a[i], b = 3 * s.b[i];
  V* va = p.velocity + a;
  V* vb = p.velocity + b;
  const V *wa = p.inverseMass + a, *wb = p.inverseMass + b;
  const V speed = n[0] * (vb[0] - va[0]) + (n[1] * (vb[1] - va[1]) + n[2] * (vb[2] - va[2]));
  const V impulse = factor * speed;
  const V jx = impulse * n[0], jy = impulse * n[1], jz = impulse * n[2];
  va[0] = va[0] + jx * wa[0], va[1] = va[1] + jy * wa[1], va[2] = va[2] + jz * wa[2];
  vb[0] = vb[0] - jx * wb[0], vb[1] = vb[1] - jy * wb[1], vb[2] = vb[2] - jz * wb[2];
}

template <class V>
inline void dampAll(const Springs<V>& s, const V* factor, bool forward, const Points<V>& p) {
  if (forward)
    for (Index i = 0; i < s.count; ++i) damp(s, i, factor[i], p);
  else
    for (Index i = s.count; i-- > 0;) damp(s, i, factor[i], p);
}

template <class V>
inline void kick(const Points<V>& p, double dt) {
  const V time = all(V(), dt);
  for (Index i = 0; i < 3 * p.count; ++i)
    p.velocity[i] = p.velocity[i] + time * (p.acceleration[i] + p.force[i] * p.inverseMass[i]);
}

template <class V>
inline void drift(const Points<V>& p, double dt) {
  const V time = all(V(), dt);
  for (Index i = 0; i < 3 * p.count; ++i) p.position[i] = p.position[i] + time * p.velocity[i];
}

/// What happens to points at contacts; outside the kernel, since contacts differ from lane to lane.
struct ContactCalls {
  void* context;  ///< nullptr: nothing touches
  void (*stop)(void* context, double time, double dt);
  void (*settle)(void* context);
};

/// A body, or one body per lane, stepped by itself.
template <class V>
struct Body {
  Springs<V> springs;
  Points<V> points;
  Volumes<V> volumes;
  Tetrahedra<V> tetrahedra;
  bool hasDampers;
  const V* dampHalf;
  const V* dampFull;
  const ContactCalls* contactCalls;
  V* earlierForce;  ///< #points x 3, scratch

  bool damped() const { return hasDampers; }
  const ContactCalls& contacts() const { return *contactCalls; }
};

template <class V>
inline void computeForces(const Body<V>& body) {
  computeForces(body.springs, body.points);
  addVolumeForces(body.volumes, body.points.position, body.points.inverseMass, body.points.force);
  addTetrahedronForces(body.tetrahedra, body.points.position, body.points.force);
}

template <class V>
inline void kick(const Body<V>& body, double dt) {
  kick(body.points, dt);
}

template <class V>
inline void drift(const Body<V>& body, double dt) {
  drift(body.points, dt);
}

template <class V>
inline void dampAll(const Body<V>& body, bool whole, bool forward) {
  dampAll(body.springs, whole ? body.dampFull : body.dampHalf, forward, body.points);
}

/// The sum over the points of the squared change of acceleration over a substep, at whose end it computes
/// the forces.
template <class V>
inline V computeForcesAndChange(const Body<V>& body) {
  const Points<V>& p = body.points;
  for (Index i = 0; i < 3 * p.count; ++i) body.earlierForce[i] = p.force[i];
  computeForces(body);
  V sum[3] = {all(V(), 0.0), all(V(), 0.0), all(V(), 0.0)};
  for (Index i = 0; i < p.count; ++i)
    for (Index c = 0; c < 3; ++c) {
      const V change = (p.force[3 * i + c] - body.earlierForce[3 * i + c]) * p.inverseMass[3 * i + c];
      sum[c] = sum[c] + change * change;
    }
  return sum[0] + (sum[1] + sum[2]);
}

/// stepVerlet of verlet_step.h for bodies without links. `Stepped` is a Body<V> or something else that has
/// its functions (quad_kernel_avx2.cpp). Returns the larger computeForcesAndChange of a substep in the middle
/// and the last.
template <class V, class Stepped>
inline V stepAlone(const Stepped& body, double tick, int substeps) {
  const ContactCalls& contacts = body.contacts();
  const double dt = tick / substeps;
  V change = all(V(), 0.0);
  computeForces(body);
  if (body.damped()) dampAll(body, false, false);
  for (int s = 0; s < substeps; ++s) {
    const bool last = s + 1 == substeps;
    kick(body, 0.5 * dt);
    if (contacts.context) contacts.stop(contacts.context, s * dt, dt);
    drift(body, dt);
    if (last || 2 * s == substeps) {
      const V now = computeForcesAndChange(body);
      change = select(now > change, now, change);
    } else {
      computeForces(body);
    }
    kick(body, 0.5 * dt);
    if (contacts.context) contacts.settle(contacts.context);
    if (body.damped()) dampAll(body, !last, s % 2 == 0);
  }
  return change;
}

}  // namespace limber::kernel
