// SPDX-License-Identifier: Zlib
#pragma once

// Sums over the points of a body that describe its motion as a whole, for a number type `V` like that of
// verlet_kernel.h: one pass over the points, in vector registers for several bodies at once.

#include "solver/verlet_kernel.h"

namespace limber::kernel {

/// The motion of a body as a whole at the end of a tick. The means are weighted by the network's mass
/// fractions, which also count held points. d is the offset of a point from point 0.
template <class V>
struct MotionSums {
  V low[3], high[3];            ///< m, bounds of the positions
  V startLow[3], startHigh[3];  ///< m, the same at the start of the tick
  V farthest;                   ///< m^2, square of the largest displacement of a point in the tick
  V meanOffset[3];              ///< m, mean of d
  V meanVelocity[3];            ///< m/s
  V fastest;                    ///< m^2/s^2, square of the largest velocity relative to the mean one
  V moments[9];   ///< m^2, mean of (d - meanOffset) r^T with the scaled rest positions r, column by column
  V mass;         ///< kg, of the points that are not held, as for the sums below
  V moment[3];    ///< kg m, sum of m d
  V second[6];    ///< kg m^2, sum of m d d^T: xx, yy, zz, xy, yz, zx
  V momentum[3];  ///< kg m/s
  V angular[3];   ///< kg m^2/s, sum of m d x v
  V magnitude;    ///< sum of |x| and |v|: if it is finite, all of them are
};

/// The points of a body, or of one body per lane.
template <class V>
struct MovedPoints {
  Index count;
  const V *position, *velocity, *inverseMass;  ///< 3 x count
  const V* start;                              ///< 3 x count, m, positions at the start of the tick
  const double* fraction;                      ///< count, mass fractions
  const double* weightedRest;                  ///< 3 x count, m, rest positions times mass fractions
  MotionSums<V>* sums;                         ///< output
};

template <class V>
inline V magnitudeOf(V x) {
  return select(x < all(V(), 0.0), all(V(), 0.0) - x, x);
}

// Each of the following functions makes one pass over the points, with sums that fit into the registers.

template <class V>
inline void sumBounds(const MovedPoints<V>& p, MotionSums<V>& s) {
  V low[3], high[3], startLow[3], startHigh[3], farthest = all(V(), 0.0), magnitude = farthest;
  for (Index c = 0; c < 3; ++c) {
    low[c] = high[c] = p.position[c];
    startLow[c] = startHigh[c] = p.start[c];
  }
  for (Index i = 0; i < p.count; ++i) {
    V squared = all(V(), 0.0);
    for (Index c = 0; c < 3; ++c) {
      const V x = p.position[3 * i + c], from = p.start[3 * i + c];
      low[c] = smaller(x, low[c]), high[c] = larger(x, high[c]);
      startLow[c] = smaller(from, startLow[c]), startHigh[c] = larger(from, startHigh[c]);
      squared = squared + (x - from) * (x - from);
      magnitude = magnitude + (magnitudeOf(x) + magnitudeOf(p.velocity[3 * i + c]));
    }
    farthest = larger(squared, farthest);
  }
  for (Index c = 0; c < 3; ++c) {
    s.low[c] = low[c], s.high[c] = high[c];
    s.startLow[c] = startLow[c], s.startHigh[c] = startHigh[c];
  }
  s.farthest = farthest, s.magnitude = magnitude;
}

/// The means, and from them the largest relative velocity.
template <class V>
inline void sumMeans(const MovedPoints<V>& p, MotionSums<V>& s) {
  const V zero = all(V(), 0.0);
  Vector<V> offset{zero, zero, zero}, mean = offset;
  for (Index i = 0; i < p.count; ++i) {
    const V fraction = all(V(), p.fraction[i]);
    const V* v = p.velocity + 3 * i;
    const Vector<V> d = displacementFrom(p.position, p.position + 3 * i);
    offset = {offset.x + fraction * d.x, offset.y + fraction * d.y, offset.z + fraction * d.z};
    mean = {mean.x + fraction * v[0], mean.y + fraction * v[1], mean.z + fraction * v[2]};
  }
  store(offset, s.meanOffset), store(mean, s.meanVelocity);
  V fastest = zero;
  for (Index i = 0; i < p.count; ++i) {
    const Vector<V> u = displacementFrom(s.meanVelocity, p.velocity + 3 * i);
    fastest = larger(dot(u, u), fastest);
  }
  s.fastest = fastest;
}

/// The moments of the shape.
template <class V>
inline void sumMoments(const MovedPoints<V>& p, MotionSums<V>& s) {
  V sum[9];
  for (Index k = 0; k < 9; ++k) sum[k] = all(V(), 0.0);
  const V* x0 = p.position;
  for (Index i = 0; i < p.count; ++i) {
    const V* x = p.position + 3 * i;
    const V d[3] = {x[0] - x0[0] - s.meanOffset[0], x[1] - x0[1] - s.meanOffset[1],
                    x[2] - x0[2] - s.meanOffset[2]};
    for (Index k = 0; k < 9; ++k) sum[k] = sum[k] + d[k % 3] * all(V(), p.weightedRest[3 * i + k / 3]);
  }
  for (Index k = 0; k < 9; ++k) s.moments[k] = sum[k];
}

/// Returns the mass of a point, 0 if it is held.
template <class V>
inline V massOf(const V* inverseMass) {
  const V w = larger(larger(inverseMass[0], inverseMass[1]), inverseMass[2]);
  const auto free = w > all(V(), 0.0);
  return select(free, all(V(), 1.0) / select(free, w, all(V(), 1.0)), all(V(), 0.0));
}

/// The sums over the points that are not held.
template <class V>
inline void sumFree(const MovedPoints<V>& p, MotionSums<V>& s) {
  const V zero = all(V(), 0.0);
  V mass = zero, sum[15];
  for (Index k = 0; k < 15; ++k) sum[k] = zero;
  for (Index i = 0; i < p.count; ++i) {
    const V m = massOf(p.inverseMass + 3 * i);
    const V* v = p.velocity + 3 * i;
    const Vector<V> d = displacementFrom(p.position, p.position + 3 * i), md = scaled(m, d),
                    u{v[0], v[1], v[2]};
    mass = mass + m;
    add(sum, md), add(sum + 3, scaled(m, u)), add(sum + 6, cross(md, u));
    add(sum + 9, Vector<V>{md.x * d.x, md.y * d.y, md.z * d.z});
    add(sum + 12, Vector<V>{md.x * d.y, md.y * d.z, md.z * d.x});
  }
  s.mass = mass;
  for (Index c = 0; c < 3; ++c) s.moment[c] = sum[c], s.momentum[c] = sum[3 + c], s.angular[c] = sum[6 + c];
  for (Index k = 0; k < 6; ++k) s.second[k] = sum[9 + k];
}

template <class V>
inline void sumUp(const MovedPoints<V>& p) {
  sumBounds(p, *p.sums);
  sumMeans(p, *p.sums);
  sumMoments(p, *p.sums);
  sumFree(p, *p.sums);
}

}  // namespace limber::kernel
