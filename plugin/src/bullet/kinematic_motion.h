// SPDX-License-Identifier: Zlib

// This header declares how kinematic objects move in a tick, and which objects come near soft bodies.

#pragma once

#include "bullet/bullet_objects.h"

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;

/// The motion of a kinematic object in the present tick.
struct KinematicMotion {
  btCollisionObject* object = nullptr;
  int id = 0;                ///< unique in the broadphase
  btTransform start, end;    ///< its poses
  btTransform told;          ///< where the user has put it: the end of the last tick of a stepSimulation()
  btTransform interpolated;  ///< its interpolation transform outside Rewound
  int ticksLeft = 0;         ///< until it is there, this one included
  bool seenBetweenSteps = false;  ///< by start() alone
  btVector3 low, high;            ///< m, the box of its motion
  bool moves() const { return !(start == end); }
};

/// The kinematic objects of a world. A user puts one where it shall be at the end of a stepSimulation()
/// before the first of its ticks; here it moves there evenly. Bullet's velocity is not enough to know the
/// motion: it is not kept for bodies asleep, which massless ones are from addRigidBody() on, nor within the
/// pre-tick callback.
class KinematicMotions {
 public:
  /// After a time without follow(): from where its objects are now, between two stepSimulation().
  void start(const btCollisionWorld& world);

  /// At the start of a tick.
  void follow(const btCollisionWorld& world, btScalar tick);

  const std::vector<KinematicMotion>& all() const { return motions_; }

  /// While it lives every kinematic object's world transform is its pose at the start of the tick, when all
  /// else is where it is, and its interpolation transform that at the end.
  class Rewound {
   public:
    explicit Rewound(const KinematicMotions& motions);
    ~Rewound();
    Rewound(const Rewound&) = delete;
    Rewound& operator=(const Rewound&) = delete;

   private:
    const KinematicMotions* motions_;
  };

 private:
  const KinematicMotion* known(const btCollisionObject& object) const;

  std::vector<KinematicMotion> motions_, last_;  // in the order of the world's list
};

/// m, how far a place on an object gets in the tick while it is Rewound; 0 for one that is not kinematic.
inline Eigen::Vector3d kinematicDisplacement(const btCollisionObject& object, const Eigen::Vector3d& place) {
  if (!isKinematic(object) || object.getWorldTransform() == object.getInterpolationWorldTransform())
    return Eigen::Vector3d::Zero();
  const btTransform &start = object.getWorldTransform(), &end = object.getInterpolationWorldTransform();
  const btVector3 turned = (end.getBasis() - start.getBasis()) * start.invXform(toBullet(place));
  return toEigen(turned) + difference(end.getOrigin(), start.getOrigin());
}

// --- partners of the coming tick ---------------------------------------------------------------------------

/// Before a tick: gives every awake surface body of `system` the static and kinematic objects that Bullet's
/// broadphase found near it (surface.partners, in order of their unique ids), and wakes those that sleep
/// where a kinematic object is awake, as Bullet's islands do.
/// One pass over the pairs instead of one query per body.
void collectPartners(btDiscreteDynamicsWorld& world, const void* system);

/// Adds to them, and to those of bodies with Collision::Points, the objects of the user's that will get near
/// in the coming tick because of their own motion, of which the broadphase does not know yet, and wakes
/// bodies that sleep in their way. Dynamic bodies are looked for by surfaces only: points leave them to
/// Bullet.
void collectMovers(btDiscreteDynamicsWorld& world, const KinematicMotions& kinematic, const void* system,
                   btScalar tick);

/// Whether surface.partners holds everything that may touch something in this box (m) in the coming tick:
/// Bullet's broadphase has looked there.
bool partnersCover(const SoftBodyData& body, const Eigen::AlignedBox3d& box);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
