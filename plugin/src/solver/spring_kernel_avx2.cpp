// SPDX-License-Identifier: Zlib
#include "solver/lane_kernels.h"

#if defined(LIMBER_HAS_X86_LANES)
#define LIMBER_PACK_BITS 256
#include "solver/target_begin.h"

#include "solver/verlet_kernel.h"

namespace limber::kernel {
namespace {

using Quad = Pack;

/// Four vectors, each as a Quad x, y, z, 0.
struct Rows {
  Quad row[4];
};

using UnalignedQuad = double __attribute__((vector_size(32), aligned(8), may_alias));

Quad fourAt(const double* numbers) { return *reinterpret_cast<const UnalignedQuad*>(numbers); }
void store(double* numbers, Quad q) { *reinterpret_cast<UnalignedQuad*>(numbers) = q; }

double total(Quad q) { return q[0] + (q[1] + q[2]); }

template <int i>
Quad spread(Quad v) {
  return _mm256_permute4x64_pd(v, i * 0x55);
}

/// Returns x, y and z of four points.
Vector<Quad> columns(Quad p0, Quad p1, Quad p2, Quad p3) {
  const Quad xz01 = _mm256_unpacklo_pd(p0, p1), y01 = _mm256_unpackhi_pd(p0, p1);
  const Quad xz23 = _mm256_unpacklo_pd(p2, p3), y23 = _mm256_unpackhi_pd(p2, p3);
  return {_mm256_permute2f128_pd(xz01, xz23, 0x20), _mm256_permute2f128_pd(y01, y23, 0x20),
          _mm256_permute2f128_pd(xz01, xz23, 0x31)};
}

Rows rows(const Vector<Quad>& v) {
  const Quad zero = all(Quad(), 0.0);
  const Quad xy02 = _mm256_unpacklo_pd(v.x, v.y), xy13 = _mm256_unpackhi_pd(v.x, v.y);
  const Quad z02 = _mm256_unpacklo_pd(v.z, zero), z13 = _mm256_unpackhi_pd(v.z, zero);
  return {{_mm256_permute2f128_pd(xy02, z02, 0x20), _mm256_permute2f128_pd(xy13, z13, 0x20),
           _mm256_permute2f128_pd(xy02, z02, 0x31), _mm256_permute2f128_pd(xy13, z13, 0x31)}};
}

/// Returns y, z, x, 0.
Quad rolled(Quad v) { return _mm256_permute4x64_pd(v, 0xC9); }

/// Returns z, x, y, 0.
Quad rolledBack(Quad v) { return _mm256_permute4x64_pd(v, 0xD2); }

/// GCC leaves this out after a last batch in turn, and all code that follows in SSE becomes slower.
void leaveKernel() { _mm256_zeroupper(); }

}  // namespace
}  // namespace limber::kernel

#include "solver/spring_kernel.inl"

#include "solver/target_end.h"
#endif
