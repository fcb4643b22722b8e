// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/partner_mark.h"
#include "bullet/rigid_partner.h"
#include "core/pair_contacts.h"

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;

/// Where a contact was found.
struct ContactSource {
  btManifoldPoint* point = nullptr;  ///< Bullet's, between rigid bodies
  SoftBodyData* body = nullptr;      ///< the soft body on side a, of all others
  SoftBodyData* other = nullptr;     ///< the soft body on side b, if it is one
  PartnerMark partner;               ///< on side b
  std::uint64_t key = 0;             ///< of the features that touch, the same from tick to tick
};

/// The contacts of one tick in which something other than a single soft body moves, the joints of the rigid
/// bodies in them, and these rigid bodies. Places and rows name soft bodies by SoftBodyData::index and rigid
/// bodies by their number here.
struct TickContacts {
  std::vector<RigidPartner> rigids;
  std::vector<PairContact> contacts;
  std::vector<ContactSource> sources;  ///< #contacts
  std::vector<JointRow> joints;
  std::vector<btTypedConstraint*> constraints;  ///< #joints; nullptr: rolling friction of a contact

  static constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);

  /// The number of a rigid body in the world, or kNone.
  std::uint32_t find(const btRigidBody& body) const;
  /// The number it has or now gets.
  std::uint32_t add(btRigidBody& body);
  void add(const PairContact& contact, const ContactSource& source);
  /// Forgets everything but the memory it takes.
  void clear();

 private:
  std::vector<std::uint32_t> numbers_;  ///< by place in the world's list of objects
};

/// Whether a rigid body moves by itself: neither held nor asleep.
inline bool isFree(const btRigidBody& body) {
  return !body.isStaticOrKinematicObject() && body.isActive() &&
         body.getActivationState() != DISABLE_SIMULATION && body.getWorldArrayIndex() >= 0;
}

/// m/s, of a place on a body that moves by itself or as told; 0 for one that is static or asleep.
Eigen::Vector3d velocityOf(const btCollisionObject& object, const btVector3& place);

/// The place on a rigid body: of kind Rigid if it is free, which gives it a number, else of kind World.
ContactPlace placeOn(TickContacts& contacts, const btCollisionObject& object, const btVector3& place);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
