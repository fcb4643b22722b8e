// SPDX-License-Identifier: Zlib

// This header declares the objects of a world that may move in a tick, the motion of kinematic ones, and the
// search for objects near soft bodies.

#pragma once

#include "bullet/bullet_objects.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;

/// The objects of a world that may move in a tick, without soft bodies, in the order of the world's list.
struct MovingObjects {
  std::vector<btCollisionObject*> kinematic;    ///< in the broadphase
  std::vector<btRigidBody*> dynamic;            ///< awake
  std::vector<btMultiBodyLinkCollider*> links;  ///< asleep ones too

  /// Finds them in one pass over all objects.
  void find(const btCollisionWorld& world);
};

/// The motion of a kinematic object in the present tick.
struct KinematicMotion {
  btCollisionObject* object = nullptr;
  int id = 0;                         ///< unique in the broadphase
  btTransform start, end;             ///< poses at the start and end of the tick
  btTransform target;                 ///< pose set by the user, for the end of a stepSimulation()
  btTransform interpolated;           ///< its interpolation transform outside Rewound
  int ticksLeft = 0;                  ///< until it reaches the target, this tick included
  bool recordedBetweenSteps = false;  ///< by start() only
  btVector3 low, high;                ///< m, the box of its motion
  bool moves() const { return !(start == end); }
};

/// The kinematic objects of a world. Before the first tick of a stepSimulation() the user sets the pose that
/// an object has at its end. Here the object moves to that pose at constant velocity. Bullet's velocity does
/// not give this motion, because Bullet does not update it in the pre-tick callback or for sleeping bodies,
/// and massless bodies sleep from addRigidBody() on.
class KinematicMotions {
 public:
  /// Records the present poses, between two stepSimulation(), if follow() was not called for some time.
  void start(const btCollisionWorld& world);

  /// Computes the motions of a tick, at its start.
  void follow(const btDiscreteDynamicsWorld& world, const MovingObjects& objects, btScalar tick);

  const std::vector<KinematicMotion>& all() const { return motions_; }

  /// While it exists, the world transform of every kinematic object is its pose at the start of the tick,
  /// like that of all other objects, and the interpolation transform is its pose at the end.
  class Rewound {
   public:
    explicit Rewound(KinematicMotions& motions);
    ~Rewound();
    Rewound(const Rewound&) = delete;
    Rewound& operator=(const Rewound&) = delete;

   private:
    KinematicMotions* motions_;
  };

 private:
  const KinematicMotion* lastMotion(const btCollisionObject& object) const;

  std::vector<KinematicMotion> motions_, last_;  // in the order of the world's list
};

/// Returns whether an object is kinematic and moves in this tick, while kinematic ones are Rewound.
/// Characters count as moving, so that all their contacts have a standingDepth().
inline bool isMoved(const btCollisionObject& object) {
  return isCharacter(object) ||
         (isKinematic(object) && !(object.getWorldTransform() == object.getInterpolationWorldTransform()));
}

/// Returns the depth (m) at which a contact with a character's ghost begins to push; 0 for other objects.
/// `normal` is from the object to the soft body. A btKinematicCharacterController stands this deep in what is
/// below it. Without the depth it would press a soft body down in each tick, and follow it.
inline double standingDepth(const btDiscreteDynamicsWorld& world, const btCollisionObject& object,
                            const Eigen::Vector3d& normal) {
  constexpr double kSteepest = 0.7;  // cosine of the steepest slope, by default 45 degrees, that it stands on
  if (!isCharacter(object)) return 0.0;
  const double downward = normal.dot(toEigen(world.getGravity()).stableNormalized());
  return std::clamp(downward / kSteepest, 0.0, 1.0) *
         double(const_cast<btDiscreteDynamicsWorld&>(world).getDispatchInfo().m_allowedCcdPenetration);
}

/// Returns the displacement (m) of a position on a kinematic object in the tick, while it is Rewound; 0 on
/// other objects.
inline Eigen::Vector3d kinematicDisplacement(const btCollisionObject& object,
                                             const Eigen::Vector3d& position) {
  if (!isMoved(object)) return Eigen::Vector3d::Zero();
  const btTransform &start = object.getWorldTransform(), &end = object.getInterpolationWorldTransform();
  const btVector3 rotation = (end.getBasis() - start.getBasis()) * start.invXform(toBullet(position));
  return toEigen(rotation) + difference(end.getOrigin(), start.getOrigin());
}

/// Returns the angular velocity (rad/s) of an object, while it is Rewound.
Eigen::Vector3d spinOf(const btCollisionObject& object, double tick);

/// The motion of a position on an object in the tick, while it is Rewound.
struct SurfaceVelocity {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< m/s, at the tick's start
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< m/s^2
};

/// Returns the motion of a position that a kinematic object moves by `displacement` (m) in the tick. The
/// object turns about its origin, which moves along a straight line:
///     v(0) = V + w x r,    v(tick) = V + w x (r + d),    d = displacement - tick V
/// where V is the velocity of the origin and w the angular velocity. Between them the velocity is linear in
/// time. So that friction need not turn what it holds all at once at the start of a tick, only the
/// acceleration across `normal` counts: along it, gaps are those of a straight motion.
SurfaceVelocity surfaceVelocityOf(const btCollisionObject& object, const Eigen::Vector3d& displacement,
                                  const Eigen::Vector3d& normal, double tick);

// --- partners of the coming tick ---------------------------------------------------------------------------

/// Fills surface.partners of every awake surface body of `system` with the objects that Bullet's broadphase
/// found near it, sorted by unique id. Call it before a tick. One pass over the pairs replaces one query per
/// body. Boxes that change later in the tick have new partners: call it again.
void collectPartners(btDiscreteDynamicsWorld& world, const void* system);

/// Adds objects to the partners of all awake bodies that will come near in the coming tick by their own
/// motion, which is not yet in the broadphase. Dynamic bodies are added for surfaces only, because Bullet
/// handles their contacts with points.
void collectMovers(btDiscreteDynamicsWorld& world, const MovingObjects& objects,
                   const KinematicMotions& kinematic, const void* system, btScalar tick);

/// Returns a box (m) around the motion of a link in the coming tick. Extrapolates it from the box in the
/// broadphase, which is from the start of the last tick.
Eigen::AlignedBox3d boundsOf(const btMultiBodyLinkCollider& link, btScalar tick);

/// Returns whether Bullet's broadphase has searched all of this box (m), so that surface.partners has every
/// object that may enter it in the coming tick.
bool partnersCover(const SoftBodyData& body, const Eigen::AlignedBox3d& box);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
