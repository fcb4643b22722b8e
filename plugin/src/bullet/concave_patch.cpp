// SPDX-License-Identifier: Zlib
#include "bullet/concave_patch.h"

#include "bullet/convert.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

struct Box {
  btVector3 low, high;
  bool holds(const Box& other) const {
    for (int i = 0; i < 3; ++i)
      if (other.low[i] < low[i] || other.high[i] > high[i]) return false;
    return true;
  }
};

/// The box of the body's motion in the partner's coordinates.
Box boxIn(const btTransform& pose, const SweptBox& world) {
  btVector3 low, high;
  btTransformAabb(toBullet(Eigen::Vector3d(world.low.head<3>())),
                  toBullet(Eigen::Vector3d(world.high.head<3>())), btScalar(0), pose.inverse(), low, high);
  return {low, high};
}

/// So much larger than the body it is made for that a body that slides or rolls needs a new one only now and
/// then.
Box enlarged(const Box& box) {
  const btVector3 more = btScalar(0.25) * (box.high - box.low);
  return {box.low - more, box.high + more};
}

ConcavePatch& patchOf(SoftBodyData& body, int partner) {
  std::vector<ConcavePatch>& patches = body.surface.patches;
  const auto isPartner = [&](const ConcavePatch& patch) { return patch.partner == partner; };
  const auto it = std::find_if(patches.begin(), patches.end(), isPartner);
  if (it != patches.end()) return *it;
  patches.emplace_back();
  patches.back().partner = partner;
  return patches.back();
}

void makePatch(ConcavePatch& patch, const btCollisionObject& partner, const Box& box) {
  const btTransform& pose = partner.getWorldTransform();
  patch.pose = pose;
  patch.low = box.low, patch.high = box.high;
  patch.surface =
      makePatchSurface(*static_cast<const btConcaveShape*>(partner.getCollisionShape()), box.low, box.high);
  if (!patch.part) patch.part = std::make_unique<RigidPart>();
  RigidPart& part = *patch.part;
  const Points& rest = patch.surface.topology.rest;
  part.surface = &patch.surface;
  part.position.resize(3, rest.cols());
  part.motion.setZero(3, rest.cols());
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    part.position.col(i) = toEigen(pose * toBullet(Eigen::Vector3d(rest.col(i))));
  part.moving = {&patch.surface.topology, &part.position, &part.motion, patch.surface.radius, &part.boxes};
  fitBoxes(part.moving, part.boxes);
}

}  // namespace

const RigidPart* patchAround(SoftBodyData& body, const btCollisionObject& partner,
                             const MovingSurface& soft) {
  if (soft.boxes->nodes.empty()) return nullptr;
  const Box box = boxIn(partner.getWorldTransform(), soft.boxes->nodes[0]);
  ConcavePatch& patch = patchOf(body, partner.getBroadphaseHandle()->m_uniqueId);
  const bool good =
      patch.part && patch.pose == partner.getWorldTransform() && Box{patch.low, patch.high}.holds(box);
  if (!good) makePatch(patch, partner, enlarged(box));
  return patch.surface.topology.elements.empty() ? nullptr : patch.part.get();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
