// SPDX-License-Identifier: Zlib
#pragma once

// The volume term of volume_term.h, written once for a number `V` as verlet_kernel.h is, and included as that
// is.

#include "solver/pack.h"

namespace limber::kernel {

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
constexpr double kLeastGasVolume = 0.1;

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
  const V gas = restVolume / larger(volume, all(V(), kLeastGasVolume) * restVolume);
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

}  // namespace limber::kernel
