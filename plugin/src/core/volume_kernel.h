// SPDX-License-Identifier: Zlib
#pragma once

// The volume term of volume_term.h, written once for a number `V` as verlet_kernel.h is, and included as that
// is.

#include "core/pack.h"

namespace limber::kernel {

using Index = unsigned int;

/// The closed surfaces of a body.
template <class V>
struct Volumes {
  Index components = 0;                  ///< 0: no volume term
  const Index* firstTriangle = nullptr;  ///< #components + 1
  const Index* corners = nullptr;        ///< 3 x #triangles, point indices
  const V* restVolume = nullptr;         ///< #components, m^3
  const V* modulus = nullptr;            ///< Pa, one
  const V* pressure = nullptr;           ///< Pa, one
  V* area = nullptr;                     ///< 3 x #triangles, scratch: twice the area vectors
};

/// The relative change of volume beyond which the push against it no longer grows: a body blown up to twice
/// its volume or turned inside out. More would ask for ever smaller substeps of bodies that are scattered
/// anyhow.
constexpr double kLargestSwelling = 1.0, kLargestShrinking = -2.0;

/// Share of the rest volume below which gas is not compressed further.
constexpr double kLeastGasVolume = 0.1;

template <class V>
inline V larger(V a, V b) {
  return select(a > b, a, b);
}

template <class V>
inline V smaller(V a, V b) {
  return select(a < b, a, b);
}

/// Pa: by how much the inside pushes outwards,  P V0 / V - K (V - V0) / V0.
template <class V>
inline V pushOf(V volume, V restVolume, V modulus, V pressure) {
  const V change = (volume - restVolume) / restVolume;
  const V limited = larger(smaller(change, all(V(), kLargestSwelling)), all(V(), kLargestShrinking));
  const V gas = restVolume / larger(volume, all(V(), kLeastGasVolume) * restVolume);
  return pressure * gas - modulus * limited;
}

/// Writes twice the area vectors of component c and returns six times its volume, which a point of it is the
/// origin of, so that far away from the world's nothing is lost:  6 V = sum (a - o) . ((b - a) x (c - a)).
template <class V>
inline V sixVolumes(const Volumes<V>& v, Index component, const V* position) {
  V sx = all(V(), 0.0), sy = sx, sz = sx;
  const V* o = position + 3 * v.corners[3 * v.firstTriangle[component]];
  for (Index t = v.firstTriangle[component]; t < v.firstTriangle[component + 1]; ++t) {
    const V* a = position + 3 * v.corners[3 * t];
    const V* b = position + 3 * v.corners[3 * t + 1];
    const V* c = position + 3 * v.corners[3 * t + 2];
    const V bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2];
    const V cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
    V* n = v.area + 3 * t;
    n[0] = by * cz - bz * cy, n[1] = bz * cx - bx * cz, n[2] = bx * cy - by * cx;
    sx = sx + (a[0] - o[0]) * n[0], sy = sy + (a[1] - o[1]) * n[1], sz = sz + (a[2] - o[2]) * n[2];
  }
  return sx + (sy + sz);
}

/// The gradient of the volume by a point is a third of the area vectors around it: each triangle gives its
/// corners a sixth of what sixVolumes() has left in v.area.
template <class V>
inline void addVolumeForces(const Volumes<V>& v, const V* position, V* force) {
  const V sixth = all(V(), 1.0 / 6.0);
  for (Index component = 0; component < v.components; ++component) {
    const V volume = sixVolumes(v, component, position) * sixth;
    const V push = pushOf(volume, v.restVolume[component], *v.modulus, *v.pressure) * sixth;
    for (Index t = v.firstTriangle[component]; t < v.firstTriangle[component + 1]; ++t) {
      const V* n = v.area + 3 * t;
      const V fx = push * n[0], fy = push * n[1], fz = push * n[2];
      for (Index corner = 0; corner < 3; ++corner) {
        V* f = force + 3 * v.corners[3 * t + corner];
        f[0] = f[0] + fx, f[1] = f[1] + fy, f[2] = f[2] + fz;
      }
    }
  }
}

}  // namespace limber::kernel
