// SPDX-License-Identifier: Zlib
#include "core/lane_kernels.h"

#if defined(LIMBER_HAS_LANES)
// Compiled for this instruction set whatever the project's flags, and without fusing multiplications and
// additions: all sets must give the same bits.
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("sse2"))), apply_to = function)
#pragma STDC FP_CONTRACT OFF
#else
#pragma GCC target("sse2")
#pragma GCC optimize("fp-contract=off")
#endif

#define LIMBER_PACK_BITS 128
#define LIMBER_PACK_STEP stepSse2
#include "core/lane_kernel.inl"

#if defined(__clang__)
#pragma clang attribute pop
#endif
#endif
