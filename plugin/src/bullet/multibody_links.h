// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct TickContacts;

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

/// The links of multibodies that soft bodies touch. While contacts are solved each is a rigid body that joints
/// hold to the others; what it has borne goes into the joints of the multibody, exactly.
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
