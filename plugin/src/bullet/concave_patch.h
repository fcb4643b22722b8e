// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The triangles of a static object with a concave shape that are around the body in this tick, or nullptr if
/// there are none. Made anew when the body or the object has moved away.
RigidPart* patchAround(SoftBodyData& body, const btCollisionObject& partner, const MovingSurface& soft);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
