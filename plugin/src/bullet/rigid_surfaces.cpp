// SPDX-License-Identifier: Zlib
#include "bullet/rigid_surfaces.h"

#include "bullet/convert.h"
#include "bullet/tick_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// m, how far a place on the object gets in a tick. Kinematic objects are already where they will be at its
/// end; see startOf().
Eigen::Vector3d motionOf(const btCollisionObject& object, const Eigen::Vector3d& place, double tick) {
  const btRigidBody* rigid = btRigidBody::upcast(&object);
  if (!rigid) return Eigen::Vector3d::Zero();
  Eigen::Vector3d motion = tick * velocityOf(object, toBullet(place));
  if (isFree(*rigid)) motion += tick * tick * double(rigid->getInvMass()) * toEigen(rigid->getTotalForce());
  return motion;
}

}  // namespace

void RigidSurfaces::clear() {
  for (const std::size_t place : asked_) known_[place] = Range();
  asked_.clear();
  used_ = 0;
}

RigidSurfaces::Range RigidSurfaces::partsOf(const btCollisionObject& object, double tick) {
  const auto place = static_cast<std::size_t>(object.getWorldArrayIndex());
  if (place >= known_.size()) known_.resize(place + 1);
  if (known_[place].end > 0) return known_[place];
  const std::size_t first = used_;
  addParts(object, *object.getCollisionShape(), object.getWorldTransform(), tick);
  asked_.push_back(place);
  // counted from 1, so that an object without parts is known, too
  return known_[place] = {first + 1, used_ + 1};
}

void RigidSurfaces::addParts(const btCollisionObject& object, const btCollisionShape& shape,
                             const btTransform& pose, double tick) {
  if (shape.isConvex()) {
    addPart(object, shapes_->surfaceOf(shape), pose, tick);
  } else if (shape.isCompound()) {
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i)
      addParts(object, *compound.getChildShape(i), pose * compound.getChildTransform(i), tick);
  }
}

void RigidSurfaces::addPart(const btCollisionObject& object, const ShapeSurface& surface,
                            const btTransform& pose, double tick) {
  if (surface.topology.elements.empty()) return;
  if (used_ == parts_.size()) parts_.emplace_back();
  RigidPart& part = parts_[used_++];
  part.surface = &surface;
  const Points& rest = surface.topology.rest;
  part.position.resize(3, rest.cols());
  part.motion.resize(3, rest.cols());
  const bool kinematic = object.isKinematicObject();
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    const Eigen::Vector3d place = toEigen(pose * toBullet(Eigen::Vector3d(rest.col(i))));
    part.motion.col(i) = motionOf(object, place, tick);
    part.position.col(i) = place;
    if (kinematic) part.position.col(i) -= part.motion.col(i);
  }
  part.moving = {&surface.topology, &part.position, &part.motion, surface.radius, &part.boxes};
  fitBoxes(part.moving, part.boxes);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
