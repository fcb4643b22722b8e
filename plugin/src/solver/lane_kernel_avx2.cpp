// SPDX-License-Identifier: Zlib
#include "solver/lane_kernels.h"

#if defined(LIMBER_HAS_X86_LANES)
#define LIMBER_PACK_BITS 256
#define LIMBER_PACK_STEP stepAvx2
#include "solver/lane_kernel.inl"
#endif
