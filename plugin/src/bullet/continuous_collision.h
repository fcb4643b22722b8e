// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Lets Bullet sweep the points of a body in the coming tick if, and only if, one of them moves far enough to
/// miss a contact and there is something in the box the body sweeps. A sweep costs about as much as all the
/// rest of a point mass; one query of the broadphase for the whole body spares it to bodies in the air.
/// Call after the step, when start and end positions are known.
void chooseContinuousCollision(SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
