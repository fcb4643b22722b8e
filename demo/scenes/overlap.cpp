// SPDX-License-Identifier: Zlib
#include "scenes/overlap.h"

#include "scenes/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace limber::scenes {
namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

constexpr double kFullAngle = 4.0 * 3.141592653589793;

Corners cornersOf(const PosedSurface& surface, const Triangle& t) {
  return {surface.points.col(t[0]), surface.points.col(t[1]), surface.points.col(t[2])};
}

/// Returns the signed solid angle of a triangle seen from `p` (A. van Oosterom, J. Strackee, "The solid angle
/// of a plane triangle", 1983).
double solidAngle(const Corners& t, const Vector3d& p) {
  const Vector3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  const double numerator = a.dot(b.cross(c));
  return numerator == 0.0 ? 0.0 : 2.0 * std::atan2(numerator, denominator);
}

double distanceToSegment(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
  const Vector3d along = b - a;
  const double squared = along.squaredNorm();
  const double share = squared > 0.0 ? std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

/// Returns the distance to the plane if the projection of `p` is in the triangle, else to the nearest edge.
double distanceToTriangle(const Corners& t, const Vector3d& p) {
  const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  bool above = normal.squaredNorm() > 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d &a = t[k], &b = t[(k + 1) % 3];
    above = above && normal.dot((b - a).cross(p - a)) >= 0.0;
    nearest = std::min(nearest, distanceToSegment(a, b, p));
  }
  return above ? std::abs(normal.normalized().dot(p - t[0])) : nearest;
}

/// Returns the depth of a point inside a surface, m; 0 outside.
double depthInside(const PosedSurface& surface, const Vector3d& point) {
  return surface.box.contains(point) ? std::max(0.0, -signedDistance(surface, point)) : 0.0;
}

/// Returns the largest depth of a triangle's corners, midpoints of edges and centre.
double depthOfTriangle(const Corners& t, const PosedSurface& outer) {
  double deepest = depthInside(outer, (t[0] + t[1] + t[2]) / 3.0);
  for (std::size_t k = 0; k < 3; ++k) {
    deepest = std::max(deepest, depthInside(outer, t[k]));
    deepest = std::max(deepest, depthInside(outer, 0.5 * (t[k] + t[(k + 1) % 3])));
  }
  return deepest;
}

}  // namespace

PosedSurface posed(const Eigen::Matrix3Xd& points, const std::vector<Triangle>& triangles) {
  PosedSurface surface{points, &triangles, {}, true};
  for (const Triangle& t : triangles)
    for (const std::uint32_t corner : t) surface.box.extend(Vector3d(points.col(corner)));
  return surface;
}

PosedSurface posed(const SoftBody& body) {
  Eigen::Matrix3Xd points(3, body.pointCount());
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) points.col(i) = body.position(i);
  PosedSurface surface = posed(points, body.network().surface);
  surface.encloses = body.network().kind == NetworkKind::Solid;
  return surface;
}

double signedDistance(const PosedSurface& surface, const Vector3d& point) {
  double angle = 0.0, nearest = std::numeric_limits<double>::infinity();
  for (const Triangle& t : *surface.triangles) {
    const Corners corners = cornersOf(surface, t);
    if (surface.encloses) angle += solidAngle(corners, point);
    nearest = std::min(nearest, distanceToTriangle(corners, point));
  }
  return std::abs(angle) > 0.5 * kFullAngle ? -nearest : nearest;
}

Overlap deepestOverlap(const std::vector<PosedSurface>& surfaces) {
  Overlap deepest;
  for (std::size_t inner = 0; inner < surfaces.size(); ++inner)
    for (std::size_t outer = 0; outer < surfaces.size(); ++outer) {
      if (inner == outer || !surfaces[inner].box.intersects(surfaces[outer].box)) continue;
      for (const Triangle& t : *surfaces[inner].triangles) {
        const double depth = depthOfTriangle(cornersOf(surfaces[inner], t), surfaces[outer]);
        if (depth > deepest.depth) deepest = {depth, inner, outer};
      }
    }
  return deepest;
}

namespace {

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

/// Returns the largest depth of a box's corners, midpoints of edges, centres of faces, and centre.
double depthOfBox(const PosedSurface& surface, const btRigidBody& rigid, const btBoxShape& box) {
  if (!surface.encloses) return 0.0;
  const btVector3 half = box.getHalfExtentsWithMargin();
  double deepest = 0.0;
  for (int sample = 0; sample < 27; ++sample) {
    const btVector3 at(btScalar(sample % 3 - 1), btScalar(sample / 3 % 3 - 1), btScalar(sample / 9 - 1));
    const Vector3d point = fromBullet(rigid.getWorldTransform() * (at * half));
    if (surface.box.contains(point)) deepest = std::max(deepest, -signedDistance(surface, point));
  }
  return deepest;
}

/// Returns the largest depth of a soft body's corners, midpoints of edges and centres of triangles in a rigid
/// body.
double depthOfSurface(const PosedSurface& soft, const btRigidBody& rigid) {
  double deepest = 0.0;
  for (const Triangle& t : *soft.triangles) {
    const Vector3d a = soft.points.col(t[0]), b = soft.points.col(t[1]), c = soft.points.col(t[2]);
    for (const Vector3d& point : {a, b, c, Vector3d(0.5 * (a + b)), Vector3d(0.5 * (b + c)),
                                  Vector3d(0.5 * (c + a)), Vector3d((a + b + c) / 3.0)})
      deepest = std::max(deepest, depthIn(rigid, point));
  }
  return deepest;
}

bool areApart(const PosedSurface& soft, const btRigidBody& rigid) {
  btVector3 low, high;
  rigid.getAabb(low, high);
  return !soft.box.intersects(Eigen::AlignedBox3d(fromBullet(low), fromBullet(high)));
}

}  // namespace

double depthIn(const btRigidBody& rigid, const Vector3d& point) {
  const btVector3 local = rigid.getWorldTransform().inverse() * toBullet(point);
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
