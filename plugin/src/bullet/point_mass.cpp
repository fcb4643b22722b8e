// SPDX-License-Identifier: Zlib
#include "bullet/point_mass.h"

#include "bullet/point_masses.h"
#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Its address in the extension pointer marks our bodies: no RTTI needed, and the user pointer and index stay
/// the user's.
int pointMassMark;

}  // namespace

PointMass::PointMass(const btRigidBodyConstructionInfo& info, SoftBodyData* owner, std::uint32_t index)
    : btRigidBody(info), owner_(owner), index_(index) {
  internalSetExtensionPointer(&pointMassMark);
  keepCollisionFilter();
}

PointMass::~PointMass() {
  if (owner_) forgetDeletedPoint(*owner_, index_);
}

PointMass* PointMass::from(btCollisionObject* object) {
  const bool ours = object && object->internalGetExtensionPointer() == &pointMassMark;
  return ours ? static_cast<PointMass*>(object) : nullptr;
}

const PointMass* PointMass::from(const btCollisionObject* object) {
  return from(const_cast<btCollisionObject*>(object));
}

bool PointMass::checkCollideWithOverride(const btCollisionObject* other) const {
  if (other == attachedTo) return false;
  const PointMass* point = from(other);
  if (point && point->owner_ == owner_ && owner_) return false;
  return btRigidBody::checkCollideWithOverride(other);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
