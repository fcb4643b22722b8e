// SPDX-License-Identifier: Zlib
#pragma once

// The arithmetic of a Verlet substep, written once for a number `V` that is a double or a pack of doubles of
// several bodies. Every operation is one IEEE operation per lane, so all give the same bits.
// Included by sources that are compiled for different instruction sets: nothing here but templates on V,
// which the sets' own types keep apart, and no standard header.
//
// With LIMBER_PACK_BITS (128, 256 or 512) defined before it, `Pack` is the register of that size of the
// instruction set that the including source is compiled for. A vector type itself and not a class around one,
// which GCC would copy through memory. Its numbers are doubles unless LIMBER_PACK_NUMBER says otherwise: the
// bench measures floats.

#if defined(LIMBER_PACK_BITS)
#include <immintrin.h>
#else
#include <cmath>
#endif

namespace limber::kernel {

// --- numbers -----------------------------------------------------------------------------------------------

#if defined(LIMBER_PACK_BITS)

#if !defined(LIMBER_PACK_NUMBER)
#define LIMBER_PACK_NUMBER double
#endif

typedef LIMBER_PACK_NUMBER Pack __attribute__((vector_size(LIMBER_PACK_BITS / 8)));

namespace {

#if LIMBER_PACK_BITS == 512
// masked: GCC 12 warns of its own header in the plain ones
inline __m512d squareRoot(__m512d x) { return _mm512_maskz_sqrt_pd(0xff, x); }
inline __m512 squareRoot(__m512 x) { return _mm512_maskz_sqrt_ps(0xffff, x); }
#elif LIMBER_PACK_BITS == 256
inline __m256d squareRoot(__m256d x) { return _mm256_sqrt_pd(x); }
inline __m256 squareRoot(__m256 x) { return _mm256_sqrt_ps(x); }
#else
inline __m128d squareRoot(__m128d x) { return _mm_sqrt_pd(x); }
inline __m128 squareRoot(__m128 x) { return _mm_sqrt_ps(x); }
#endif

inline Pack all(Pack, double x) { return static_cast<LIMBER_PACK_NUMBER>(x) - Pack{}; }

template <class Mask>
inline Pack select(Mask which, Pack yes, Pack no) {
  return which ? yes : no;
}

}  // namespace

#else

inline double squareRoot(double x) { return std::sqrt(x); }

#endif

namespace {  // of every source its own: each is compiled for another instruction set

inline double all(double, double x) { return x; }
inline double select(bool which, double yes, double no) { return which ? yes : no; }

}  // namespace

// --- the volume term of closed surfaces --------------------------------------------------------------------

using Index = unsigned int;

/// The closed surfaces of a body.
template <class V>
struct Volumes {
  Index components = 0;                  ///< 0: no volume term
  Index points = 0;                      ///< of the body
  const Index* firstTriangle = nullptr;  ///< #components + 1
  const Index* corners = nullptr;        ///< 3 x #triangles, point indices
  const Index* componentOf = nullptr;    ///< #points; of points of none, any
  const V* restVolume = nullptr;         ///< #components, m^3
  const V* modulus = nullptr;            ///< Pa, one
  const V* pressure = nullptr;           ///< Pa, one
  V* gradient = nullptr;                 ///< 3 x #points, scratch: six times the gradient of the volume
  V* sums = nullptr;                     ///< 4 x #components, scratch
  double timeStep = 0.0;                 ///< s, of the substep that must be stable; 0: any
};

/// The relative change of volume beyond which the push against it no longer grows: a body blown up to twice
/// its volume or turned inside out. More would ask for ever smaller substeps of bodies that are scattered
/// anyhow.
constexpr double kLargestSwelling = 1.0, kLargestShrinking = -2.0;

/// Share of the rest volume below which gas is not compressed further.
constexpr double kMinGasVolume = 0.1;

/// (omega dt)^2 from which on the push is held back. Far below Verlet's limit of 4, far above what the
/// substeps of a body in its shape come to.
constexpr double kLargestPhaseSquared = 1.0;

template <class V>
inline V larger(V a, V b) {
  return select(a > b, a, b);
}

template <class V>
inline V smaller(V a, V b) {
  return select(a < b, a, b);
}

/// Of a closed surface at one volume.
template <class V>
struct Push {
  V push;       ///< Pa: by how much the inside pushes outwards,  P V0 / V - K (V - V0) / V0
  V stiffness;  ///< Pa/m^3: how fast that falls with the volume, its limits apart
};

template <class V>
inline Push<V> pushOf(V volume, V restVolume, V modulus, V pressure) {
  const V change = (volume - restVolume) / restVolume;
  const V limited = larger(smaller(change, all(V(), kLargestSwelling)), all(V(), kLargestShrinking));
  const V gas = restVolume / larger(volume, all(V(), kMinGasVolume) * restVolume);
  return {pressure * gas - modulus * limited, (modulus + pressure * gas * gas) / restVolume};
}

/// Six times the volume of a component, which a point of it is the origin of, so that far away from the
/// world's nothing is lost:  6 V = sum (a - o) . n,   n = (b - a) x (c - a). Adds n to the gradient at the
/// triangle's corners: a third of the area vectors around a point, n / 6 each.
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

/// Six times the volume into sums[4 c], and sum w g^2 by axis, g six times the gradient, behind it.
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

/// Pa/6: what a component pushes with, from six volumes and the sum of w g^2.
///
/// Along the gradient the volume oscillates with  omega^2 = stiffness sum w |gradient|^2, which has no bound
/// while a body is torn apart. What the substep does not resolve is held back to what it does: still a push
/// towards the rest volume, by no more than the substep can take.
template <class V>
inline V stablePush(V sixVolume, V squares, V restVolume, V modulus, V pressure, double timeStep) {
  const Push<V> p = pushOf(sixVolume * all(V(), 1.0 / 6.0), restVolume, modulus, pressure);
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
    s[0] = stablePush(s[0], s[1] + (s[2] + s[3]), v.restVolume[c], *v.modulus, *v.pressure, v.timeStep);
  }
  for (Index i = 0; i < v.points; ++i) {
    const V push = v.sums[4 * v.componentOf[i]];
    for (Index axis = 3 * i; axis < 3 * i + 3; ++axis) force[axis] = force[axis] + push * v.gradient[axis];
  }
}

// --- the volume term of tetrahedra -------------------------------------------------------------------------

/// Share of its volume below which a tetrahedron counts as crushed: no part of common deformations.
constexpr double kCrushed = 0.3;

/// The tetrahedra of a body.
template <class V>
struct Tetrahedra {
  Index count = 0;                    ///< 0: none
  const Index* corners = nullptr;     ///< 4 x count, point indices
  const V* inverseRest = nullptr;     ///< count, 1/m^3, one over six rest volumes
  const V* stabilityScale = nullptr;  ///< count, 1/m^4, see TetrahedronVolumes
  const V* modulus = nullptr;         ///< Pa, one
  const V* crushModulus = nullptr;    ///< Pa, one
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

/// Pa: by how much the tetrahedron pushes outwards at this share of its rest volume.
template <class V>
inline V tetrahedronPush(V relativeVolume, V modulus, V crushModulus) {
  const V change = larger(smaller(relativeVolume - all(V(), 1.0), all(V(), kLargestSwelling)),
                          all(V(), kLargestShrinking));
  const V crush = smaller(change + all(V(), 1.0 - kCrushed), all(V(), 0.0));
  return all(V(), 0.0) - (modulus * change + crushModulus * crush);
}

/// N: the forces on the last three corners; the first has minus their sum.
template <class V>
struct CornerForces {
  Vector<V> b, c, d;
};

/// With edges b, c, d from the first corner to the others six volumes are  b . (c x d), and six gradients by
/// the corners  c x d, d x b, b x c.
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
        displacementFrom(a, position + 3 * corner[3]), t.inverseRest[i], t.stabilityScale[i], *t.modulus,
        *t.crushModulus);
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
/// its functions (spring_kernel_avx2.cpp). Returns the larger computeForcesAndChange of a substep in the
/// middle and the last.
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
