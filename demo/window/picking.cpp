// SPDX-License-Identifier: Zlib
#include "window/picking.h"

#include <limber/contacts.h>

#include <algorithm>
#include <limits>

namespace limber::demo {
namespace {

using scenes::fromBullet;
using scenes::toBullet;

constexpr double kRayLength = 1000.0;  // m
constexpr double kMissAngle = 0.02;    // rad, by which a ray may miss a thin body: some 15 pixels

/// Keeps the triangle of the nearest hit, which Bullet's own callback does not.
struct NearestHit : btCollisionWorld::ClosestRayResultCallback {
  using ClosestRayResultCallback::ClosestRayResultCallback;
  int triangle = -1;

  btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool normalInWorld) override {
    triangle = result.m_localShapeInfo ? result.m_localShapeInfo->m_triangleIndex : -1;
    return ClosestRayResultCallback::addSingleResult(result, normalInWorld);
  }
};

Pick pickOfPoint(SoftBody* body, std::uint32_t point, const Ray& ray) {
  Pick pick;
  pick.soft = body;
  pick.point = point;
  pick.place = body->position(point);
  pick.distance = (pick.place - ray.origin).dot(ray.direction);
  return pick;
}

std::uint32_t nearestCorner(const SurfaceHit& hit) {
  Eigen::Index corner = 0;
  hit.weights.maxCoeff(&corner);
  return hit.points[static_cast<std::size_t>(corner)];
}

std::optional<Pick> pickOfHit(const NearestHit& hit, const Ray& ray) {
  const btCollisionObject* object = hit.m_collisionObject;
  const SurfaceHit surface = surfaceHit(object, hit.triangle, hit.m_hitPointWorld);
  if (surface.body) return pickOfPoint(surface.body, nearestCorner(surface), ray);
  if (const PointReference point = findPoint(object); point.body)
    return pickOfPoint(point.body, point.index, ray);
  if (object->isStaticOrKinematicObject()) return std::nullopt;
  Pick pick;
  pick.rigid = btRigidBody::upcast(const_cast<btCollisionObject*>(object));
  if (!pick.rigid) return std::nullopt;
  pick.place = fromBullet(hit.m_hitPointWorld);
  pick.distance = (pick.place - ray.origin).norm();
  return pick;
}

/// Returns the point with the smallest angle from the ray, if that is small and the point is nearer than
/// `farthest`.
std::optional<Pick> pickNearRay(const scenes::Scene& scene, const Ray& ray, double farthest) {
  std::optional<Pick> nearest;
  double smallest = kMissAngle;
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    SoftBody* body = scene.soft->body(b);
    for (std::uint32_t i = 0; i < body->pointCount(); ++i) {
      const Eigen::Vector3d away = body->position(i) - ray.origin;
      const double along = away.dot(ray.direction);
      if (along <= 0.0 || along > farthest) continue;
      const double angle = (away - along * ray.direction).norm() / along;
      if (angle < smallest) smallest = angle, nearest = pickOfPoint(body, i, ray);
    }
  }
  return nearest;
}

}  // namespace

std::optional<Pick> pick(const scenes::Scene& scene, const Ray& ray) {
  const btVector3 from = toBullet(ray.origin), to = toBullet(ray.at(kRayLength));
  NearestHit hit(from, to);
  scene.world->dynamics.rayTest(from, to, hit);
  if (!hit.hasHit()) return pickNearRay(scene, ray, kRayLength);
  if (std::optional<Pick> pick = pickOfHit(hit, ray)) return pick;
  return pickNearRay(scene, ray, double(hit.m_closestHitFraction) * kRayLength);
}

std::size_t indexOf(const scenes::Scene& scene, const SoftBody* body) {
  std::size_t index = 0;
  while (index < scene.soft->bodyCount() && scene.soft->body(index) != body) ++index;
  return index;
}

std::string Hand::grab(scenes::Scene& scene, const Pick& pick) {
  release();
  if (pick.rigid) {
    grabRigid(scene, pick);
  } else {
    Result<Grab> grab = limber::grab(*scene.soft, pick.soft, pick.point);
    if (!grab) return grab.error();
    grab_ = std::move(*grab);
  }
  place_ = pick.place;
  distance_ = pick.distance;
  return {};
}

// A soft joint with a limit, as Bullet's own examples have for the mouse.
void Hand::grabRigid(scenes::Scene& scene, const Pick& pick) {
  constexpr double kMaxSpeedChange = 1.0;  // m/s in a tick
  btRigidBody& body = *pick.rigid;
  body.activate(true);
  body.setActivationState(DISABLE_DEACTIVATION);
  const btVector3 pivot = body.getCenterOfMassTransform().inverse() * toBullet(pick.place);
  joint_ = std::make_unique<btPoint2PointConstraint>(body, pivot);
  joint_->m_setting.m_tau = btScalar(0.3);
  joint_->m_setting.m_impulseClamp = btScalar(kMaxSpeedChange / double(body.getInvMass()));
  world_ = &scene.world->dynamics;
  world_->addConstraint(joint_.get(), true);
}

void Hand::drag(const Ray& ray) {
  place_ = ray.at(distance_);
  if (joint_) joint_->setPivotB(toBullet(place_));
  grab_.moveTo(toBullet(place_));
}

void Hand::release() {
  grab_.release();
  if (!joint_) return;
  btRigidBody& body = joint_->getRigidBodyA();
  body.forceActivationState(ACTIVE_TAG);
  body.setDeactivationTime(0);
  world_->removeConstraint(joint_.get());
  joint_.reset();
}

Eigen::Vector3d Hand::held() const {
  if (const SoftBody* body = grab_.body()) return body->position(grab_.point());
  if (!joint_) return place_;
  return fromBullet(joint_->getRigidBodyA().getCenterOfMassTransform() * joint_->getPivotInA());
}

}  // namespace limber::demo
