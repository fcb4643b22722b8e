// SPDX-License-Identifier: Zlib

// This header declares the contacts of a tick in which more than one body moves, and the rigid bodies in
// them: what these touch in their turn, their joints, and the links of multibodies.

#pragma once

#include "bullet/bullet_objects.h"
#include "solver/contacts.h"
#include "solver/links.h"

#include <limber/bullet_precision.h>

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;

// --- rigid bodies that take part ---------------------------------------------------------------------------

/// A rigid body of the user's that springs or anchors hold on to: it takes part in the substeps and, like a
/// point mass, is handed its mean velocity of the tick.
struct RigidPartner {
  btRigidBody* body = nullptr;
  bool held = false;           ///< static, kinematic or out of the simulation: it moves as told
  ObjectHandle mark;           ///< of the body
  btTransform lastPose;        ///< of a held body at the end of the last tick
  RigidState start;            ///< at the start of the tick
  btVector3 expectedVelocity;  ///< after the tick if nothing else acts
  btVector3 expectedAngularVelocity;
};

/// The body must be in the world.
RigidPartner makePartner(btRigidBody& body);

/// Fills `state` from Bullet's body. A held body moves evenly from its last pose to its present one.
void gatherRigid(RigidPartner& partner, RigidState& state, btScalar tick);

/// As writeVelocitiesToBullet() and finishWorldPoints() for point masses. Bullet's damping acts on both the
/// velocity handed over, where it is made up for, and the one at the end.
void writeRigidToBullet(RigidPartner& partner, const RigidState& end, btScalar tick);
void readRigidFromBullet(RigidPartner& partner, const RigidState& end, btScalar tick);

// --- the contacts of a tick --------------------------------------------------------------------------------

/// Where a contact was found.
struct ContactSource {
  btManifoldPoint* point = nullptr;  ///< Bullet's, between rigid bodies
  SoftBodyData* body = nullptr;      ///< the soft body on side a, of all others
  SoftBodyData* other = nullptr;     ///< the soft body on side b, if it is one
  ObjectHandle partner;              ///< on side b
  std::uint64_t key = 0;             ///< of the features that touch, the same from tick to tick
};

/// Where a row of a joint comes from.
struct JointSource {
  btTypedConstraint* constraint = nullptr;  ///< nullptr: rolling friction of a contact
  double recovery = 0.0;                    ///< m/s or rad/s, the speed that corrects errors
  bool drives = false;                      ///< a motor or a spring: its impulse has limits on both sides
};

struct RigidPart;

/// Two surfaces that touch, or may touch, in the tick.
struct SurfaceCandidate {
  SoftBodyData* body = nullptr;             ///< on side a
  SoftBodyData* other = nullptr;            ///< on side b, if it is soft
  btRigidBody* partner = nullptr;           ///< on side b, if it is rigid and moves by itself
  const btCollisionObject* held = nullptr;  ///< on side b, if it is at rest or moves as told
  RigidPart* part = nullptr;                ///< of one of these
  std::uint32_t first = 0, end = 0;         ///< of its contacts
};

/// The contacts of one tick in which something other than a single soft body moves, the joints of the rigid
/// bodies in them, and these rigid bodies. Places and rows name soft bodies by SoftBodyData::index and rigid
/// bodies by their number here.
struct TickContacts {
  std::vector<RigidPartner> rigids;
  std::vector<Contact> contacts;
  std::vector<ContactSource> sources;  ///< #contacts
  std::vector<SurfaceCandidate> candidates;
  std::vector<JointConstraint> joints;
  std::vector<JointSource> jointSources;  ///< #joints
  double tick = 0.0;                      ///< s

  static constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);

  /// The number of a rigid body in the world, or kNone.
  std::uint32_t find(const btRigidBody& body) const;
  /// The number it has or now gets.
  std::uint32_t add(btRigidBody& body);
  void add(const Contact& contact, const ContactSource& source);
  /// Forgets everything but the memory it takes. The coming tick takes so many seconds.
  void clear(double comingTick = 0.0);

 private:
  std::vector<std::uint32_t> numbers_;  ///< by place in the world's list of objects
};

/// m/s, of a place on a body that moves by itself, at present, or as told, over the tick (s); 0 for one that
/// is static or asleep.
Eigen::Vector3d velocityOf(const btCollisionObject& object, const btVector3& place, double tick);

/// The place on a rigid body: of kind Rigid if it is free, which gives it a number, else of kind World.
ContactPoint placeOn(TickContacts& contacts, const btCollisionObject& object, const btVector3& place);

/// Starts the contacts of soft bodies from what those of the same features bore in the last tick.
void warmStart(TickContacts& contacts);

/// After the step: remembers what they bore. `bodies`: all of the system.
void storeImpulses(const std::vector<SoftBodyData*>& bodies, const TickContacts& contacts);

// --- contacts of rigid bodies ------------------------------------------------------------------------------

/// A point of a manifold as it was found.
struct KeptPoint {
  const btPersistentManifold* manifold;
  const btCollisionObject *a, *b;
  std::uint32_t order;  ///< in which it was kept
  btManifoldPoint point;
};

/// The contact points of the last tick. Bullet has four points at most in a manifold, of eight that boxes
/// upon each other may have, and from tick to tick others: now and then four on one side, from which the
/// upper box falls for a tick. With those of the ticks before that are still near, it does not.
struct KeptPoints {
  std::vector<KeptPoint> last;  ///< by manifold
  std::vector<KeptPoint> now;
};

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
/// keeps its say. restoreBreakingThresholds() takes that back once the tick is over.
void gatherRigidContacts(btDiscreteDynamicsWorld& world, btScalar tick, RigidManifolds& index,
                         TickContacts& found);

/// Lets Bullet's solver treat all manifolds again that gatherRigidContacts() told it to leave alone, those of
/// other systems in the world too.
void restoreBreakingThresholds(btDispatcher& dispatcher);

/// After the step: what the contacts and joints have borne, for users who read it from Bullet
/// (btManifoldPoint::m_appliedImpulse, btTypedConstraint::getAppliedImpulse).
void reportRigidContacts(TickContacts& contacts);

// --- their joints ------------------------------------------------------------------------------------------

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

/// Bullet's solver would let motors and springs push a second time, whatever velocities it is given: those
/// whose rows are in `found` are off until it has run.
void switchOffDrives(const TickContacts& found, std::vector<SwitchedOff>& off);
void switchOnDrives(btDynamicsWorld& world, std::vector<SwitchedOff>& off);

/// After the tick: Bullet says of the joints what they have borne (as it does, the applied impulse is that of
/// the last row; feedback is the sum of all), and those that bore as much as they may break. Joints that are
/// no longer in the world are left out.
void reportJoints(btDynamicsWorld& world, const TickContacts& contacts, btScalar tick);

// --- multibodies -------------------------------------------------------------------------------------------

/// A link (or the base) of a btMultiBody as a rigid body, for the present tick. It is in no world.
class LinkBody final : public btRigidBody {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  LinkBody(btMultiBody& m, int l);

  /// The link an object is, or nullptr.
  static LinkBody* from(btCollisionObject* object);
  static const LinkBody* from(const btCollisionObject* object);

  btMultiBody* multiBody;
  int link;  ///< -1: the base
  const btMultiBodyLinkCollider* collider = nullptr;
  int unused = 0;  ///< ticks since it was last asked for
  bool present = false;
  btVector3 impulse = btVector3(0, 0, 0), angularImpulse = btVector3(0, 0, 0);  ///< N s, N m s
};

/// What stands in the world for an object that a contact is with.
inline const btCollisionObject& objectInWorld(const btCollisionObject& object) {
  const LinkBody* link = LinkBody::from(&object);
  return link && link->collider ? *link->collider : object;
}

/// Whether nothing moves a link: it and all joints down to a fixed base have no freedom.
bool isHeldLink(const btMultiBodyLinkCollider& collider);

/// The links of multibodies that soft bodies touch. While contacts are solved each is a rigid body that
/// joints hold to the others; what it has borne goes into the joints of the multibody, exactly.
class MultiBodyLinks {
 public:
  /// At the start of a tick.
  void begin(const btCollisionWorld& world);

  /// The body of a link as it is now.
  LinkBody& bodyOf(const btMultiBodyLinkCollider& collider);

  /// Adds all links of the multibodies that are in `found`, and their joints.
  void addJoints(TickContacts& found);

  /// After the step: gives the multibodies what their links have borne.
  void applyImpulses(const TickContacts& found);

 private:
  LinkBody& bodyOf(btMultiBody& multiBody, int link);
  void addJoints(btMultiBody& multiBody, const btCollisionObject& touched, TickContacts& found);
  void addJoint(btMultiBody& multiBody, int link, TickContacts& found);
  void apply(btMultiBody& multiBody);

  std::vector<std::unique_ptr<LinkBody>> bodies_;
  std::vector<btMultiBody*> touched_;  // in this tick
  int objects_ = 0;                    // in the world
  btSphereShape none_{btScalar(0)};    // of links that have no shape
  // scratch of btMultiBody
  btAlignedObjectArray<btVector3> spins_, velocities_, vectors_;
  btAlignedObjectArray<btScalar> numbers_, jacobian_, force_, change_;
  btAlignedObjectArray<btMatrix3x3> matrices_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
