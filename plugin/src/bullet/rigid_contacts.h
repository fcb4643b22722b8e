// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/kept_points.h"
#include "bullet/tick_contacts.h"

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Bullet's contact manifolds by the objects they are of, those of one object in the order of the dispatcher.
struct RigidManifolds {
  std::vector<int> begin;                        ///< #objects + 1, into `manifolds`
  std::vector<btPersistentManifold*> manifolds;  ///< each twice
  KeptPoints kept;
};

/// What rigid bodies that soft ones push have in their turn to push against: all contacts and joints of
/// found.rigids with what is held, and with further rigid bodies, which join them, until none is left out
/// (a limit to this would make piles collapse). Contacts are those of Bullet's manifolds, which its
/// narrowphase is asked to find anew where the bodies are now, with the impulses of the last tick as a guess.
/// Point masses and surface objects are not looked at.
///
/// Bullet's solver is told to leave those alone whose points it knows already (btPersistentManifold::
/// setContactProcessingThreshold); where faster motion may bring new points into a manifold in this tick, it
/// keeps its say. freeManifolds() takes that back once the tick is over.
void gatherRigidContacts(btDiscreteDynamicsWorld& world, btScalar tick, RigidManifolds& index,
                         TickContacts& found);

/// Lets Bullet's solver treat all manifolds again that gatherRigidContacts() told it to leave alone, those of
/// other systems in the world too.
void freeManifolds(btDispatcher& dispatcher);

/// After the step: what the contacts and joints have borne, for users who read it from Bullet
/// (btManifoldPoint::m_appliedImpulse, btTypedConstraint::getAppliedImpulse).
void reportRigidContacts(TickContacts& contacts);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
