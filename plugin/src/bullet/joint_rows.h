// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/tick_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Numbers the free bodies that joints (Bullet's enabled constraints) join to numbered ones. False if there
/// are no more.
bool addJoinedBodies(btDiscreteDynamicsWorld& world, TickContacts& found);

/// The rows of all joints of numbered bodies, as Bullet's solver would make them for a tick; limits of
/// impulses are those of the whole tick.
void addJointRows(btDiscreteDynamicsWorld& world, btScalar tick, TickContacts& found);

/// Rolling and spinning friction of the contact between rigid bodies that was added last.
void addRollingRows(const btPersistentManifold& manifold, const btManifoldPoint& point, TickContacts& found);

/// Bullet's solver lets motors and springs push whatever velocities it is given. What they will push there is taken
/// off these, so that it acts once.
void leaveToSolver(TickContacts& found, btScalar tick);

/// After the tick: Bullet says of the joints what they have borne (as it does, the applied impulse is that of
/// the last row; feedback is the sum of all), and those that bore as much as they may break. Joints that are
/// no longer in the world are left out.
void reportJoints(btDynamicsWorld& world, const TickContacts& contacts, btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
