// SPDX-License-Identifier: Zlib
#include "bullet/concave_patch.h"

#include "bullet/bullet_objects.h"
#include "bullet/kinematic_motion.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

bool holds(const LocalBox& box, const LocalBox& other) {
  for (int i = 0; i < 3; ++i)
    if (other.low[i] < box.low[i] || other.high[i] > box.high[i]) return false;
  return true;
}

/// The box of the body's motion in the coordinates of the partner, at the start and the end of its own.
LocalBox boxIn(const btCollisionObject& partner, const SweptBox& world) {
  const Eigen::Vector3d low = world.low.head<3>(), high = world.high.head<3>();
  LocalBox box = localBoxOf(partner.getWorldTransform(), low, high);
  if (!isKinematic(partner)) return box;
  const LocalBox end = localBoxOf(partner.getInterpolationWorldTransform(), low, high);
  box.low.setMin(end.low), box.high.setMax(end.high);
  return box;
}

/// So much larger than the body it is made for that a body that slides or rolls needs a new one only now and
/// then.
LocalBox enlarged(const LocalBox& box) {
  const btVector3 more = btScalar(0.25) * (box.high - box.low);
  return {box.low - more, box.high + more};
}

ConcavePatch* findPatch(SoftBodyData& body, int partner) {
  std::deque<ConcavePatch>& patches = body.surface.patches;
  const auto isPartner = [&](const ConcavePatch& patch) { return patch.partner == partner; };
  const auto it = std::find_if(patches.begin(), patches.end(), isPartner);
  return it != patches.end() ? &*it : nullptr;
}

/// The patch of the last tick, or the memory of one that is no longer near.
ConcavePatch& patchOf(SoftBodyData& body, int partner) {
  ConcavePatch* patch = findPatch(body, partner);
  if (!patch) {
    patch = findPatch(body, 0);
    if (!patch) patch = &body.surface.patches.emplace_back();
    patch->partner = partner;
    patch->surface.topology.elements.clear();
    patch->low = btVector3(1, 1, 1), patch->high = btVector3(0, 0, 0);
  }
  patch->used = true;
  return *patch;
}

/// Where its triangles are at the start of the tick, and how they move in it.
void placePatch(ConcavePatch& patch, const btCollisionObject& partner) {
  const btTransform& pose = partner.getWorldTransform();
  patch.pose = pose;
  RigidPart& part = *patch.part;
  part.moved = false;
  const Points& rest = patch.surface.topology.rest;
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    part.position.col(i) = toEigen(pose * toBullet(Eigen::Vector3d(rest.col(i))));
    part.motion.col(i) = kinematicWay(partner, part.position.col(i));
  }
  fitBoxes(part.moving, part.boxes);
}

void makePatch(ConcavePatch& patch, const btCollisionObject& partner, const LocalBox& box) {
  patch.low = box.low, patch.high = box.high;
  patch.surface =
      makePatchSurface(*static_cast<const btConcaveShape*>(partner.getCollisionShape()), box.low, box.high);
  if (!patch.part) patch.part = std::make_unique<RigidPart>();
  RigidPart& part = *patch.part;
  const Points& rest = patch.surface.topology.rest;
  part.surface = &patch.surface;
  part.position.resize(3, rest.cols());
  part.motion.resize(3, rest.cols());
  part.moving = {&patch.surface.topology, &part.position, &part.motion, patch.surface.radius, &part.boxes};
  placePatch(patch, partner);
}

}  // namespace

RigidPart* patchAround(SoftBodyData& body, const btCollisionObject& partner, const MovingSurface& soft) {
  if (soft.boxes->nodes.empty()) return nullptr;
  const LocalBox box = boxIn(partner, soft.boxes->nodes[0]);
  ConcavePatch& patch = patchOf(body, partner.getBroadphaseHandle()->m_uniqueId);
  if (!patch.part || !holds({patch.low, patch.high}, box))
    makePatch(patch, partner, enlarged(box));
  else if (isKinematic(partner) || !(patch.pose == partner.getWorldTransform()))
    placePatch(patch, partner);
  return patch.surface.topology.elements.empty() ? nullptr : patch.part.get();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
