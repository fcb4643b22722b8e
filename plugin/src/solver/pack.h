// SPDX-License-Identifier: Zlib
#pragma once

// The number types of the kernels: a double, or a pack of doubles of several bodies. Every operation is one
// IEEE operation per lane, so all types give the same results, to the bit.
// Source files for different instruction sets include the kernels. Therefore these contain only templates on
// the number type, whose instances differ because each set has its own type, and include no standard header.
//
// If LIMBER_PACK_BITS (128, 256 or 512) is defined before, `Pack` is a register of that size of the
// instruction set for which the including file is compiled. It is a plain vector type, because GCC would copy
// a class with such a member through memory.

#if defined(LIMBER_PACK_BITS) && defined(__aarch64__)
#include <arm_neon.h>
#elif defined(LIMBER_PACK_BITS)
#include <immintrin.h>
#else
#include <cmath>
#endif

namespace limber::kernel {

#if defined(LIMBER_PACK_BITS)

typedef double Pack __attribute__((vector_size(LIMBER_PACK_BITS / 8)));

namespace {

#if defined(__aarch64__)
inline float64x2_t squareRoot(float64x2_t x) { return vsqrtq_f64(x); }
#elif LIMBER_PACK_BITS == 512
// masked, because GCC 12 warns about its own header for the unmasked functions
inline __m512d squareRoot(__m512d x) { return _mm512_maskz_sqrt_pd(0xff, x); }
#elif LIMBER_PACK_BITS == 256
inline __m256d squareRoot(__m256d x) { return _mm256_sqrt_pd(x); }
#else
inline __m128d squareRoot(__m128d x) { return _mm_sqrt_pd(x); }
#endif

inline Pack all(Pack, double x) { return x - Pack{}; }

template <class Mask>
inline Pack select(Mask which, Pack yes, Pack no) {
  return which ? yes : no;
}

/// Whether a lane of a comparison is true.
template <class Mask>
inline bool any(Mask which) {
#if defined(__aarch64__)
  return (which[0] | which[1]) != 0;
#elif LIMBER_PACK_BITS == 512
  const auto bits = reinterpret_cast<__m512i>(which);
  return _mm512_test_epi64_mask(bits, bits) != 0;
#elif LIMBER_PACK_BITS == 256
  return _mm256_movemask_pd(reinterpret_cast<__m256d>(which)) != 0;
#else
  return _mm_movemask_pd(reinterpret_cast<__m128d>(which)) != 0;
#endif
}

}  // namespace

#else

inline double squareRoot(double x) { return std::sqrt(x); }

#endif

namespace {  // separate copies per source file: each is compiled for a different instruction set

inline double all(double, double x) { return x; }
inline double select(bool which, double yes, double no) { return which ? yes : no; }
inline bool any(bool which) { return which; }

}  // namespace

template <class V>
inline V larger(V a, V b) {
  return select(a > b, a, b);
}

template <class V>
inline V smaller(V a, V b) {
  return select(a < b, a, b);
}

using Index = unsigned int;

}  // namespace limber::kernel
