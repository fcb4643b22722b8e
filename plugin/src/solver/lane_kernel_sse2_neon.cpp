// SPDX-License-Identifier: Zlib
#include "solver/lane_kernels.h"

#define LIMBER_PACK_BITS 128
#if defined(LIMBER_HAS_X86_LANES)
#define LIMBER_PACK_STEP stepSse2
#include "solver/lane_kernel.inl"
#elif defined(LIMBER_HAS_NEON_LANES)
#define LIMBER_PACK_STEP stepNeon
#include "solver/lane_kernel.inl"
#endif
