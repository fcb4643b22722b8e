// SPDX-License-Identifier: Zlib
#pragma once

// The forces of tetrahedron_volumes.h, written once for a number `V` as verlet_kernel.h is, and included as
// that is.

#include "solver/volume_kernel.h"

namespace limber::kernel {

/// Share of its volume below which a tetrahedron counts as crushed: no part of common deformations.
constexpr double kCrushed = 0.3;

/// The tetrahedra of a body.
template <class V>
struct Tetrahedra {
  Index count = 0;                  ///< 0: none
  const Index* corners = nullptr;   ///< 4 x count, point indices
  const V* inverseRest = nullptr;   ///< count, 1/m^3, one over six rest volumes
  const V* hold = nullptr;          ///< count, 1/m^4, see TetrahedronVolumes
  const V* modulus = nullptr;       ///< Pa, one
  const V* crushModulus = nullptr;  ///< Pa, one
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
                                         V inverseRest, V hold, V modulus, V crushModulus) {
  const Vector<V> gb = cross(c, d), gc = cross(d, b), gd = cross(b, c);
  const Vector<V> ga{gb.x + gc.x + gd.x, gb.y + gc.y + gd.y, gb.z + gc.z + gd.z};
  const V squares = (dot(ga, ga) + dot(gb, gb)) + (dot(gc, gc) + dot(gd, gd));
  const V push = tetrahedronPush(dot(b, gb) * inverseRest, modulus, crushModulus) * all(V(), 1.0 / 6.0) /
                 larger(hold * squares, all(V(), 1.0));
  return {scaled(push, gb), scaled(push, gc), scaled(push, gd)};
}

template <class V>
inline Vector<V> wayFrom(const V* a, const V* b) {
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
        wayFrom(a, position + 3 * corner[1]), wayFrom(a, position + 3 * corner[2]),
        wayFrom(a, position + 3 * corner[3]), t.inverseRest[i], t.hold[i], *t.modulus, *t.crushModulus);
    V* fa = force + 3 * corner[0];
    fa[0] = fa[0] - (f.b.x + (f.c.x + f.d.x));
    fa[1] = fa[1] - (f.b.y + (f.c.y + f.d.y));
    fa[2] = fa[2] - (f.b.z + (f.c.z + f.d.z));
    add(force + 3 * corner[1], f.b);
    add(force + 3 * corner[2], f.c);
    add(force + 3 * corner[3], f.d);
  }
}

}  // namespace limber::kernel
