// SPDX-License-Identifier: Zlib

// This header converts Bullet's numbers, tells what moves an object, and marks objects that the application
// may delete.

#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- numbers -----------------------------------------------------------------------------------------------

// The one place where btScalar (float or double) and the step's double meet.

inline Eigen::Vector3d toEigen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
/// In double, whatever Bullet's own precision.
inline Eigen::Vector3d difference(const btVector3& now, const btVector3& before) {
  return toEigen(now) - toEigen(before);
}

inline Eigen::Quaterniond toEigen(const btQuaternion& q) {
  return Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized();
}

inline btVector3 toBullet(const Eigen::Vector3d& v) {
  return btVector3(static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z()));
}

// --- kinds of objects --------------------------------------------------------------------------------------

/// Whether an object moves as its user tells: kinematic bodies, static ones with the kinematic flag among
/// them (Bullet's own idiom leaves both flags on), and ghosts, which character controllers move.
inline bool isKinematic(const btCollisionObject& object) {
  return object.isKinematicObject() || object.getInternalType() == btCollisionObject::CO_GHOST_OBJECT;
}

inline bool isStatic(const btCollisionObject& object) {
  return object.isStaticObject() && !isKinematic(object);
}

/// Whether nothing that touches an object moves it.
inline bool isStaticOrKinematic(const btCollisionObject& object) {
  return object.isStaticObject() || isKinematic(object);
}

/// Whether a rigid body moves by itself: neither held nor asleep.
inline bool isFree(const btRigidBody& body) {
  return !isStaticOrKinematic(body) && body.isActive() && body.getActivationState() != DISABLE_SIMULATION &&
         body.getWorldArrayIndex() >= 0;
}

// --- objects that may be gone ------------------------------------------------------------------------------

/// An object that was in the world when it was marked. The application may have deleted it since, and even
/// have made another one in the same place of memory.
struct ObjectHandle {
  const btCollisionObject* object = nullptr;
  int place = -1;  ///< in the world's list of objects, then
  int id = 0;      ///< unique in the broadphase
};

/// The object must be in the world.
inline ObjectHandle handleOf(const btCollisionObject& object) {
  return {&object, object.getWorldArrayIndex(), object.getBroadphaseHandle()->m_uniqueId};
}

/// Whether that very object is still in the world; only then may it be followed.
inline bool isValid(const btCollisionWorld& world, const ObjectHandle& mark) {
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  int place = mark.place;
  if (place < 0 || place >= objects.size() || objects[place] != mark.object)
    place = objects.findLinearSearch(const_cast<btCollisionObject*>(mark.object));
  if (place >= objects.size()) return false;
  const btBroadphaseProxy* proxy = objects[place]->getBroadphaseHandle();
  return proxy && proxy->m_uniqueId == mark.id;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
