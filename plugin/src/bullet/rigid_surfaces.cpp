// SPDX-License-Identifier: Zlib
#include "bullet/rigid_surfaces.h"

#include "bullet/bullet_objects.h"
#include "bullet/tick_contacts.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// m, how far a place on the object gets in a tick.
Eigen::Vector3d motionOf(const btCollisionObject& object, const Eigen::Vector3d& place, double tick) {
  const btRigidBody* rigid = btRigidBody::upcast(&object);
  Eigen::Vector3d motion = tick * velocityOf(object, toBullet(place), tick);
  if (rigid && isFree(*rigid))
    motion += tick * tick * double(rigid->getInvMass()) * toEigen(rigid->getTotalForce());
  return motion;
}

struct LocalBox {
  btVector3 low, high;
};

LocalBox localBoxOf(const btTransform& pose, const SweptBox& world) {
  LocalBox box;
  btTransformAabb(toBullet(Eigen::Vector3d(world.low.head<3>())),
                  toBullet(Eigen::Vector3d(world.high.head<3>())), btScalar(0), pose.inverse(), box.low,
                  box.high);
  return box;
}

/// The box in which something of the object is at the moment of its pose if it comes into `box` within the
/// tick. Motion is linear in the place, so no part of it moves farther than the farthest corner of its bounds.
SweptBox grownByMotion(const btCollisionObject& object, SweptBox box, double tick) {
  btVector3 bounds[2];
  object.getCollisionShape()->getAabb(object.getWorldTransform(), bounds[0], bounds[1]);
  Eigen::Vector3d most = Eigen::Vector3d::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const btVector3 place(bounds[corner & 1].x(), bounds[corner >> 1 & 1].y(), bounds[corner >> 2].z());
    most = most.cwiseMax(motionOf(object, toEigen(place), tick).cwiseAbs());
  }
  box.low.head<3>() -= most.array();
  box.high.head<3>() += most.array();
  return box;
}

struct ChildCollector final : btDbvt::ICollide {
  explicit ChildCollector(std::vector<int>& c) : children(&c) {}
  std::vector<int>* children;
  void Process(const btDbvtNode* leaf) override { children->push_back(leaf->dataAsInt); }
};

/// Adds the children whose boxes meet `box`, in their order.
void findChildren(const btCompoundShape& compound, const LocalBox& box,
                  btAlignedObjectArray<const btDbvtNode*>& stack, std::vector<int>& children) {
  const auto first = static_cast<std::ptrdiff_t>(children.size());
  const btDbvtVolume volume = btDbvtVolume::FromMM(box.low, box.high);
  if (const btDbvt* tree = compound.getDynamicAabbTree()) {
    ChildCollector collector(children);
    tree->collideTVNoStackAlloc(tree->m_root, volume, stack, collector);
    std::sort(children.begin() + first, children.end());
    return;
  }
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    btVector3 low, high;
    compound.getChildShape(i)->getAabb(compound.getChildTransform(i), low, high);
    if (Intersect(volume, btDbvtVolume::FromMM(low, high))) children.push_back(i);
  }
}

/// Of a child of a part's parent.
std::uint64_t childNumber(std::uint64_t parent, int child) {
  return parent * 0x100000001b3u + static_cast<std::uint64_t>(child) + 1;
}

void keepStart(RigidPart& part) {
  if (part.moved) return;
  part.start = part.position;
  part.whole = part.motion;
  part.moved = true;
}

}  // namespace

void movePart(RigidPart& part, double share, double ahead) {
  keepStart(part);
  part.position = part.start + share * part.whole;
  part.motion = ahead * part.whole;
  fitBoxes(part.moving, part.boxes);
}

void movePart(RigidPart& part, const btTransform& from, const RigidState& to, double ahead) {
  keepStart(part);
  const Eigen::Matrix3d turn = (to.rotation * toEigen(from.getRotation()).conjugate()).toRotationMatrix();
  const Eigen::Vector3d origin = toEigen(from.getOrigin());
  for (Eigen::Index i = 0; i < part.start.cols(); ++i) {
    const Eigen::Vector3d arm = turn * (part.start.col(i) - origin);
    part.position.col(i) = to.position + arm;
    part.motion.col(i) = ahead * to.velocityAt(arm);
  }
  fitBoxes(part.moving, part.boxes);
}

void RigidSurfaces::clear() {
  for (const std::size_t place : asked_) known_[place].clear();
  asked_.clear();
  used_ = 0;
  shapes_->forgetOld();
}

bool RigidSurfaces::hasParts(const btCollisionShape& shape) {
  if (shape.isConvex()) return !shapes_->surfaceOf(shape).topology.elements.empty();
  if (!shape.isCompound()) return false;
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i)
    if (hasParts(*compound.getChildShape(i))) return true;
  return false;
}

const std::vector<RigidPart*>& RigidSurfaces::partsNear(const btCollisionObject& object,
                                                              const SweptBox& box, double tick) {
  near_.clear();
  const btCollisionShape& shape = *object.getCollisionShape();
  const SweptBox grown = shape.isCompound() ? grownByMotion(object, box, tick) : box;
  addNear(object, shape, object.getWorldTransform(), 0, grown, tick);
  return near_;
}

void RigidSurfaces::addNear(const btCollisionObject& object, const btCollisionShape& shape,
                            const btTransform& pose, std::uint64_t number, const SweptBox& box, double tick) {
  if (shape.isConvex()) return addPart(object, shape, pose, number, tick);
  if (!shape.isCompound()) return;
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  const std::size_t first = children_.size();
  findChildren(compound, localBoxOf(pose, box), stack_, children_);
  for (std::size_t i = first, end = children_.size(); i < end; ++i) {
    const int child = children_[i];
    addNear(object, *compound.getChildShape(child), pose * compound.getChildTransform(child),
            childNumber(number, child), box, tick);
  }
  children_.resize(first);
}

void RigidSurfaces::addPart(const btCollisionObject& object, const btCollisionShape& shape,
                            const btTransform& pose, std::uint64_t number, double tick) {
  const auto place = static_cast<std::size_t>(object.getWorldArrayIndex());
  if (place >= known_.size()) known_.resize(place + 1);
  std::vector<Known>& known = known_[place];
  const auto isBefore = [](const Known& k, std::uint64_t n) { return k.number < n; };
  auto it = std::lower_bound(known.begin(), known.end(), number, isBefore);
  if (it == known.end() || it->number != number) {
    const ShapeSurface& surface = shapes_->surfaceOf(shape);
    if (surface.topology.elements.empty()) return;
    if (known.empty()) asked_.push_back(place);
    it = known.insert(it, {number, &makePart(object, surface, pose, tick)});
    it->part->number = number;
  }
  near_.push_back(it->part);
}

RigidPart& RigidSurfaces::makePart(const btCollisionObject& object, const ShapeSurface& surface,
                                   const btTransform& pose, double tick) {
  if (used_ == parts_.size()) parts_.emplace_back();
  RigidPart& part = parts_[used_++];
  part.surface = &surface;
  part.moved = false;
  const Points& rest = surface.topology.rest;
  part.position.resize(3, rest.cols());
  part.motion.resize(3, rest.cols());
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    const Eigen::Vector3d place = toEigen(pose * toBullet(Eigen::Vector3d(rest.col(i))));
    part.motion.col(i) = motionOf(object, place, tick);
    part.position.col(i) = place;
  }
  part.moving = {&surface.topology, &part.position, &part.motion, surface.radius, &part.boxes};
  fitBoxes(part.moving, part.boxes);
  return part;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
