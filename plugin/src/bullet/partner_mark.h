// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// An object that was in the world when it was marked. The application may have deleted it since, and even
/// have made another one in the same place of memory.
struct PartnerMark {
  const btCollisionObject* object = nullptr;
  int place = -1;  ///< in the world's list of objects, then
  int id = 0;      ///< unique in the broadphase
};

/// The object must be in the world.
inline PartnerMark markOf(const btCollisionObject& object) {
  return {&object, object.getWorldArrayIndex(), object.getBroadphaseHandle()->m_uniqueId};
}

/// Whether that very object is still in the world; only then may it be followed.
inline bool isThere(const btCollisionWorld& world, const PartnerMark& mark) {
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
