// SPDX-License-Identifier: Zlib
#pragma once

// The arithmetic of a Verlet substep for a number type `V`: a double, or a pack of doubles of several bodies.

#include "solver/plane_kernel.h"

namespace limber::kernel {

// --- vectors -----------------------------------------------------------------------------------------------

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

template <class V>
inline Vector<V> displacementFrom(const V* a, const V* b) {
  return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
}

template <class V>
inline void store(const Vector<V>& from, V* to) {
  to[0] = from.x, to[1] = from.y, to[2] = from.z;
}

template <class V>
inline void add(V* sum, const Vector<V>& a) {
  sum[0] = sum[0] + a.x, sum[1] = sum[1] + a.y, sum[2] = sum[2] + a.z;
}

template <class V>
inline void subtract(V* sum, const Vector<V>& a) {
  sum[0] = sum[0] - a.x, sum[1] = sum[1] - a.y, sum[2] = sum[2] - a.z;
}

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
  Vector<V> sum{all(V(), 0.0), all(V(), 0.0), all(V(), 0.0)};
  const V* origin = position + 3 * v.corners[3 * v.firstTriangle[component]];
  for (Index t = v.firstTriangle[component]; t < v.firstTriangle[component + 1]; ++t) {
    const Index* corner = v.corners + 3 * t;
    const V* a = position + 3 * corner[0];
    const Vector<V> n =
        cross(displacementFrom(a, position + 3 * corner[1]), displacementFrom(a, position + 3 * corner[2]));
    const Vector<V> from = displacementFrom(origin, a);
    sum = {sum.x + from.x * n.x, sum.y + from.y * n.y, sum.z + from.z * n.z};
    for (Index k = 0; k < 3; ++k) add(v.gradient + 3 * corner[k], n);
  }
  return sum.x + (sum.y + sum.z);
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
inline void addTetrahedronForces(const Tetrahedra<V>& t, const V* position, V* force) {
  for (Index i = 0; i < t.count; ++i) {
    const Index* corner = t.corners + 4 * i;
    const V* a = position + 3 * corner[0];
    const CornerForces<V> f = tetrahedronForces(
        displacementFrom(a, position + 3 * corner[1]), displacementFrom(a, position + 3 * corner[2]),
        displacementFrom(a, position + 3 * corner[3]), all(V(), t.inverseRest[i]), t.stabilityScale[i],
        all(V(), *t.modulus), all(V(), *t.crushModulus));
    subtract(force + 3 * corner[0],
             Vector<V>{f.b.x + (f.c.x + f.d.x), f.b.y + (f.c.y + f.d.y), f.b.z + (f.c.z + f.d.z)});
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
  const Index a = 3 * s.a[i], b = 3 * s.b[i];
  const Vector<V> d = displacementFrom(p.position + a, p.position + b);
  const Pull<V> pull = pullOf(dot(d, d), all(V(), s.restLength[i]), all(V(), s.extensionStiffness[i]),
                              all(V(), s.compressionStiffness[i]));
  const Vector<V> n = scaled(pull.scale, d);
  store(n, s.direction + 3 * i);
  Vector<V> force = scaled(pull.force, n);
  if (s.stretch) {
    const V difference = all(V(), s.extensionStiffness[i] - s.compressionStiffness[i]);
    const V crossed = pull.force + all(V(), crossing) * crossingForce(s.stretch[i], pull.stretch, difference,
                                                                      all(V(), s.crossingLoss[i]));
    s.stretch[i] = pull.stretch;
    force = scaled(crossed, scaled(pull.inverse, d));
  }
  add(p.force + a, force);
  subtract(p.force + b, force);
}

template <class V>
inline void computeForces(const Springs<V>& s, const Points<V>& p, double crossing) {
  for (Index i = 0; i < 3 * p.count; ++i) p.force[i] = all(V(), 0.0);
  for (Index i = 0; i < s.count; ++i) addForce(s, i, p, crossing);
}

/// Applies the damping impulse to both ends: `factor` (kg) times their relative speed along the spring.
template <class V>
inline void damp(const Springs<V>& s, Index i, const V& factor, const Points<V>& p) {
  const Index a = 3 * s.a[i], b = 3 * s.b[i];
  const V *n = s.direction + 3 * i, *wa = p.inverseMass + a, *wb = p.inverseMass + b;
  const Vector<V> direction{n[0], n[1], n[2]};
  const V speed = dot(direction, displacementFrom(p.velocity + a, p.velocity + b));
  const Vector<V> j = scaled(factor * speed, direction);
  add(p.velocity + a, Vector<V>{j.x * wa[0], j.y * wa[1], j.z * wa[2]});
  subtract(p.velocity + b, Vector<V>{j.x * wb[0], j.y * wb[1], j.z * wb[2]});
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

// --- bodies ------------------------------------------------------------------------------------------------

/// The drag and the contacts of points, except those with fixed planes.
struct ContactCalls {
  bool always = true;  ///< they are needed in each substep, not only once a point leaves its search region

  virtual void stop(double time, double dt) = 0;
  virtual void drag(double dt) = 0;
  virtual void settle() = 0;

 protected:
  ~ContactCalls() = default;
};

/// A single body, or one body per lane. Bodies in lanes share their springs and volume terms.
template <class V>
struct Body {
  Springs<V> springs;
  Points<V> points;
  Volumes<V> volumes;
  Tetrahedra<V> tetrahedra;
  int sweeps;  ///< over the dampers in a substep; 0: no dampers
  const double *dampHalf, *dampFull;
  ContactCalls* contacts;  ///< nullptr: no contacts and no drag
  V* earlierForce;         ///< #points x 3, scratch
  Planes<V> planes;
  SearchRegions<V> regions;

  void kick(double dt) const { kernel::kick(points, dt); }
  void drift(double dt) const { kernel::drift(points, dt); }
  void damp(bool whole, bool forward) const {
    dampAll(springs, whole ? dampFull : dampHalf, forward, points);
  }
  void stopAtPlanes(double time, double dt) const { kernel::stopAtPlanes(planes, points, time, dt); }
  void settleAtPlanes() const { kernel::settleAtPlanes(planes, points); }
  bool anyLeaves(double dt) const { return kernel::anyLeaves(regions, points, dt); }

  void computeForces(double crossing) const {
    kernel::computeForces(springs, points, crossing);
    addVolumeForces(volumes, points.position, points.inverseMass, points.force);
    addTetrahedronForces(tetrahedra, points.position, points.force);
  }

  /// Computes the forces at the end of a substep. Returns the sum over the points of the squared change of
  /// acceleration in the substep.
  V computeForcesAndChange(double crossing) const {
    for (Index i = 0; i < 3 * points.count; ++i) earlierForce[i] = points.force[i];
    computeForces(crossing);
    V sum[3] = {all(V(), 0.0), all(V(), 0.0), all(V(), 0.0)};
    for (Index i = 0; i < 3 * points.count; i += 3)
      for (Index c = 0; c < 3; ++c) {
        const V change = (points.force[i + c] - earlierForce[i + c]) * points.inverseMass[i + c];
        sum[c] = sum[c] + change * change;
      }
    return sum[0] + (sum[1] + sum[2]);
  }
};

/// The ends of springs in strips (Strips of springs.h).
struct StripBody {
  /// Numbers of a slot: for each of these quantities x of its points, one from each strip, then y and z.
  static constexpr unsigned kPosition = 0, kVelocity = 12, kForce = 24, kInverseMass = 36, kNumbers = 48;

  unsigned slots = 0;         ///< 0: not in strips
  unsigned points = 0;        ///< of the body
  double* numbers = nullptr;  ///< kNumbers x #slots, and one more that a shifted batch reads
};

/// A body whose springs are computed four at a time. Each point has four doubles in each array: x, y, z, 0;
/// each spring and tetrahedron has one number per array, and the numbers of both are multiples of four.
/// `springs.direction` has only 1/m, 0 while a spring is slack. In strips `springs.a` and `b` have one entry
/// per batch: the first number of its first spring's end. `volumes.sums` has 8 numbers per component.
struct SpringBatchBody : Body<double> {
  const unsigned char* apart;  ///< per batch of four springs: whether they share no point; not used in strips
  StripBody strips;
};

/// The points, or slots, from `begin` to `end`, or those with these entries of `numbers`, if it is set.
struct BatchPoints {
  unsigned begin, end;
  const unsigned* numbers = nullptr;
};

// --- the step ----------------------------------------------------------------------------------------------

/// Applies the dampers in successive sweeps, in alternating order: forward first, or backward.
template <class Stepped>
inline void dampInSweeps(const Stepped& body, bool whole, bool forward) {
  for (int k = 0; k < body.sweeps; ++k) body.damp(whole, (k % 2 == 0) == forward);
}

/// Implements stepVerlet() of verlet_step.h for bodies without links. `Stepped` is Body<V> or another type
/// with the same members (spring_kernel.inl). Returns the larger result of computeForcesAndChange() in
/// the middle and the last substep (only the last if `substeps` is odd).
template <class V, class Stepped>
inline V stepAlone(const Stepped& body, double tick, int substeps) {
  const double dt = tick / substeps;
  bool calls = body.contacts && body.contacts->always;
  V change = all(V(), 0.0);
  body.computeForces(kFirstCrossing);
  dampInSweeps(body, false, false);
  for (int s = 0; s < substeps; ++s) {
    const bool last = s + 1 == substeps;
    body.kick(0.5 * dt);
    body.stopAtPlanes(s * dt, dt);
    calls = calls || (body.contacts && body.anyLeaves(dt));
    if (calls) body.contacts->stop(s * dt, dt);
    body.drift(dt);
    if (last || 2 * s == substeps) {
      const V now = body.computeForcesAndChange(last ? kLastCrossing : kCrossing);
      change = select(now > change, now, change);
    } else {
      body.computeForces(kCrossing);
    }
    body.kick(0.5 * dt);
    if (calls) body.contacts->drag(dt);
    body.settleAtPlanes();
    if (calls) body.contacts->settle();
    dampInSweeps(body, !last, s % 2 == 0);
  }
  return change;
}

}  // namespace limber::kernel
