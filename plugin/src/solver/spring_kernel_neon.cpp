// SPDX-License-Identifier: Zlib
#include "solver/lane_kernels.h"

#if defined(LIMBER_HAS_NEON_LANES)
#include "solver/target_begin.h"

#include "solver/verlet_kernel.h"

#include <arm_neon.h>

namespace limber::kernel {
namespace {

using Pair = float64x2_t;

/// Two registers of two doubles.
struct Quad {
  Pair low, high;
};

struct QuadMask {
  uint64x2_t low, high;
};

Quad operator+(Quad a, Quad b) { return {vaddq_f64(a.low, b.low), vaddq_f64(a.high, b.high)}; }
Quad operator-(Quad a, Quad b) { return {vsubq_f64(a.low, b.low), vsubq_f64(a.high, b.high)}; }
Quad operator*(Quad a, Quad b) { return {vmulq_f64(a.low, b.low), vmulq_f64(a.high, b.high)}; }
Quad operator/(Quad a, Quad b) { return {vdivq_f64(a.low, b.low), vdivq_f64(a.high, b.high)}; }
QuadMask operator>(Quad a, Quad b) { return {vcgtq_f64(a.low, b.low), vcgtq_f64(a.high, b.high)}; }
QuadMask operator<(Quad a, Quad b) { return {vcltq_f64(a.low, b.low), vcltq_f64(a.high, b.high)}; }
QuadMask operator>=(Quad a, Quad b) { return {vcgeq_f64(a.low, b.low), vcgeq_f64(a.high, b.high)}; }
Quad operator-(Quad a) { return {vnegq_f64(a.low), vnegq_f64(a.high)}; }
bool any(QuadMask which) {
  const uint64x2_t lanes = vorrq_u64(which.low, which.high);
  return (vgetq_lane_u64(lanes, 0) | vgetq_lane_u64(lanes, 1)) != 0;
}
Quad squareRoot(Quad a) { return {vsqrtq_f64(a.low), vsqrtq_f64(a.high)}; }
Quad all(Quad, double x) { return {vdupq_n_f64(x), vdupq_n_f64(x)}; }
Quad select(QuadMask which, Quad yes, Quad no) {
  return {vbslq_f64(which.low, yes.low, no.low), vbslq_f64(which.high, yes.high, no.high)};
}

/// Four vectors, each as a Quad x, y, z, 0.
struct Rows {
  Quad row[4];
};

Quad fourAt(const double* numbers) { return {vld1q_f64(numbers), vld1q_f64(numbers + 2)}; }

void store(double* numbers, Quad q) {
  vst1q_f64(numbers, q.low);
  vst1q_f64(numbers + 2, q.high);
}

double total(Quad q) {
  return vgetq_lane_f64(q.low, 0) + (vgetq_lane_f64(q.low, 1) + vgetq_lane_f64(q.high, 0));
}

template <int i>
Quad spread(Quad v) {
  const Pair x = vdupq_laneq_f64(i < 2 ? v.low : v.high, i % 2);
  return {x, x};
}

/// Returns x, y and z of four points.
Vector<Quad> columns(Quad p0, Quad p1, Quad p2, Quad p3) {
  return {{vzip1q_f64(p0.low, p1.low), vzip1q_f64(p2.low, p3.low)},
          {vzip2q_f64(p0.low, p1.low), vzip2q_f64(p2.low, p3.low)},
          {vzip1q_f64(p0.high, p1.high), vzip1q_f64(p2.high, p3.high)}};
}

Rows rows(const Vector<Quad>& v) {
  const Pair zero = vdupq_n_f64(0.0);
  return {{{vzip1q_f64(v.x.low, v.y.low), vzip1q_f64(v.z.low, zero)},
           {vzip2q_f64(v.x.low, v.y.low), vzip2q_f64(v.z.low, zero)},
           {vzip1q_f64(v.x.high, v.y.high), vzip1q_f64(v.z.high, zero)},
           {vzip2q_f64(v.x.high, v.y.high), vzip2q_f64(v.z.high, zero)}}};
}

/// Returns y, z, x, 0.
Quad rolled(Quad v) {
  return {vextq_f64(v.low, v.high, 1), vcombine_f64(vget_low_f64(v.low), vget_high_f64(v.high))};
}

/// Returns z, x, y, 0.
Quad rolledBack(Quad v) { return {vzip1q_f64(v.high, v.low), vzip2q_f64(v.low, v.high)}; }

void leaveKernel() {}

}  // namespace
}  // namespace limber::kernel

#include "solver/spring_kernel.inl"

#include "solver/target_end.h"
#endif
