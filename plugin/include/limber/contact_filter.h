// SPDX-License-Identifier: Zlib
#pragma once

// Contacts that are checked or changed before they act.

#include <limber/bullet_precision.h>
#include <limber/contacts.h>

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <functional>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// What a contact does.
enum class ContactResponse : std::uint8_t {
  Act,     ///< pushes and is reported
  Report,  ///< is reported as if it pushed, but without an impulse: a sensor
  Ignore   ///< neither pushes nor is reported
};

/// A contact that may act in the coming tick, seen from `body`. A ContactFilter changes the answer.
struct ContactCandidate {
  SoftBody* body = nullptr;
  const btCollisionObject* other = nullptr;  ///< for a soft body its surface object, or its point mass
  SoftBody* otherBody = nullptr;             ///< nullptr: `other` is not soft; `body`: it touches itself
  ContactSide side, otherSide;               ///< ContactSide::triangle is kNone; otherSide only if soft
  int otherPart = -1, otherTriangle = -1;   ///< of the concave shape (mesh, height field) that is touched, as
                                            ///< Bullet's triangle callbacks number them; -1: not concave
  btVector3 position = btVector3(0, 0, 0);  ///< m, on the surface of `body`, its radius included
  btVector3 normal = btVector3(0, 0, 0);    ///< unit, from other to body
  double distance = 0.0;                    ///< m between the surfaces, below 0 where they overlap

  // --- the answer. Numbers that are not valid are replaced: velocities and directions by 0

  ContactResponse response = ContactResponse::Act;
  double friction = 0.0;     ///< 0 or more; at first by Bullet's gCalculateCombinedFrictionCallback
  double restitution = 0.0;  ///< 0 to 1; at first by gCalculateCombinedRestitutionCallback
  /// m/s, velocity of the other's surface in addition to its motion: conveyor belts. Only the part across the
  /// normal acts. Default 0.
  btVector3 surfaceVelocity = btVector3(0, 0, 0);
  /// Factors of the masses of `body` and `other` in this contact, 1e-6 to 1e6: a side with a larger factor is
  /// pushed less. They do not matter on static and kinematic objects, nor between parts of one body. Momentum
  /// is conserved only if they are equal. Default 1.
  double massFactor = 1.0, otherMassFactor = 1.0;
  /// One-sided contacts: the contact acts only while its normal has a component of 0 or more along this
  /// direction. On curved surfaces at rest the normal turns within the tick, and this follows it. Default 0:
  /// all normals.
  btVector3 facing = btVector3(0, 0, 0);
};

/// Called for each new contact of a soft body before it acts: at the start of each tick for those that the
/// tick may bring, also at a distance, and within the tick for those that are found later. The same pair of
/// features is asked for again in every tick. A contact between soft bodies is asked for once, a plane
/// contact of each point once per surface nearby.
/// It is not asked for objects without contact response, which are only reported anyway. Contacts that it
/// reports and does not let act are those at the start of a tick.
///
///     soft.setContactFilter([](limber::ContactCandidate& c) {
///       if (c.other == belt) c.surfaceVelocity = btVector3(1, 0, 0);
///     });
///
/// Thread rule: at the start of a tick, the thread that steps the world. Within a tick with setParallelFor(),
/// any thread, several at a time. It must not throw, change the world or its bodies, or depend on anything
/// but the candidate and data that stays the same during the tick. It may read settings(), userPointer(),
/// userIndex() and name() of soft bodies, and everything that Bullet's objects have; kinematic objects are at
/// their poses at the start of the tick.
using ContactFilter = std::function<void(ContactCandidate&)>;

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
