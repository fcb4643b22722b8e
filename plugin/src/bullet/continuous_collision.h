// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Stops points that have passed through something in this tick where they first touched it. Their velocity
/// stays: in the next tick Bullet sees the contact and answers it. Call after contacts were taken back, when
/// start and end positions are known, and before the bodies are written.
///
/// Only points that move far enough to miss a contact are swept, and only if there is anything dynamic in the
/// box the body sweeps (one query of the broadphase for a whole body), or anything static and a point got
/// farther than contacts were looked for before the step. Bullet's own continuous collision is not used,
/// because it sweeps twice, without such a query, and on triangle meshes ignores all motions into the surface
/// that are shorter than the world's m_allowedCcdPenetration (4 cm), twice a point mass.
void stopAtFirstContact(SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
