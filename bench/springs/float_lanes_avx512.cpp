// SPDX-License-Identifier: Zlib
#include "springs/float_lanes.h"

#if defined(LIMBER_HAS_LANES)
#define LIMBER_PACK_BITS 512
#define LIMBER_FLOAT_STEP stepFloatsAvx512
#include "solver/target_begin.h"

#include "springs/float_lanes.inl"

#include "solver/target_end.h"
#endif
