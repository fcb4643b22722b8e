// SPDX-License-Identifier: Zlib
// No #pragma once: a source file that defines LIMBER_PACK_BITS includes this header before its code and
// target_end.h after it. The code between them is compiled for the instruction set with registers of that
// size, independent of the project's flags. Multiplications and additions are not fused, because all
// instruction sets must give the same results, to the bit.

#if defined(__aarch64__)  // NEON needs no flags
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#else
#pragma GCC optimize("fp-contract=off")
#endif
#elif defined(__clang__)
#if LIMBER_PACK_BITS == 512
#pragma clang attribute push(__attribute__((target("avx512f"))), apply_to = function)
#elif LIMBER_PACK_BITS == 256
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma clang attribute push(__attribute__((target("sse2"))), apply_to = function)
#endif
#pragma STDC FP_CONTRACT OFF
#else
#if LIMBER_PACK_BITS == 512
#pragma GCC target("avx512f")
#elif LIMBER_PACK_BITS == 256
#pragma GCC target("avx2")
#else
#pragma GCC target("sse2")
#endif
#pragma GCC optimize("fp-contract=off")
#endif
