// SPDX-License-Identifier: Zlib
#pragma once

#include <LinearMath/btScalar.h>

/// All declarations with Bullet types are in an inline namespace that is named after Bullet's precision. A
/// float program that is linked with a double plugin then fails at link time with a clear symbol name, not at
/// run time.
#ifdef BT_USE_DOUBLE_PRECISION
#define LIMBER_BULLET_PRECISION bullet_double
#else
#define LIMBER_BULLET_PRECISION bullet_float
#endif
