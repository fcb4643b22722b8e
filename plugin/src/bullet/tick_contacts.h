// SPDX-License-Identifier: Zlib

// This header declares the contacts of a tick in which more than one body moves, and the rigid bodies in
// them: how the step moves them, their own contacts and joints, and the links of multibodies. "Held" means
// static or kinematic.

#pragma once

#include "bullet/bullet_objects.h"
#include "solver/contacts.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct ContactSpeeds;
struct MovingObjects;
struct SoftBodyData;
struct StoredImpulse;

// --- rigid bodies that the step moves ----------------------------------------------------------------------

// Between read and write of a tick the step moves the rigid bodies that soft bodies touch or that are
// attached to them, not Bullet.

/// A rigid body of the user in a link or contact with soft bodies. It is stepped in the substeps. Like a
/// point mass, it then gets its mean velocity in the tick.
struct RigidPartner {
  btRigidBody* body = nullptr;
  bool held = false;     ///< static, kinematic or out of the simulation
  ObjectHandle handle;   ///< of the body
  bool isNew = true;     ///< not yet in a tick
  btTransform lastPose;  ///< at the end of the last tick
  RigidState start;      ///< at the start of the tick
  Eigen::Vector3d velocityOffset = Eigen::Vector3d::Zero(),
                  spinOffset = Eigen::Vector3d::Zero();  ///< m/s and rad/s, added to what Bullet gets: see
                                                         ///< offerToJoints()
  btVector3 expectedVelocity;                            ///< after the tick if nothing else acts
  btVector3 expectedAngularVelocity;
  Eigen::Vector3d turn;  ///< radians, of the tick if nothing else acts
};

/// The body must be in the world.
RigidPartner makePartner(btRigidBody& body);

/// Fills `state` from Bullet's body.
void gatherRigid(RigidPartner& partner, RigidState& state, btScalar tick);

/// Makes a held body, while kinematic ones are Rewound, start where it was placed instead of at its last
/// pose.
void startFromPlace(RigidPartner& partner, RigidState& state, btScalar tick);

/// Returns the mean velocities (m/s, rad/s) of a body in the tick, at its place at the start.
RigidState meanMotion(const RigidState& start, const RigidState& end, double tick);

/// Like writeVelocitiesToBullet() and finishWorldPoints() for point masses. Bullet's damping acts on the
/// written velocity, where it is compensated, and on the velocity at the end.
void writeRigidToBullet(RigidPartner& partner, const RigidState& end, btScalar tick);
void readRigidFromBullet(RigidPartner& partner, const RigidState& end, btScalar tick);

// --- the contacts of a tick --------------------------------------------------------------------------------

/// The origin of a contact.
struct ContactSource {
  btManifoldPoint* point = nullptr;  ///< Bullet's, between rigid bodies
  SoftBodyData* body = nullptr;      ///< the soft body on side a, of all other contacts
  SoftBodyData* other = nullptr;     ///< the soft body on side b, if it is one
  ObjectHandle partner;              ///< on side b
  std::uint64_t key = 0;             ///< of the features in contact, the same in every tick
};

struct TickContact : Contact {
  ContactSource source;
};

/// The origin of a constraint row of a joint.
struct JointSource {
  btTypedConstraint* constraint = nullptr;  ///< nullptr: rolling friction of a contact
  double kinematic = 0.0;                   ///< m/s or rad/s, the speed of a kinematic side
  bool drives = false;                      ///< a motor or a spring: its impulse has both limits
};

struct RigidPart;

/// Two surfaces that touch, or may touch, in the tick.
struct SurfaceCandidate {
  SoftBodyData* body = nullptr;             ///< on side a
  SoftBodyData* other = nullptr;            ///< on side b, if it is soft
  btRigidBody* partner = nullptr;           ///< on side b, if it is rigid and dynamic
  const btCollisionObject* held = nullptr;  ///< on side b, if it is static or kinematic
  RigidPart* part = nullptr;                ///< of `partner` or `held`
  std::uint32_t first = 0, end = 0;         ///< range of its contacts
  double displacement = 0.0;                ///< m, largest relative one in the tick by the predicted motion
  double stopped = 0.0;  ///< m in the tick, common motion that hits of other bodies may stop
};

/// The contacts of one tick in which more than a single soft body moves, the rigid bodies in them and the
/// joints of these. Contact points and constraint rows refer to soft bodies by SoftBodyData::index and to
/// rigid bodies by their index in `rigids`.
struct TickContacts {
  std::vector<RigidPartner> rigids;
  std::vector<TickContact> contacts;
  std::vector<TickContact> sensed;  ///< those that are only reported
  std::vector<SurfaceCandidate> candidates;
  std::vector<SurfaceCandidate> waiting;  ///< those that touch only if another body stops one of the two
  std::vector<btCollisionObject*> near;   ///< this and the next: scratch of addComingContacts()
  btManifoldArray manifolds;
  std::vector<JointConstraint> joints;
  std::vector<JointSource> jointSources;  ///< #joints
  double tick = 0.0;                      ///< s

  static constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);

  std::uint32_t find(const btRigidBody& body) const;  ///< index of a body in the world, or kNone
  std::uint32_t add(btRigidBody& body);               ///< index of a body, which is added on first use
  /// Removes all contents but keeps the memory. `comingTick`: length of the next tick, s.
  void clear(double comingTick = 0.0);

 private:
  std::vector<std::uint32_t> numbers_;  ///< in `rigids`, by index in the world's list of objects
};

/// Returns the velocity (m/s) of a position on an object: the present one of a dynamic body, the mean one in
/// the tick (s) of a kinematic object, 0 of one that is static or asleep.
Eigen::Vector3d velocityOf(const btCollisionObject& object, const btVector3& position, double tick);

/// Returns the displacement (m) that gravity and forces add to the motion of a free body in a tick.
inline Eigen::Vector3d fallOf(const btRigidBody& body, double tick) {
  return tick * tick * double(body.getInvMass()) * toEigen(body.getTotalForce());
}

/// Returns a contact point on a rigid body: of kind Rigid if the body is free, which adds it to `rigids`,
/// else of kind World.
ContactPoint rigidContactPoint(TickContacts& contacts, const btCollisionObject& object,
                               const btVector3& position);

/// Returns the contact point at a point mass. `body`: see TickContacts.
inline ContactPoint softPoint(std::uint32_t body, std::uint32_t point) {
  ContactPoint p;
  p.kind = ContactPoint::Kind::Soft;
  p.body = body;
  p.point[0] = point;
  return p;
}

/// Returns the position (m) of a contact point on a soft body whose points are at `positions`.
Eigen::Vector3d positionOf(const ContactPoint& point, const Points& positions);

/// Sets the friction and restitution of two objects, by Bullet's callbacks, and the speeds of a contact.
void setMaterial(ContactBase& contact, const btCollisionObject& a, const btCollisionObject& b,
                 const ContactSpeeds& speeds);

/// Starts the contacts of soft bodies from the impulses of the same features in the last tick.
void warmStart(TickContacts& contacts);

/// The same for a contact with a static or kinematic object: row `index` of the body's contacts.
void warmStart(const SoftBodyData& body, std::size_t index, Contact& contact);

/// Stores the impulses of these contacts, and those of coupled points, after the step. `bodies`: all bodies
/// of the world's systems.
void storeImpulses(const std::vector<SoftBodyData*>& bodies, const TickContacts& contacts);

/// Brings impulses into the order in which warmStart() searches them.
void sortImpulses(std::vector<StoredImpulse>& impulses);

// --- contacts of rigid bodies ------------------------------------------------------------------------------

/// A copy of a manifold's contact point.
struct StoredManifoldPoint {
  const btPersistentManifold* manifold;
  const btCollisionObject *a, *b;
  std::uint32_t order;  ///< index in order of storing
  btManifoldPoint point;
};

/// Bullet's contact manifolds by object, those of one object in the order of the dispatcher.
///
/// Stacked boxes may have eight contact points, but a manifold holds at most four of them, which change from
/// tick to tick. Sometimes all four are on one side, and the upper box tips over for a tick. Earlier points
/// that are still valid prevent this.
struct RigidManifolds {
  std::vector<int> begin;                        ///< #objects + 2, into `manifolds`
  std::vector<btPersistentManifold*> manifolds;  ///< each twice
  std::vector<StoredManifoldPoint> last, now;  ///< points of the two last ticks; `last` is sorted by manifold
};

/// Adds the contacts and joints of the rigid bodies that a soft body pushes: those of found.rigids with held
/// objects and with further rigid bodies. These are added to found.rigids and handled in the same way, until
/// no more bodies are found (a limit would make piles collapse). Contacts come from Bullet's manifolds, which
/// Bullet's narrowphase updates for the present poses. Point masses and surface objects are skipped.
///
/// Bullet's solver then ignores the manifolds whose points it already has (btPersistentManifold::
/// setContactProcessingThreshold). It still solves a manifold that may get new points in this tick because of
/// fast motion. restoreBreakingThresholds() undoes this after the tick.
void gatherRigidContacts(btDiscreteDynamicsWorld& world, const MovingObjects& objects, btScalar tick,
                         RigidManifolds& index, TickContacts& found);

/// Adds a contact of two rigid bodies at a point of Bullet's. Its impulse is added to `reported`, which may
/// be null.
void addRigidContact(TickContacts& found, const btCollisionObject& a, const btCollisionObject& b,
                     const btManifoldPoint& point, const ContactSpeeds& speeds,
                     const ContactImpulse& guess = ContactImpulse(), btManifoldPoint* reported = nullptr);

/// Returns the largest displacement (m) of a rigid body in the tick, while kinematic ones are Rewound.
double longestWay(const MovingObjects& objects, double tick);

/// Adds the contacts that rigid body `number` of found.rigids gets in the tick with bodies that it does not
/// touch yet, except those that earlier bodies have added. `reach` (m): longestWay().
void addComingContacts(btDiscreteDynamicsWorld& world, std::uint32_t number, double reach,
                       const ContactSpeeds& speeds, const RigidManifolds& index, TickContacts& found);

/// Makes Bullet's solver handle all manifolds again that gatherRigidContacts() and disableBulletResponse()
/// excluded, also for other systems in the world.
void restoreBreakingThresholds(btDispatcher& dispatcher);

/// Writes the impulses of the contacts to Bullet's manifolds, after the step, where users read them
/// (btManifoldPoint::m_appliedImpulse).
void reportRigidContacts(TickContacts& contacts);

// --- their joints ------------------------------------------------------------------------------------------

/// Adds the surface objects of awake soft bodies that joints (Bullet's enabled constraints) hold. In the step
/// each is a rigid body that stands for all points: see BodyFrame.
void addJointedSurfaces(btDiscreteDynamicsWorld& world, TickContacts& found);

/// Adds the free bodies that joints join to bodies in found.rigids. Returns whether any body was added.
bool addJoinedBodies(btDiscreteDynamicsWorld& world, TickContacts& found);

/// Adds the constraint rows of all joints of found.rigids, as Bullet's solver would make them for a tick. The
/// impulse limits are those of the whole tick.
void addJointRows(btDiscreteDynamicsWorld& world, btScalar tick, TickContacts& found);

/// Adds rolling and spinning friction to the last added contact, which is between rigid bodies.
void addRollingRows(const btCollisionObject& a, const btCollisionObject& b, const btManifoldPoint& point,
                    TickContacts& found);

/// A joint whose motors and springs are disabled.
struct DisabledDrives {
  btTypedConstraint* joint;
  std::uint32_t drives;  ///< one bit for each motor or spring that was enabled
  btScalar clamp;        ///< of a btPoint2PointConstraint: its impulse clamp
};

/// Disables the motors and springs whose rows are in `found` until Bullet's solver has run. Otherwise the
/// solver would apply them a second time.
void disableDrives(const TickContacts& found, std::vector<DisabledDrives>& off);
void enableDrives(btDynamicsWorld& world, std::vector<DisabledDrives>& off);

/// Writes the impulses of the joints to Bullet, after the tick, and disables joints that exceed their
/// breaking threshold. As in Bullet, the applied impulse is that of the last row, and feedback is the sum of
/// all rows. Joints that are no longer in the world are skipped.
void reportJoints(btDynamicsWorld& world, const TickContacts& contacts, btScalar tick);

// --- multibodies -------------------------------------------------------------------------------------------

/// A rigid body that represents a link (or the base) of a btMultiBody in the present tick. It is in no world.
class LinkBody final : public OwnBody<LinkBody> {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  LinkBody(btMultiBody& m, int l)
      : OwnBody(btRigidBodyConstructionInfo(1, nullptr, nullptr)), multiBody(&m), link(l) {}

  btMultiBody* multiBody;
  int link;  ///< -1: the base
  const btMultiBodyLinkCollider* collider = nullptr;
  int unused = 1;                                                               ///< ticks since its last use
  btVector3 impulse = btVector3(0, 0, 0), angularImpulse = btVector3(0, 0, 0);  ///< N s, N m s
};

/// Returns the object in the world that represents a contact's partner: of a link, its collider.
inline const btCollisionObject& objectInWorld(const btCollisionObject& object) {
  const LinkBody* link = LinkBody::from(&object);
  return link && link->collider ? *link->collider : object;
}

/// Returns whether a link cannot move: neither its joint nor those between it and a fixed base have a degree
/// of freedom.
bool isHeldLink(const btMultiBodyLinkCollider& collider);

/// The links of multibodies that soft bodies touch. During the step each is a rigid body, joined to the other
/// links by joint constraints. Its contact impulses are then applied exactly to the multibody's joints.
class MultiBodyLinks {
 public:
  /// Starts a tick.
  void begin(btDiscreteDynamicsWorld& world);

  /// Returns the rigid body of a link in its present state.
  LinkBody& bodyOf(const btMultiBodyLinkCollider& collider);

  /// Adds all links of the multibodies that are in `found`, and their joints.
  void addJoints(TickContacts& found);

  /// Applies the impulses of the links to their multibodies, after the step.
  void applyImpulses(const TickContacts& found);

  /// Completes them after Bullet's part of the tick.
  void finishMotions();

 private:
  using Numbers = std::vector<btScalar>;  ///< one per velocity of a multibody

  /// A row of a motor or limit.
  struct Drive {
    btMultiBodyConstraint* constraint;
    int column;       ///< the velocity on which it acts
    double share;     ///< its factor
    std::size_t row;  ///< index in TickContacts::joints
  };

  /// A motor that Bullet's solver must not see.
  struct Motor {
    btMultiBodyConstraint* constraint;
    btScalar maxImpulse, impulse;  ///< N s or N m s: its own limit; what it gave in the step
  };

  struct Motion {
    btMultiBody* multiBody;
    btScalar tick;     ///< s
    Numbers rest;      ///< added to its velocities after the tick
    Numbers byForces;  ///< in `rest`: what the forces at its start have added in the tick
  };

  /// A multibody on which Bullet's solver acts, too.
  struct Supported {
    btMultiBody* multiBody;
    std::vector<btVector3> forces;  ///< N, N m: on each link, before Bullet's solver
    Numbers start, change;  ///< its velocities before Bullet's part of the tick, and what that has added
  };

  struct Joint;

  LinkBody& bodyOf(btMultiBody& multiBody, int link);
  void addJoints(btMultiBody& multiBody, btCollisionObject& touched, TickContacts& found);
  Joint jointOf(btMultiBody& multiBody, int link);
  bool findSides(const Joint& joint, TickContacts& found, JointConstraint& row);
  void addJoint(const Joint& joint, TickContacts& found);
  void addTorques(const Joint& joint);
  void addDrives(btMultiBody& multiBody, TickContacts& found);
  void addDrive(btMultiBody& multiBody, btMultiBodyConstraint& drive, TickContacts& found);
  void addDriveRows(btMultiBody& multiBody, const btMultiBodySolverConstraint& source,
                    const btScalar* jacobian, TickContacts& found);
  void addComingLimits(btMultiBody& multiBody, btMultiBodyConstraint& limit, TickContacts& found);
  void addDriveRow(btMultiBody& multiBody, Drive drive, int link, int degree, const JointConstraint& limits,
                   TickContacts& found);
  void accelerate(btMultiBody& multiBody, btScalar time);
  void findLinkVelocities(btMultiBody& multiBody);
  bool collectImpulses(btMultiBody& multiBody);
  Numbers changeByImpulses(btMultiBody& multiBody);
  Numbers meanVelocities(btMultiBody& multiBody, const TickContacts& found);
  bool isAlone(const btMultiBody& multiBody) const;
  std::vector<btVector3> forcesOn(btMultiBody& multiBody);
  void repeatForces(const Supported& last, double tick);
  void finish(const Motion& motion);
  void apply(btMultiBody& multiBody, const TickContacts& found);
  void applyMotion(btMultiBody& multiBody, const TickContacts& found);
  void disableMotors(const btMultiBody& multiBody, const TickContacts& found);

  std::vector<std::unique_ptr<LinkBody>> bodies_;
  std::vector<btMultiBody*> touched_;  // in this tick
  std::vector<Drive> drives_;          // of these
  std::vector<Motor> motors_;
  std::vector<Motion> motions_;
  std::vector<Supported> supported_, lastSupported_;  // in this tick and in the one before
  btMultiBodyDynamicsWorld* world_ = nullptr;         // if it is one
  int objects_ = 0;                                   // in the world
  btSphereShape none_{btScalar(0)};                   // of links that have no shape
  // scratch of btMultiBody
  btAlignedObjectArray<btVector3> spins_, velocities_, vectors_;
  btAlignedObjectArray<btScalar> numbers_;
  Numbers force_;  // N s or N m s
  btAlignedObjectArray<btMatrix3x3> matrices_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
