// SPDX-License-Identifier: Zlib
#include "springs/float_lanes.h"

#if defined(LIMBER_HAS_LANES)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("sse2"))), apply_to = function)
#pragma STDC FP_CONTRACT OFF
#else
#pragma GCC target("sse2")
#pragma GCC optimize("fp-contract=off")
#endif

#define LIMBER_PACK_BITS 128
#define LIMBER_FLOAT_STEP stepFloatsSse2
#include "springs/float_lanes.inl"

#if defined(__clang__)
#pragma clang attribute pop
#endif
#endif
