// SPDX-License-Identifier: Zlib
#include "springs/float_lanes.h"

#if defined(LIMBER_HAS_LANES)
#define LIMBER_PACK_BITS 128
#define LIMBER_FLOAT_STEP stepFloatsSse2
#include "solver/target_begin.h"

#include "springs/float_lanes.inl"

#include "solver/target_end.h"
#endif
