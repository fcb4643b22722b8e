// SPDX-License-Identifier: Zlib
#pragma once

// What verlet_kernel.h needs of a number: a double, or a pack of doubles in one vector register. With
// LIMBER_PACK_BITS (128, 256 or 512) defined before it, `Pack` is the register of that size of the
// instruction set that the including source is compiled for. A vector type itself and not a class around one,
// which GCC would copy through memory. Its numbers are doubles unless LIMBER_PACK_NUMBER says otherwise: the
// bench measures floats.

#if defined(LIMBER_PACK_BITS)
#include <immintrin.h>
#else
#include <cmath>
#endif

namespace limber::kernel {

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

}  // namespace limber::kernel
