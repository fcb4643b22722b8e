// SPDX-License-Identifier: Zlib
#include "bullet/bullet_objects.h"
#include "bullet/soft_body_data.h"

#include <limber/surface_hit.h>

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using CornerColumns = Eigen::Matrix3d;

/// Weights of a and b of the place on the segment that is nearest to p.
Eigen::Vector2d segmentWeights(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& p) {
  const double length2 = (b - a).squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
  return {1.0 - t, t};
}

/// The nearest place on the triangle's three sides.
Eigen::Vector3d sideWeights(const CornerColumns& x, const Eigen::Vector3d& p) {
  Eigen::Vector3d best = Eigen::Vector3d::UnitX();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Eigen::Vector2d w = segmentWeights(x.col(i), x.col(j), p);
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
    weights[i] = w[0], weights[j] = w[1];
    if ((x * weights - p).squaredNorm() < (x * best - p).squaredNorm()) best = weights;
  }
  return best;
}

Eigen::Vector3d nearestWeights(const CornerColumns& x, const Eigen::Vector3d& p) {
  const Eigen::Vector3d ab = x.col(1) - x.col(0), ac = x.col(2) - x.col(0), ap = p - x.col(0);
  const Eigen::Vector3d normal = ab.cross(ac);
  const double size = normal.squaredNorm();
  if (!(size > 0.0)) return sideWeights(x, p);
  const double v = ap.cross(ac).dot(normal) / size, w = ab.cross(ap).dot(normal) / size;
  const Eigen::Vector3d weights(1.0 - v - w, v, w);
  return weights.minCoeff() >= 0.0 ? weights : sideWeights(x, p);
}

CornerColumns cornersOf(const SoftBodyData& body, const SurfaceHit& hit) {
  CornerColumns x;
  for (int i = 0; i < 3; ++i) x.col(i) = body.state.position.col(hit.points[static_cast<std::size_t>(i)]);
  return x;
}

SurfaceHit hitOnTriangle(const SoftBodyData& body, std::size_t triangle, const Eigen::Vector3d& place) {
  SurfaceHit hit;
  hit.body = body.handle;
  hit.triangle = static_cast<std::uint32_t>(triangle);
  const Triangle& corners = body.network->surface[triangle];
  hit.points = {corners[0], corners[1], corners[2]};
  const CornerColumns x = cornersOf(body, hit);
  hit.weights = nearestWeights(x, place);
  hit.normal = (x.col(1) - x.col(0)).cross(x.col(2) - x.col(0)).stableNormalized();
  if (body.settings.scale.prod() < 0.0) hit.normal = -hit.normal;
  return hit;
}

SurfaceHit hitOnSpring(const SoftBodyData& body, std::uint32_t index, const Eigen::Vector3d& place) {
  SurfaceHit hit;
  hit.body = body.handle;
  hit.triangle = index;
  const NetworkSpring& spring = body.network->springs[index];
  hit.points = {spring.a, spring.b, spring.b};
  const CornerColumns x = cornersOf(body, hit);
  const Eigen::Vector2d w = segmentWeights(x.col(0), x.col(1), place);
  hit.weights = {w[0], w[1], 0.0};
  hit.normal = (place - x * hit.weights).stableNormalized();
  return hit;
}

}  // namespace

SurfaceReference findSurface(const btCollisionObject* object) {
  const SurfaceObject* surface = SurfaceObject::from(object);
  if (!surface || !surface->owner()) return {};
  return {surface->owner()->handle};
}

SurfaceHit surfaceHit(const btCollisionObject* object, int triangleIndex, const btVector3& place) {
  const SurfaceObject* surface = SurfaceObject::from(object);
  if (!surface || !surface->owner() || triangleIndex < 0) return {};
  const SoftBodyData& body = *surface->owner();
  const auto index = static_cast<std::size_t>(triangleIndex);
  if (index < body.network->surface.size()) return hitOnTriangle(body, index, toEigen(place));
  const std::vector<std::uint32_t>& springs = body.surface.shape->springs();
  if (index / 4 < springs.size()) return hitOnSpring(body, springs[index / 4], toEigen(place));
  return {};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
