// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/soft_contact.h>

#include <btBulletDynamicsCommon.h>

#include <cstddef>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A soft body and something else that touch. Two soft bodies are two pairs, one from the view of each.
struct ContactPair {
  SoftBody* body = nullptr;
  const btCollisionObject* other = nullptr;  ///< of a soft one its surface object; with Collision::Points the
                                             ///< body of its first point, whichever point it is that touches
  SoftBody* otherBody = nullptr;             ///< nullptr: the other is not soft
  bool otherGone = false;  ///< at the end of a pair: other and otherBody may have been deleted and tell who
                           ///< it was, but must not be followed

  // 0 at the end of a pair.
  std::size_t contacts = 0;                ///< of body->contacts(), how many are of the pair
  double normalImpulse = 0.0;              ///< N s, sum over them, in the last tick
  btVector3 impulse = btVector3(0, 0, 0);  ///< N s on body, sum over them
  SoftContact strongest;                   ///< the one of them that bore most
};

/// Learns of contacts after each tick, on the thread that steps the world, soft bodies in order of creation,
/// partners in the order in which they came into the world.
///
/// A pair begins in the tick at whose end something is in body->contacts() and ends in the first at whose end
/// nothing is. While the soft body sleeps its pairs go on without a call. A pair ends, too, when either of
/// the two leaves the world (after the next tick; destroyBody() and removeAll() call at once); not when the
/// system or the world is destroyed, nor when the listener is replaced.
///
/// A listener may read everything, apply forces and impulses, and remove rigid bodies from the world. Soft
/// bodies that it destroys go when all calls of the tick are over. It must not destroy the system.
class ContactListener {
 public:
  virtual ~ContactListener() = default;
  virtual void contactBegins(const ContactPair&) {}
  virtual void contactPersists(const ContactPair&) {}
  virtual void contactEnds(const ContactPair&) {}
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
