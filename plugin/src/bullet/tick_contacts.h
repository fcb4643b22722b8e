// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/bullet_objects.h"
#include "bullet/kinematic_motion.h"
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

/// Where a row of a joint comes from.
struct JointSource {
  btTypedConstraint* constraint = nullptr;  ///< nullptr: rolling friction of a contact
  double recovery = 0.0;                    ///< m/s or rad/s, the speed that corrects errors
  bool drives = false;                      ///< a motor or a spring: its impulse has limits on both sides
  double lower = 0.0, upper = 0.0;          ///< of one that drives: its impulse's limits in Bullet's solver
};

struct RigidPart;

/// Two surfaces that touch, or may touch, in the tick.
struct SurfaceMeeting {
  SoftBodyData* body = nullptr;      ///< on side a
  SoftBodyData* other = nullptr;     ///< on side b, if it is soft
  btRigidBody* partner = nullptr;    ///< on side b, if it is rigid and moves by itself
  const btCollisionObject* held = nullptr;  ///< on side b, if it is at rest or moves as told
  RigidPart* part = nullptr;         ///< of one of these
  std::uint32_t first = 0, end = 0;  ///< of its contacts
};

/// The contacts of one tick in which something other than a single soft body moves, the joints of the rigid
/// bodies in them, and these rigid bodies. Places and rows name soft bodies by SoftBodyData::index and rigid
/// bodies by their number here.
struct TickContacts {
  std::vector<RigidPartner> rigids;
  std::vector<PairContact> contacts;
  std::vector<ContactSource> sources;  ///< #contacts
  std::vector<SurfaceMeeting> meetings;
  std::vector<JointRow> joints;
  std::vector<JointSource> jointSources;  ///< #joints
  double tick = 0.0;                      ///< s

  static constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);

  /// The number of a rigid body in the world, or kNone.
  std::uint32_t find(const btRigidBody& body) const;
  /// The number it has or now gets.
  std::uint32_t add(btRigidBody& body);
  void add(const PairContact& contact, const ContactSource& source);
  /// Forgets everything but the memory it takes. The coming tick takes so many seconds.
  void clear(double comingTick = 0.0);

 private:
  std::vector<std::uint32_t> numbers_;  ///< by place in the world's list of objects
};

/// m/s, of a place on a body that moves by itself, at present, or as told, over the tick (s); 0 for one that
/// is static or asleep.
Eigen::Vector3d velocityOf(const btCollisionObject& object, const btVector3& place, double tick);

/// The place on a rigid body: of kind Rigid if it is free, which gives it a number, else of kind World.
ContactPlace placeOn(TickContacts& contacts, const btCollisionObject& object, const btVector3& place);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
