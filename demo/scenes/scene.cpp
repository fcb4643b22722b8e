// SPDX-License-Identifier: Zlib
#include "scenes/scene.h"

#include "scenes/timeline.h"

#include <chrono>
#include <utility>

namespace limber::scenes {

void add(TickProfile& sum, const TickProfile& step) {
  sum.gatherMs += step.gatherMs;
  sum.stepMs += step.stepMs;
  sum.handOverMs += step.handOverMs;
  sum.takeBackMs += step.takeBackMs;
  sum.pointsStepped += step.pointsStepped;
  sum.springSubsteps += step.springSubsteps;
}

void addFloor(Scene& scene, double halfSize, double drawnHeight, double friction) {
  constexpr double kHalfThickness = 1.0;
  auto box = std::make_unique<btBoxShape>(toBullet({halfSize, kHalfThickness, halfSize}));
  btRigidBody& body = addStatic(*scene.world, std::move(box), {0.0, -kHalfThickness, 0.0}, friction);
  body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_DISABLE_VISUALIZE_OBJECT);
  scene.floor = {drawnHeight, halfSize};
}

std::string addBody(Scene& scene, SharedNetwork network, const SoftBodySettings& settings,
                    const BodyLook& look) {
  const Result<SoftBody*> body = scene.soft->createBody(std::move(network), settings);
  if (body) scene.looks.push_back(look);
  return body.error();
}

btRigidBody& addBall(Scene& scene, const Eigen::Vector3d& centre, double radius, double mass,
                     const Eigen::Vector3f& colour) {
  auto shape = std::make_unique<btSphereShape>(btScalar(radius));
  btRigidBody& body = addMovable(*scene.world, std::move(shape), mass, centre, 0.5);
  scene.rigidLooks.push_back({&body, colour});
  return body;
}

btRigidBody& addBox(Scene& scene, const Eigen::Vector3d& centre, const Eigen::Vector3d& halfExtents,
                    double mass, const Eigen::Vector3f& colour) {
  auto shape = std::make_unique<btBoxShape>(toBullet(halfExtents));
  btRigidBody& body = addMovable(*scene.world, std::move(shape), mass, centre, 0.5);
  scene.rigidLooks.push_back({&body, colour});
  return body;
}

void apply(const SceneOptions& options, SoftBodySettings& settings) {
  if (options.stiffness) settings.extensionStiffness = settings.compressionStiffness = *options.stiffness;
  if (options.damping) settings.damping = *options.damping;
  if (options.mass) settings.totalMass = *options.mass;
}

void addAirDrag(Scene& scene, double perSecond) {
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    SoftBody* body = scene.soft->body(b);
    for (std::uint32_t i = 0; i < body->pointCount(); ++i) body->point(i)->setDamping(btScalar(perSecond), 0);
  }
}

TickTimes tick(Scene& scene) {
  const btScalar step = btScalar(1) / btScalar(kTicksPerSecond);
  TickTimes times;
  if (scene.beforeTick) scene.beforeTick(scene);
  const auto start = std::chrono::steady_clock::now();
  scene.world->dynamics.stepSimulation(step, 0, step);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  times.total = took.count();
  times.soft = scene.soft->profile();
  scene.watch.look(*scene.soft);
  ++scene.ticks;
  if (scene.afterTick) scene.afterTick(scene);
  return times;
}

std::string checkEnd(const Scene& scene) {
  for (const Check& check : scene.endChecks) {
    std::string reason = check(scene);
    if (!reason.empty()) return reason;
  }
  return {};
}

std::uint64_t stateHash(const Scene& scene) {
  // FNV-1a over the hashes of the bodies
  std::uint64_t hash = 14695981039346656037ull;
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    hash = (hash ^ scene.soft->body(b)->stateHash()) * 1099511628211ull;
  }
  return hash;
}

std::size_t pointCount(const Scene& scene) {
  std::size_t sum = 0;
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) sum += scene.soft->body(b)->pointCount();
  return sum;
}

std::size_t springCount(const Scene& scene) {
  std::size_t sum = 0;
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b)
    sum += scene.soft->body(b)->network().springs.size();
  return sum;
}

}  // namespace limber::scenes
