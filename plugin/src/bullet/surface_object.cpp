// SPDX-License-Identifier: Zlib
#include "bullet/surface_object.h"

#include "bullet/soft_body_data.h"
#include "bullet/surface_body.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

int surfaceMark;  // see pointMassMark

}  // namespace

SurfaceObject::SurfaceObject(SoftBodyData* owner)
    : btRigidBody(btRigidBodyConstructionInfo(0, nullptr, nullptr)), owner_(owner) {
  internalSetExtensionPointer(&surfaceMark);
  keepCollisionFilter();
  // a body of mass 0 is static until told otherwise; soft bodies draw themselves, see debug_draw.h
  setCollisionFlags(CF_DISABLE_VISUALIZE_OBJECT);
  setFlags(getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
}

SurfaceObject::~SurfaceObject() {
  if (owner_) forgetDeletedSurface(*owner_);
}

SurfaceObject* SurfaceObject::from(btCollisionObject* object) {
  const bool ours = object && object->internalGetExtensionPointer() == &surfaceMark;
  return ours ? static_cast<SurfaceObject*>(object) : nullptr;
}

const SurfaceObject* SurfaceObject::from(const btCollisionObject* object) {
  return from(const_cast<btCollisionObject*>(object));
}

bool SurfaceObject::mayTouch(const btCollisionObject& other) const {
  return btRigidBody::checkCollideWithOverride(&other) && other.checkCollideWith(this);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
