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

/// A joint whose motors and springs are switched off.
struct SwitchedOff {
  btTypedConstraint* joint;
  std::uint32_t drives;  ///< a bit for each that was on
};

/// Bullet's solver would let motors and springs push a second time, whatever velocities it is given: those whose rows
/// are in `found` are off until it has run.
void switchOffDrives(const TickContacts& found, std::vector<SwitchedOff>& off);
void switchOnDrives(btDynamicsWorld& world, std::vector<SwitchedOff>& off);

/// After the tick: Bullet says of the joints what they have borne (as it does, the applied impulse is that of
/// the last row; feedback is the sum of all), and those that bore as much as they may break. Joints that are
/// no longer in the world are left out.
void reportJoints(btDynamicsWorld& world, const TickContacts& contacts, btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
