// SPDX-License-Identifier: Zlib

// This header converts between Bullet's and Eigen's types, classifies objects by their kind of motion, and
// defines handles to objects that the application may delete.

#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- numbers -----------------------------------------------------------------------------------------------

// All conversions between btScalar (float or double) and the solver's double are here.

inline Eigen::Vector3d toEigen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
/// Subtracts in double precision, independent of Bullet's precision.
inline Eigen::Vector3d difference(const btVector3& now, const btVector3& before) {
  return toEigen(now) - toEigen(before);
}

inline Eigen::Quaterniond toEigen(const btQuaternion& q) {
  return Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized();
}

inline Eigen::Matrix3d toEigen(const btMatrix3x3& m) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) result.col(i) = toEigen(m.getColumn(i));
  return result;
}

/// Transforms a point to world coordinates in double precision: flat surfaces stay flat, and the corners of a
/// solid far from the world's origin stay on its faces.
inline Eigen::Vector3d worldPoint(const btTransform& pose, const Eigen::Vector3d& own) {
  return toEigen(pose.getBasis()) * own + toEigen(pose.getOrigin());
}

inline btVector3 toBullet(const Eigen::Vector3d& v) {
  return btVector3(static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z()));
}

inline btQuaternion toBullet(const Eigen::Quaterniond& q) {
  return btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w()));
}

inline bool isFinite(const btVector3& v) { return toEigen(v).allFinite(); }

// --- the plugin's own bodies -------------------------------------------------------------------------------

/// A body of this plugin. The address of a mark in its extension pointer identifies it: this needs no RTTI,
/// and the user pointer and index remain available to the user.
template <class Own>
class OwnBody : public btRigidBody {
 public:
  /// Returns the object as one of this class, or nullptr if it is none.
  static Own* from(btCollisionObject* object) {
    return object && object->internalGetExtensionPointer() == mark() ? static_cast<Own*>(object) : nullptr;
  }
  static const Own* from(const btCollisionObject* object) {
    return from(const_cast<btCollisionObject*>(object));
  }

 protected:
  explicit OwnBody(const btRigidBodyConstructionInfo& info) : btRigidBody(info) {
    internalSetExtensionPointer(mark());
  }

 private:
  static void* mark() {
    static char address;
    return &address;
  }
};

// --- kinds of objects --------------------------------------------------------------------------------------

/// Returns whether the user moves the object. This includes kinematic bodies, also those that have the static
/// flag as well (as in Bullet's own examples), and ghosts, which character controllers move.
inline bool isKinematic(const btCollisionObject& object) {
  return object.isKinematicObject() || object.getInternalType() == btCollisionObject::CO_GHOST_OBJECT;
}

/// Returns whether the object is the ghost of a character controller.
inline bool isCharacter(const btCollisionObject& object) {
  return object.getInternalType() == btCollisionObject::CO_GHOST_OBJECT &&
         (object.getCollisionFlags() & btCollisionObject::CF_CHARACTER_OBJECT) != 0;
}

inline bool isStatic(const btCollisionObject& object) {
  return object.isStaticObject() && !isKinematic(object);
}

/// Returns whether contacts cannot move the object.
inline bool isStaticOrKinematic(const btCollisionObject& object) {
  return object.isStaticObject() || isKinematic(object);
}

/// Returns whether a rigid body is dynamic, awake and in the simulation.
inline bool isFree(const btRigidBody& body) {
  return !isStaticOrKinematic(body) && body.isActive() && body.getActivationState() != DISABLE_SIMULATION &&
         body.getWorldArrayIndex() >= 0;
}

/// Returns whether the body is dynamic, in the world, and sleeps.
inline bool isSleepingBody(const btRigidBody& body) {
  return !isStaticOrKinematic(body) && body.getActivationState() == ISLAND_SLEEPING &&
         body.getWorldArrayIndex() >= 0;
}

/// Wakes a dynamic body within a step. The world has already applied gravity to the bodies that were awake at
/// its start.
inline void wakeInStep(btRigidBody& body) {
  body.activate(true);
  body.applyGravity();
}

/// Returns a bound (m/s) of the speed that the rotation of a body adds to points of its shape.
inline btScalar rotationSpeed(const btRigidBody& body) {
  const btScalar spin = body.getAngularVelocity().length();
  return spin > 0 ? spin * body.getCollisionShape()->getAngularMotionDisc() : btScalar(0);
}

inline bool isSphere(const btCollisionObject& object) {
  return object.getCollisionShape()->getShapeType() == SPHERE_SHAPE_PROXYTYPE;
}

inline bool isPlane(const btCollisionObject& object) {
  return object.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
}

/// Returns the radius (m) of the sphere around an object's shape.
inline double boundingRadiusOf(const btCollisionObject& object) {
  btVector3 center;
  btScalar radius;
  object.getCollisionShape()->getBoundingSphere(center, radius);
  return double(radius);
}

/// Returns whether both objects have a contact response, and Bullet's broadphase pairs the two, by groups and
/// masks or by the user's btOverlapFilterCallback.
inline bool arePaired(const btDynamicsWorld& world, const btCollisionObject& one,
                      const btCollisionObject& other) {
  auto* first = const_cast<btBroadphaseProxy*>(one.getBroadphaseHandle());
  auto* second = const_cast<btBroadphaseProxy*>(other.getBroadphaseHandle());
  return first && second && one.hasContactResponse() && other.hasContactResponse() &&
         const_cast<btDynamicsWorld&>(world).getPairCache()->needsBroadphaseCollision(first, second);
}

/// Unique in the broadphase. The order of what the broadphase finds depends on earlier ticks, so it is
/// sorted.
inline int idOf(const btCollisionObject& object) { return object.getBroadphaseHandle()->m_uniqueId; }
inline bool hasSmallerId(const btCollisionObject* a, const btCollisionObject* b) {
  return idOf(*a) < idOf(*b);
}

/// Calls visit(object) for the objects whose boxes in the broadphase overlap a box (m).
template <class Visit>
void forEachObjectIn(const btCollisionWorld& world, const btVector3& low, const btVector3& high,
                     Visit visit) {
  struct Callback final : btBroadphaseAabbCallback {
    explicit Callback(Visit& v) : visit(&v) {}
    Visit* visit;
    bool process(const btBroadphaseProxy* proxy) override {
      (*visit)(*static_cast<btCollisionObject*>(proxy->m_clientObject));
      return true;
    }
  } callback(visit);
  const_cast<btBroadphaseInterface*>(world.getBroadphase())->aabbTest(low, high, callback);
}

template <class Visit>
void forEachObjectIn(const btCollisionWorld& world, const Eigen::AlignedBox3d& box, Visit visit) {
  forEachObjectIn(world, toBullet(box.min()), toBullet(box.max()), visit);
}

/// Protected members of worlds that have no getters: a derived class may name them.
struct WorldMembers : btDiscreteDynamicsWorld {
  static constexpr auto kPreTickCallback = &WorldMembers::m_internalPreTickCallback;
  static constexpr auto kTimeSinceTick = &WorldMembers::m_localTime;
  static constexpr auto kFixedTick = &WorldMembers::m_fixedTimeStep;
  static constexpr auto kHasLatency = &WorldMembers::m_latencyMotionStateInterpolation;
};

// --- manifolds ---------------------------------------------------------------------------------------------

template <class Visit>
void forEachManifold(btDispatcher& dispatcher, Visit visit) {
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) visit(*dispatcher.getManifoldByIndexInternal(m));
}

/// Bullet's solver ignores a manifold with this contact processing threshold.
constexpr btScalar kIgnoredByBullet = -BT_LARGE_FLOAT;

inline void clearImpulses(btPersistentManifold& manifold) {
  for (int p = 0; p < manifold.getNumContacts(); ++p) {
    btManifoldPoint& point = manifold.getContactPoint(p);
    point.m_appliedImpulse = point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0;
  }
}

// --- handles to objects ------------------------------------------------------------------------------------

/// A handle to an object that was in the world when the handle was made. The application may have deleted the
/// object since, and another object may have the same address.
struct ObjectHandle {
  const btCollisionObject* object = nullptr;
  int index = -1;  ///< index in the world's list of objects when the handle was made
  int id = 0;      ///< see idOf()
};

/// Returns a handle to an object, which must be in the world.
inline ObjectHandle handleOf(const btCollisionObject& object) {
  return {&object, object.getWorldArrayIndex(), idOf(object)};
}

/// Returns whether the object is in a world other than this one.
inline bool isElsewhere(const btCollisionObject& object, const btCollisionWorld& world) {
  if (!object.getBroadphaseHandle()) return false;
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  const int index = object.getWorldArrayIndex();
  if (index >= 0 && index < objects.size() && objects[index] == &object) return false;
  return objects.findLinearSearch(const_cast<btCollisionObject*>(&object)) == objects.size();
}

/// Returns whether the same object is still in the world. Only then may its pointer be dereferenced.
inline bool isValid(const btCollisionWorld& world, const ObjectHandle& handle) {
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  int index = handle.index;
  if (index < 0 || index >= objects.size() || objects[index] != handle.object)
    index = objects.findLinearSearch(const_cast<btCollisionObject*>(handle.object));
  if (index >= objects.size()) return false;
  const btBroadphaseProxy* proxy = objects[index]->getBroadphaseHandle();
  return proxy && proxy->m_uniqueId == handle.id;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
