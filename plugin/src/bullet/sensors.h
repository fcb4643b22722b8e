// SPDX-License-Identifier: Zlib

// This header declares the contacts of surfaces with objects that have no contact response: Bullet's sensors.

#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;

/// Adds an object near the body to SoftBodyData::sensors if either of the two has no contact response.
/// Returns whether it did.
bool addSensor(SoftBodyData& body, btCollisionObject& partner);

/// Adds the present contacts of the body with its sensors to its report, after a tick: of the points, or,
/// where no point touches, of the triangles or springs with convex objects. For one thread.
void reportSensors(SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
