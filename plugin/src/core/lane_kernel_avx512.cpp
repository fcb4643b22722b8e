// SPDX-License-Identifier: Zlib
#include "core/lane_kernels.h"

#if defined(LIMBER_HAS_LANES)
#define LIMBER_PACK_BITS 512
#define LIMBER_PACK_STEP stepAvx512
#include "core/target_begin.h"

#include "core/lane_kernel.inl"

#include "core/target_end.h"
#endif
