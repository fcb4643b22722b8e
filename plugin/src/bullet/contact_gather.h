// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Fills body.contacts with a row for every static or kinematic surface that a point may reach in the coming
/// tick, before it touches. Bullet's broadphase names the partners and Bullet's narrowphase the contacts;
/// only planes, which it would test at any distance, are first tested here, and slow points keep the contact
/// of the last tick (PointMass::cachedContact). Dynamic partners are left to Bullet's solver. Call after
/// gatherPoints().
void gatherContacts(SoftBodyData& body, btScalar tick);

/// Before a tick: gives every point mass its contact in Bullet's manifolds, and takes out of these what an
/// earlier tick reported (below), before Bullet starts from it.
void readManifolds(btDispatcher& dispatcher);

/// After the tick: what the rows have borne is written to Bullet's manifolds, where users read contact forces
/// (btManifoldPoint::m_appliedImpulse).
void reportContactImpulses(btDispatcher& dispatcher);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
