// SPDX-License-Identifier: Zlib
#pragma once

// The arithmetic of a Verlet substep for a number type `V`: a double, or a pack of doubles of several bodies.

#include "solver/plane_kernel.h"

namespace limber::kernel {

// --- the volume term of closed surfaces --------------------------------------------------------------------

/// The closed surfaces of a body.
template <class V>
struct Volumes {
  Index components = 0;                  ///< 0: no volume term
  Index points = 0;                      ///< number of points of the body
  const Index* firstTriangle = nullptr;  ///< #components + 1
  const Index* corners = nullptr;        ///< 3 x #triangles, point indices
  const Index* componentOf = nullptr;    ///< #points; any value for points of no component
  const double* restVolume = nullptr;    ///< #components, m^3
  const double* modulus = nullptr;       ///< Pa, one number
  const double* gasPressure = nullptr;   ///< Pa, one number
  const double* ambient = nullptr;       ///< Pa, one number
  V* gradient = nullptr;                 ///< 3 x #points, scratch: six times the gradient of the volume
  V* sums = nullptr;                     ///< 4 x #components, scratch
  double timeStep = 0.0;                 ///< s, substep that must be stable; 0: no limit on the force
};

/// The relative changes of volume beyond which the push against them no longer increases: a body of twice its
/// volume, or inverted. A larger push would require smaller and smaller substeps for bodies that are already
/// torn apart.
constexpr double kLargestSwelling = 1.0, kLargestShrinking = -2.0;

/// Fraction of the rest volume below which gas is not compressed further.
constexpr double kMinGasVolume = 0.1;

/// The value of (omega dt)^2 above which the push is scaled down. It is far below Verlet's limit of 4, and
/// far above the values of bodies near their rest shape.
constexpr double kLargestPhaseSquared = 1.0;

/// The push of a closed surface at one volume.
template <class V>
struct Push {
  V push;       ///< Pa, outwards,  P V0 / V - A - K (V - V0) / V0
  V stiffness;  ///< Pa/m^3, decrease of the push per increase of the volume, without its limits
};

/// Returns the push of gas of the pressure P at the rest volume in an ambient pressure A.
template <class V>
inline Push<V> pushOf(V volume, V restVolume, V modulus, V gasPressure, V ambient) {
  const V change = (volume - restVolume) / restVolume;
  const V limited = larger(smaller(change, all(V(), kLargestSwelling)), all(V(), kLargestShrinking));
  const V gas = restVolume / larger(volume, all(V(), kMinGasVolume) * restVolume);
  return {gasPressure * gas - ambient - modulus * limited, (modulus + gasPressure * gas * gas) / restVolume};
}

/// Returns six times the volume of a component:  6 V = sum (a - o) . n,   n = (b - a) x (c - a).  The origin
/// o is a point of the component, so that no digits are lost far away from the world's origin. Adds n to
/// v.gradient at the triangle's corners: each triangle contributes n / 6 to the gradient of V there, a third
/// of its area vector.
template <class V>
inline V sixVolumes(const Volumes<V>& v, Index component, const V* position) {
  V sx = all(V(), 0.0), sy = sx, sz = sx;
  const V* o = position + 3 * v.corners[3 * v.firstTriangle[component]];
  for (Index t = v.firstTriangle[component]; t < v.firstTriangle[component + 1]; ++t) {
    const Index* corner = v.corners + 3 * t;
    const V *a = position + 3 * corner[0], *b = position + 3 * corner[1], *c = position + 3 * corner[2];
    const V bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2];
    const V cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
    const V nx = by * cz - bz * cy, ny = bz * cx - bx * cz, nz = bx * cy - by * cx;
    sx = sx + (a[0] - o[0]) * nx, sy = sy + (a[1] - o[1]) * ny, sz = sz + (a[2] - o[2]) * nz;
    for (Index k = 0; k < 3; ++k) {
      V* g = v.gradient + 3 * corner[k];
      g[0] = g[0] + nx, g[1] = g[1] + ny, g[2] = g[2] + nz;
    }
  }
  return sx + (sy + sz);
}

/// Writes six times the volume of component c to sums[4 c], and after it sum w g^2 for each axis, where g is
/// six times the gradient.
template <class V>
inline void sumUp(const Volumes<V>& v, const V* position, const V* inverseMass) {
  for (Index i = 0; i < 3 * v.points; ++i) v.gradient[i] = all(V(), 0.0);
  for (Index c = 0; c < v.components; ++c) {
    v.sums[4 * c] = sixVolumes(v, c, position);
    v.sums[4 * c + 1] = v.sums[4 * c + 2] = v.sums[4 * c + 3] = all(V(), 0.0);
  }
  for (Index i = 0; i < v.points; ++i) {
    V* s = v.sums + 4 * v.componentOf[i];
    const V *g = v.gradient + 3 * i, *w = inverseMass + 3 * i;
    s[1] = s[1] + w[0] * g[0] * g[0], s[2] = s[2] + w[1] * g[1] * g[1], s[3] = s[3] + w[2] * g[2] * g[2];
  }
}

/// Returns the push of a component (Pa/6) from six times its volume and the sum of w g^2.
///
/// Along the gradient the volume oscillates with  omega^2 = stiffness sum w |gradient|^2, which has no bound
/// while a body is torn apart. If the substep is too long for it, the push is scaled down to the largest
/// stable one. It still acts towards the rest volume.
template <class V>
inline V stablePush(V sixVolume, V squares, V restVolume, V modulus, V gasPressure, V ambient,
                    double timeStep) {
  const Push<V> p = pushOf(sixVolume * all(V(), 1.0 / 6.0), restVolume, modulus, gasPressure, ambient);
  const V phaseSquared =
      all(V(), timeStep * timeStep / (36.0 * kLargestPhaseSquared)) * p.stiffness * squares;
  return p.push / larger(phaseSquared, all(V(), 1.0)) * all(V(), 1.0 / 6.0);
}

template <class V>
inline void addVolumeForces(const Volumes<V>& v, const V* position, const V* inverseMass, V* force) {
  if (v.components == 0) return;
  sumUp(v, position, inverseMass);
  for (Index c = 0; c < v.components; ++c) {
    V* s = v.sums + 4 * c;
    s[0] = stablePush(s[0], s[1] + (s[2] + s[3]), all(V(), v.restVolume[c]), all(V(), *v.modulus),
                      all(V(), *v.gasPressure), all(V(), *v.ambient), v.timeStep);
  }
  for (Index i = 0; i < v.points; ++i) {
    const V push = v.sums[4 * v.componentOf[i]];
    for (Index axis = 3 * i; axis < 3 * i + 3; ++axis) force[axis] = force[axis] + push * v.gradient[axis];
  }
}

// --- the volume term of tetrahedra -------------------------------------------------------------------------

/// Fraction of its rest volume below which a tetrahedron counts as crushed. Common deformations do not reach
/// it.
constexpr double kCrushed = 0.3;

/// Relative volume change below which the push of a tetrahedron's modulus no longer increases. Tetrahedra
/// that are tangled must pass through each other's volume to get free. With a push up to an inverted volume,
/// thin limbs stay folded: a figure of 264 points returned from 98 of 105 large deformations, with this limit
/// from all.
constexpr double kLargestCompression = -0.3;

/// The tetrahedra of a body.
template <class V>
struct Tetrahedra {
  Index count = 0;                       ///< 0: none
  const Index* corners = nullptr;        ///< 4 x count, point indices
  const double* inverseRest = nullptr;   ///< count, 1/m^3, 1 / (6 rest volume)
  const V* stabilityScale = nullptr;     ///< count, 1/m^4, see TetrahedronVolumes
  const double* modulus = nullptr;       ///< Pa, one number
  const double* crushModulus = nullptr;  ///< Pa, one number
};

template <class V>
struct Vector {
  V x, y, z;
};

template <class V>
inline Vector<V> cross(const Vector<V>& a, const Vector<V>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class V>
inline V dot(const Vector<V>& a, const Vector<V>& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}

template <class V>
inline Vector<V> scaled(V factor, const Vector<V>& a) {
  return {factor * a.x, factor * a.y, factor * a.z};
}

/// Returns the outward push (Pa) of a tetrahedron with this volume relative to its rest volume.
template <class V>
inline V tetrahedronPush(V relativeVolume, V modulus, V crushModulus) {
  const V change = larger(smaller(relativeVolume - all(V(), 1.0), all(V(), kLargestSwelling)),
                          all(V(), kLargestShrinking));
  const V crush = smaller(change + all(V(), 1.0 - kCrushed), all(V(), 0.0));
  return all(V(), 0.0) - (modulus * larger(change, all(V(), kLargestCompression)) + crushModulus * crush);
}

/// The forces (N) on the last three corners. The force on the first is minus their sum.
template <class V>
struct CornerForces {
  Vector<V> b, c, d;
};

/// Computes the forces from the edges b, c, d from the first corner to the others. Six times the volume is
/// b . (c x d);  six times its gradients at these corners are  c x d, d x b, b x c.
template <class V>
inline CornerForces<V> tetrahedronForces(const Vector<V>& b, const Vector<V>& c, const Vector<V>& d,
                                         V inverseRest, V stabilityScale, V modulus, V crushModulus) {
  const Vector<V> gb = cross(c, d), gc = cross(d, b), gd = cross(b, c);
  const Vector<V> ga{gb.x + gc.x + gd.x, gb.y + gc.y + gd.y, gb.z + gc.z + gd.z};
  const V squares = (dot(ga, ga) + dot(gb, gb)) + (dot(gc, gc) + dot(gd, gd));
  const V push = tetrahedronPush(dot(b, gb) * inverseRest, modulus, crushModulus) * all(V(), 1.0 / 6.0) /
                 larger(stabilityScale * squares, all(V(), 1.0));
  return {scaled(push, gb), scaled(push, gc), scaled(push, gd)};
}

template <class V>
inline Vector<V> displacementFrom(const V* a, const V* b) {
  return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
}

template <class V>
inline void add(V* force, const Vector<V>& f) {
  force[0] = force[0] + f.x, force[1] = force[1] + f.y, force[2] = force[2] + f.z;
}

template <class V>
inline void addTetrahedronForces(const Tetrahedra<V>& t, const V* position, V* force) {
  for (Index i = 0; i < t.count; ++i) {
    const Index* corner = t.corners + 4 * i;
    const V* a = position + 3 * corner[0];
    const CornerForces<V> f = tetrahedronForces(
        displacementFrom(a, position + 3 * corner[1]), displacementFrom(a, position + 3 * corner[2]),
        displacementFrom(a, position + 3 * corner[3]), all(V(), t.inverseRest[i]), t.stabilityScale[i],
        all(V(), *t.modulus), all(V(), *t.crushModulus));
    V* fa = force + 3 * corner[0];
    fa[0] = fa[0] - (f.b.x + (f.c.x + f.d.x));
    fa[1] = fa[1] - (f.b.y + (f.c.y + f.d.y));
    fa[2] = fa[2] - (f.b.z + (f.c.z + f.d.z));
    add(force + 3 * corner[1], f.b);
    add(force + 3 * corner[2], f.c);
    add(force + 3 * corner[3], f.d);
  }
}

// --- springs and points ------------------------------------------------------------------------------------

/// The springs: one entry per spring in each array, three in `direction`.
template <class V>
struct Springs {
  Index count;
  const Index* a;
  const Index* b;
  const double* restLength;
  const double* extensionStiffness;
  const double* compressionStiffness;
  V* direction;
  V* stretch = nullptr;                  ///< m, at the last forces; nullptr: no spring has two stiffnesses
  const double* crossingLoss = nullptr;  ///< m/N, see crossingForce(); set if `stretch` is
};

/// m^2. Below this squared length the ends of a spring coincide: 1/length would lose its digits.
constexpr double kCoincidentSquared = 1e-200;

/// The force of a spring.
template <class V>
struct Pull {
  V force;  ///< N, positive: pulls
  V scale;  ///< 1/m, scales the offset of the ends to the direction of a damper; 0 while the spring is slack
  V inverse;  ///< 1/m, 1/length; this and `scale` are 0 while the ends coincide
  V stretch;  ///< m
};

///     F = kE (l - L) if l > L, else kC (l - L)
template <class V>
inline Pull<V> pullOf(V squaredLength, V restLength, V extensionStiffness, V compressionStiffness) {
  const auto apart = squaredLength > all(V(), kCoincidentSquared);
  const V length = squareRoot(select(apart, squaredLength, all(V(), 1.0)));
  const V stretch = length - restLength;
  const V stiffness = select(stretch > all(V(), 0.0), extensionStiffness, compressionStiffness);
  const V inverse = select(apart, all(V(), 1.0) / length, all(V(), 0.0));
  return {stiffness * stretch, select(stiffness > all(V(), 0.0), inverse, all(V(), 0.0)), inverse, stretch};
}

/// Part of the motion along a spring that it loses when it passes its rest length, per (omega h)^2.
constexpr double kCrossingLoss = 0.01;

/// Shares of crossingForce() in the forces of a substep. They act in two half kicks, the last ones of a tick
/// in one, and the first ones of a tick belong to no substep before them.
constexpr double kFirstCrossing = 0.0, kCrossing = 0.5, kLastCrossing = 1.0;

/// Returns the force (N) that a spring lacks, in half a kick, after a substep in which its stiffness has
/// changed by k, at a stretch of 0 on its way from s0 to s1.
///
/// Verlet keeps an energy that differs from the true one by  h^2/12 v.K.v  and smaller terms. Where the
/// stiffness along a spring changes by k, it keeps this only if the pull has an excess of  k |s1 - s0| / 6 in
/// half a kick over the exact impulse. The two half kicks around a crossing at the fraction f of the substep
/// give  k |s1 - s0| f (1 - f):  the same on average, but the difference heats a body without damping. At
/// omega h = 1 a rope that bears no compression gains its energy a thousand times in a minute. So what lacks
/// is   k |s1 - s0| (1/6 - f (1 - f)),   f (1 - f) = -s0 s1 / (s1 - s0)^2.
///
/// What is left has either sign and is small. A loss that is as small, k^2 w h^2 kCrossingLoss (s1 - s0) with
/// the inverse masses w of both ends, lets no energy grow. `loss` is  w h^2 kCrossingLoss.
template <class V>
inline V crossingForce(V s0, V s1, V k, V loss) {
  const V zero = all(V(), 0.0), way = s1 - s0, product = s0 * s1;
  const auto crosses = zero > product;
  const V length = select(crosses, larger(way, zero - way), all(V(), 1.0));
  return select(crosses, k * (length * all(V(), 1.0 / 6.0) + product / length + k * loss * way), zero);
}

/// Stores the direction from a to b and adds the forces to both ends, with this share of crossingForce().
template <class V>
inline void addForce(const Springs<V>& s, Index i, const Points<V>& p, double crossing) {
  const V* xa = p.position + 3 * s.a[i];
  const V* xb = p.position + 3 * s.b[i];
  const V dx = xb[0] - xa[0], dy = xb[1] - xa[1], dz = xb[2] - xa[2];
  const Pull<V> pull = pullOf(dx * dx + (dy * dy + dz * dz), all(V(), s.restLength[i]),
                              all(V(), s.extensionStiffness[i]), all(V(), s.compressionStiffness[i]));
  V* n = s.direction + 3 * i;
  n[0] = dx * pull.scale, n[1] = dy * pull.scale, n[2] = dz * pull.scale;
  V fx = pull.force * n[0], fy = pull.force * n[1], fz = pull.force * n[2];
  if (s.stretch) {
    const V difference = all(V(), s.extensionStiffness[i] - s.compressionStiffness[i]);
    const V force = pull.force + all(V(), crossing) * crossingForce(s.stretch[i], pull.stretch, difference,
                                                                    all(V(), s.crossingLoss[i]));
    s.stretch[i] = pull.stretch;
    fx = force * (dx * pull.inverse), fy = force * (dy * pull.inverse), fz = force * (dz * pull.inverse);
  }
  V* fa = p.force + 3 * s.a[i];
  V* fb = p.force + 3 * s.b[i];
  fa[0] = fa[0] + fx, fa[1] = fa[1] + fy, fa[2] = fa[2] + fz;
  fb[0] = fb[0] - fx, fb[1] = fb[1] - fy, fb[2] = fb[2] - fz;
}

template <class V>
inline void computeForces(const Springs<V>& s, const Points<V>& p, double crossing) {
  for (Index i = 0; i < 3 * p.count; ++i) p.force[i] = all(V(), 0.0);
  for (Index i = 0; i < s.count; ++i) addForce(s, i, p, crossing);
}

/// Applies the damping impulse to both ends: `factor` (kg) times their relative speed along the spring.
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
inline void dampAll(const Springs<V>& s, const double* factor, bool forward, const Points<V>& p) {
  if (forward)
    for (Index i = 0; i < s.count; ++i) damp(s, i, all(V(), factor[i]), p);
  else
    for (Index i = s.count; i-- > 0;) damp(s, i, all(V(), factor[i]), p);
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

/// Callbacks for the drag and the contacts of points, except those with fixed planes.
struct ContactCalls {
  void* context;  ///< nullptr: no contacts and no drag
  bool always;    ///< they are needed in each substep, not only once a point leaves its search region
  void (*stop)(void* context, double time, double dt);
  void (*drag)(void* context);
  void (*settle)(void* context);
};

/// A single body, or one body per lane. Bodies in lanes share their springs and volume terms.
template <class V>
struct Body {
  Springs<V> springs;
  Points<V> points;
  Volumes<V> volumes;
  Tetrahedra<V> tetrahedra;
  int sweepCount;  ///< over the dampers in a substep; 0: no dampers
  const double* dampHalf;
  const double* dampFull;
  const ContactCalls* contactCalls;
  V* earlierForce;  ///< #points x 3, scratch
  Planes<V> planes = {};
  SearchRegions<V> regions = {};

  int sweeps() const { return sweepCount; }
  const ContactCalls& contacts() const { return *contactCalls; }
};

template <class V>
inline void computeForces(const Body<V>& body, double crossing) {
  computeForces(body.springs, body.points, crossing);
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

template <class V>
inline void stopAtPlanes(const Body<V>& body, double time, double dt) {
  stopAtPlanes(body.planes, body.points, time, dt);
}

template <class V>
inline void settleAtPlanes(const Body<V>& body) {
  settleAtPlanes(body.planes, body.points);
}

template <class V>
inline bool anyLeaves(const Body<V>& body, double dt) {
  return anyLeaves(body.regions, body.points, dt);
}

/// Computes the forces at the end of a substep. Returns the sum over the points of the squared change of
/// acceleration in the substep.
template <class V>
inline V computeForcesAndChange(const Body<V>& body, double crossing) {
  const Points<V>& p = body.points;
  for (Index i = 0; i < 3 * p.count; ++i) body.earlierForce[i] = p.force[i];
  computeForces(body, crossing);
  V sum[3] = {all(V(), 0.0), all(V(), 0.0), all(V(), 0.0)};
  for (Index i = 0; i < p.count; ++i)
    for (Index c = 0; c < 3; ++c) {
      const V change = (p.force[3 * i + c] - body.earlierForce[3 * i + c]) * p.inverseMass[3 * i + c];
      sum[c] = sum[c] + change * change;
    }
  return sum[0] + (sum[1] + sum[2]);
}

/// Applies the dampers in successive sweeps, in alternating order: forward first, or backward.
template <class Stepped>
inline void dampInSweeps(const Stepped& body, bool whole, bool forward) {
  for (int k = 0; k < body.sweeps(); ++k) dampAll(body, whole, (k % 2 == 0) == forward);
}

/// Implements stepVerlet() of verlet_step.h for bodies without links. `Stepped` is Body<V> or another type
/// with the same functions (spring_kernel.inl). Returns the larger result of computeForcesAndChange() in
/// the middle and the last substep (only the last if `substeps` is odd).
template <class V, class Stepped>
inline V stepAlone(const Stepped& body, double tick, int substeps) {
  const ContactCalls& contacts = body.contacts();
  const double dt = tick / substeps;
  bool calls = contacts.context && contacts.always;
  V change = all(V(), 0.0);
  computeForces(body, kFirstCrossing);
  dampInSweeps(body, false, false);
  for (int s = 0; s < substeps; ++s) {
    const bool last = s + 1 == substeps;
    kick(body, 0.5 * dt);
    stopAtPlanes(body, s * dt, dt);
    calls = calls || (contacts.context && anyLeaves(body, dt));
    if (calls) contacts.stop(contacts.context, s * dt, dt);
    drift(body, dt);
    if (last || 2 * s == substeps) {
      const V now = computeForcesAndChange(body, last ? kLastCrossing : kCrossing);
      change = select(now > change, now, change);
    } else {
      computeForces(body, kCrossing);
    }
    kick(body, 0.5 * dt);
    if (calls) contacts.drag(contacts.context);
    settleAtPlanes(body);
    if (calls) contacts.settle(contacts.context);
    dampInSweeps(body, !last, s % 2 == 0);
  }
  return change;
}

}  // namespace limber::kernel
