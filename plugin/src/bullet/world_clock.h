// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// See SoftBodySystem::tickFraction().
double tickFraction(const btDiscreteDynamicsWorld& world);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
