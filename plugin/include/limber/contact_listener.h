// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/soft_contact.h>

#include <btBulletDynamicsCommon.h>

#include <cstddef>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A soft body and an object that it touches. Two soft bodies in contact give two pairs, one for each body.
struct ContactPair {
  SoftBody* body = nullptr;
  const btCollisionObject* other = nullptr;  ///< for a soft body its surface object; with Collision::Points
                                             ///< the sphere of its first point, whichever point touches
  SoftBody* otherBody = nullptr;             ///< nullptr: the other is not soft
  bool otherGone = false;  ///< at the end of a pair: other and otherBody may have been deleted; use the
                           ///< pointers for identification only, do not dereference them

  // These are 0 at the end of a pair.
  std::size_t contacts = 0;                ///< number of entries of body->contacts() that belong to the pair
  double normalImpulse = 0.0;              ///< N s, sum over these contacts in the last tick
  btVector3 impulse = btVector3(0, 0, 0);  ///< N s on body, sum over these contacts
  SoftContact strongest;                   ///< the contact with the largest impulse
};

/// Receives the contacts after each tick, on the thread that steps the world. Soft bodies are reported in
/// order of creation, the objects that they touch in the order in which they were added to the world.
///
/// A pair begins in the first tick after which body->contacts() has an entry for it. It ends in the first
/// tick after which there is none. While the soft body sleeps, its pairs continue without calls. A pair also
/// ends when one of the two objects leaves the world: the call then follows after the next tick, or at once
/// from destroyBody() and removeAll(). There is no such call when the system or the world is destroyed, or
/// when the listener is replaced.
///
/// A listener may read everything, apply forces and impulses, and remove rigid bodies from the world. Soft
/// bodies that it destroys are deleted after all calls of the tick. It must not destroy the system.
class ContactListener {
 public:
  virtual ~ContactListener() = default;
  virtual void contactBegins(const ContactPair&) {}
  virtual void contactPersists(const ContactPair&) {}
  virtual void contactEnds(const ContactPair&) {}
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
