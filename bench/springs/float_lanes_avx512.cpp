// SPDX-License-Identifier: Zlib
#include "springs/float_lanes.h"

#if defined(LIMBER_HAS_LANES)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f"))), apply_to = function)
#pragma STDC FP_CONTRACT OFF
#else
#pragma GCC target("avx512f")
#pragma GCC optimize("fp-contract=off")
#endif

#define LIMBER_PACK_BITS 512
#define LIMBER_FLOAT_STEP stepFloatsAvx512
#include "springs/float_lanes.inl"

#if defined(__clang__)
#pragma clang attribute pop
#endif
#endif
