// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Stops point masses in the world that have got farther in this tick than contacts were looked for where they
/// first touched something. Their velocity stays: the next tick finds the contact. Call after Bullet's contacts
/// have been read, when start and end positions are known, and before the bodies are written.
///
/// Only points that move far enough to miss a contact are swept, and only if anything is in the box the body
/// sweeps (one query of the broadphase for a whole body). Bullet's own
/// continuous collision is not used, because it sweeps twice, without such a query, and on triangle meshes
/// ignores all motions into the surface that are shorter than the world's m_allowedCcdPenetration (4 cm),
/// twice a point mass.
void stopAtFirstContact(SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
