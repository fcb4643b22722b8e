// SPDX-License-Identifier: Zlib
#pragma once

// What verlet_kernel.h needs of a number: a double, or a pack of doubles in one vector register. With
// LIMBER_PACK_LANES (2, 4 or 8) defined before it, `Pack` is the register of the instruction set that the
// including source is compiled for. A vector type itself and not a class around one, which GCC would copy
// through memory.

#if defined(LIMBER_PACK_LANES)
#include <immintrin.h>
#else
#include <cmath>
#endif

namespace limber::kernel {

#if defined(LIMBER_PACK_LANES)

typedef double Pack __attribute__((vector_size(LIMBER_PACK_LANES * sizeof(double))));

namespace {

#if LIMBER_PACK_LANES == 8
// masked: GCC 12 warns of its own header in the plain one
inline Pack squareRoot(Pack x) { return _mm512_maskz_sqrt_pd(0xff, x); }
#elif LIMBER_PACK_LANES == 4
inline Pack squareRoot(Pack x) { return _mm256_sqrt_pd(x); }
#else
inline Pack squareRoot(Pack x) { return _mm_sqrt_pd(x); }
#endif

inline Pack all(Pack, double x) { return x - Pack{}; }

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
