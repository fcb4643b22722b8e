// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Fills body.contacts with a row for every static or kinematic surface that a point may reach in the coming
/// tick, before it touches. Bullet's broadphase names the partners and Bullet's narrowphase the contacts; only
/// planes, which it would test at any distance, are first tested here. Dynamic partners are left to Bullet's
/// solver. Call after gatherPoints().
void gatherContacts(SoftBodyData& body, btScalar tick);

/// Takes what an earlier tick wrote (below) out of Bullet's manifolds again, before Bullet starts from it.
void clearContactImpulses(btDispatcher& dispatcher);

/// After the tick: what the rows have borne is written to Bullet's manifolds, where users read contact forces
/// (btManifoldPoint::m_appliedImpulse).
void reportContactImpulses(btDispatcher& dispatcher);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
