// SPDX-License-Identifier: Zlib
#pragma once

#include <LinearMath/btScalar.h>

/// Everything that touches Bullet's types lives in an inline namespace named after their precision, so that
/// mixing a float program with a double plugin fails at link time with a telling name, not at run time.
#ifdef BT_USE_DOUBLE_PRECISION
#define LIMBER_BULLET_PRECISION bullet_double
#else
#define LIMBER_BULLET_PRECISION bullet_float
#endif
