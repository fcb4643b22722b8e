// SPDX-License-Identifier: Zlib
#include "solver/lane_kernels.h"

#if defined(LIMBER_HAS_NEON_LANES)
#define LIMBER_PACK_BITS 128
#define LIMBER_PACK_STEP stepNeon
#include "solver/target_begin.h"

#include "solver/lane_kernel.inl"

#include "solver/target_end.h"
#endif
