// SPDX-License-Identifier: Zlib
#include "springs/float_lanes.h"

#if defined(LIMBER_HAS_LANES)
#define LIMBER_PACK_BITS 256
#define LIMBER_FLOAT_STEP stepFloatsAvx2
#include "solver/target_begin.h"

#include "springs/float_lanes.inl"

#include "solver/target_end.h"
#endif
