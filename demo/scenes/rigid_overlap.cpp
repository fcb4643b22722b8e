// SPDX-License-Identifier: Zlib
#include "scenes/rigid_overlap.h"

#include "scenes/scene_world.h"

#include <algorithm>

namespace limber::scenes {
namespace {

using Eigen::Vector3d;

const btBoxShape* asBox(const btRigidBody& rigid) {
  return rigid.getCollisionShape()->getShapeType() == BOX_SHAPE_PROXYTYPE
             ? static_cast<const btBoxShape*>(rigid.getCollisionShape())
             : nullptr;
}

const btSphereShape* asBall(const btRigidBody& rigid) {
  return rigid.getCollisionShape()->getShapeType() == SPHERE_SHAPE_PROXYTYPE
             ? static_cast<const btSphereShape*>(rigid.getCollisionShape())
             : nullptr;
}

/// Corners, middles of edges and faces, and the middle.
double depthOfBox(const PosedSurface& surface, const btRigidBody& rigid, const btBoxShape& box) {
  if (!surface.encloses) return 0.0;
  const btVector3 half = box.getHalfExtentsWithMargin();
  double deepest = 0.0;
  for (int sample = 0; sample < 27; ++sample) {
    const btVector3 at(btScalar(sample % 3 - 1), btScalar(sample / 3 % 3 - 1), btScalar(sample / 9 - 1));
    const Vector3d place = fromBullet(rigid.getWorldTransform() * (at * half));
    if (surface.box.contains(place)) deepest = std::max(deepest, -signedDistance(surface, place));
  }
  return deepest;
}

/// How deep a soft body's corners, and middles of edges and triangles, are inside a rigid one.
double depthOfSurface(const PosedSurface& soft, const btRigidBody& rigid) {
  double deepest = 0.0;
  for (const Triangle& t : *soft.triangles) {
    const Vector3d a = soft.points.col(t[0]), b = soft.points.col(t[1]), c = soft.points.col(t[2]);
    for (const Vector3d& place : {a, b, c, Vector3d(0.5 * (a + b)), Vector3d(0.5 * (b + c)),
                                  Vector3d(0.5 * (c + a)), Vector3d((a + b + c) / 3.0)})
      deepest = std::max(deepest, depthIn(rigid, place));
  }
  return deepest;
}

bool areApart(const PosedSurface& soft, const btRigidBody& rigid) {
  btVector3 low, high;
  rigid.getAabb(low, high);
  return !soft.box.intersects(Eigen::AlignedBox3d(fromBullet(low), fromBullet(high)));
}

}  // namespace

double depthIn(const btRigidBody& rigid, const Vector3d& place) {
  const btVector3 local = rigid.getWorldTransform().inverse() * toBullet(place);
  if (const btSphereShape* ball = asBall(rigid))
    return std::max(0.0, double(ball->getRadius() - local.length()));
  if (const btBoxShape* box = asBox(rigid)) {
    const btVector3 inside = box->getHalfExtentsWithMargin() - local.absolute();
    return std::max(0.0, double(inside[inside.minAxis()]));
  }
  return 0.0;
}

double depthIn(const PosedSurface& surface, const btRigidBody& rigid) {
  if (const btBoxShape* box = asBox(rigid)) return depthOfBox(surface, rigid, *box);
  const btSphereShape* ball = asBall(rigid);
  if (!ball) return 0.0;
  const Vector3d centre = fromBullet(rigid.getWorldTransform().getOrigin());
  return std::max(0.0, double(ball->getRadius()) - signedDistance(surface, centre));
}

RigidOverlap deepestOverlap(const std::vector<PosedSurface>& softs, const btRigidBody& rigid) {
  RigidOverlap deepest;
  for (std::size_t s = 0; s < softs.size(); ++s) {
    if (areApart(softs[s], rigid)) continue;
    const double depth = std::max(depthIn(softs[s], rigid), depthOfSurface(softs[s], rigid));
    if (depth > deepest.depth) deepest = {depth, s, 0};
  }
  return deepest;
}

RigidOverlap deepestOverlap(const std::vector<PosedSurface>& softs,
                            const std::vector<std::unique_ptr<btRigidBody>>& rigids) {
  RigidOverlap deepest;
  for (std::size_t r = 0; r < rigids.size(); ++r) {
    const RigidOverlap one = deepestOverlap(softs, *rigids[r]);
    if (one.depth > deepest.depth) deepest = {one.depth, one.soft, r};
  }
  return deepest;
}

}  // namespace limber::scenes
