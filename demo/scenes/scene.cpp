// SPDX-License-Identifier: Zlib
#include "scenes/scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace limber::scenes {

btRigidBody& addStatic(SceneWorld& world, std::unique_ptr<btCollisionShape> shape,
                       const Eigen::Vector3d& centre, double friction) {
  auto body = std::make_unique<btRigidBody>(btScalar(0), nullptr, shape.get());
  body->getWorldTransform().setOrigin(toBullet(centre));
  body->setFriction(btScalar(friction));
  world.dynamics.addRigidBody(body.get());
  world.shapes.push_back(std::move(shape));
  world.statics.push_back(std::move(body));
  return *world.statics.back();
}

btRigidBody& addMovable(SceneWorld& world, std::unique_ptr<btCollisionShape> shape, double mass,
                        const Eigen::Vector3d& centre, double friction) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0.0) shape->calculateLocalInertia(btScalar(mass), inertia);
  auto body = std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape.get(), inertia);
  body->getWorldTransform().setOrigin(toBullet(centre));
  body->setInterpolationWorldTransform(body->getWorldTransform());
  body->setFriction(btScalar(friction));
  if (mass == 0.0) {
    body->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
  }
  world.dynamics.addRigidBody(body.get());
  world.shapes.push_back(std::move(shape));
  world.movables.push_back(std::move(body));
  return *world.movables.back();
}

void moveTo(btRigidBody& body, const Eigen::Vector3d& centre) {
  btTransform transform = body.getWorldTransform();
  transform.setOrigin(toBullet(centre));
  body.setWorldTransform(transform);
}

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// a box that is not finite counts as infinite; a box of points that are not finite is empty
double diagonal(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return kInfinity;
  const double length = box.diagonal().norm();
  return std::isfinite(length) ? length : kInfinity;
}

}  // namespace

void RestWatch::look(const SoftBodySystem& soft) {
  if (ticks_++ % kWindowTicks == 0) {
    before_ = std::move(present_);
    present_.clear();
  }
  firstPoint_.assign(1, 0);
  for (std::size_t b = 0; b < soft.bodyCount(); ++b) {
    firstPoint_.push_back(firstPoint_.back() + soft.body(b)->pointCount());
  }
  present_.resize(firstPoint_.back());
  for (std::size_t b = 0; b < soft.bodyCount(); ++b) {
    for (std::uint32_t i = 0; i < soft.body(b)->pointCount(); ++i) {
      present_[firstPoint_[b] + i].extend(soft.body(b)->position(i));
    }
  }
}

double RestWatch::largestMotion(std::size_t body) const {
  if (before_.size() != present_.size() || body + 1 >= firstPoint_.size()) return kInfinity;
  double largest = 0.0;
  for (std::size_t i = firstPoint_[body]; i < firstPoint_[body + 1]; ++i) {
    largest = std::max({largest, diagonal(present_[i]), diagonal(before_[i])});
  }
  return largest;
}

std::int64_t Timeline::ticksFor(std::int64_t frame) const {
  return (frame * kTicksPerSecond + framesPerSecond - 1) / framesPerSecond;
}

double Timeline::tickFraction(std::int64_t frame) const {
  const std::int64_t over = ticksFor(frame) * framesPerSecond - frame * kTicksPerSecond;
  return 1.0 - static_cast<double>(over) / static_cast<double>(framesPerSecond);
}

std::int64_t Timeline::frameCount() const { return ticks * framesPerSecond / kTicksPerSecond + 1; }

Timeline timelineOf(double seconds, int framesPerSecond) {
  // 0.1 s is slightly more than 6 ticks in binary; that must not become a 7th tick
  constexpr double kHair = 1e-9;
  const double ticks = std::ceil(seconds * static_cast<double>(kTicksPerSecond) - kHair);
  return {static_cast<std::int64_t>(ticks), framesPerSecond};
}

void addFloor(Scene& scene, double halfSize, double friction) {
  constexpr double kHalfThickness = 1.0;
  constexpr double kBeyond = 10.0;  // what rolls off the grid does not fall
  const double half = kBeyond * halfSize;
  auto box = std::make_unique<btBoxShape>(toBullet({half, kHalfThickness, half}));
  btRigidBody& body = addStatic(*scene.world, std::move(box), {0.0, -kHalfThickness, 0.0}, friction);
  body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_DISABLE_VISUALIZE_OBJECT);
  scene.floorHalfSize = halfSize;
}

void addDropFloor(Scene& scene, const DropGridSettings& grid, double size, double radius) {
  const double half = 0.5 * grid.spacing * double(gridColumns(grid.count) - 1) + radius;
  addFloor(scene, 1.5 * half + 8.0 * size);
  const Eigen::Vector3d halfView(half - 0.2 * size, 0.0, half - 0.2 * size);
  const double height = grid.count == 1 ? 2.5 * size : 0.9 * size;  // one body is seen from its start on
  scene.view.box = Eigen::AlignedBox3d(-halfView, halfView + Eigen::Vector3d(0.0, height, 0.0));
  scene.view.direction = {0.4, 0.5, 1.0};
  scene.view.follows = true;
}

std::string addBody(Scene& scene, SharedNetwork network, const SoftBodySettings& settings,
                    const BodyLook& look) {
  const Result<SoftBody*> body = scene.soft->createBody(std::move(network), settings);
  if (body) scene.looks.push_back(look);
  return body.error();
}

Result<SharedNetwork> clothNetwork(double width, double depth, std::uint32_t columns, std::uint32_t rows) {
  ClothSettings shape;
  shape.width = width;
  shape.depth = depth;
  shape.columns = columns;
  shape.rows = rows;
  return buildCloth(shape);
}

BodyLook clothLook(const Eigen::Vector3f& colour, bool checkered) {
  return {colour, true, checkered, Finish::Cloth};
}

btRigidBody& addStatic(Scene& scene, std::unique_ptr<btCollisionShape> shape, const Eigen::Vector3d& centre,
                       double friction, const Eigen::Vector3f& colour) {
  btRigidBody& body = addStatic(*scene.world, std::move(shape), centre, friction);
  scene.rigidLooks.push_back({&body, colour});
  return body;
}

btRigidBody& addBall(Scene& scene, const Eigen::Vector3d& centre, double radius, double mass,
                     const Eigen::Vector3f& colour) {
  auto shape = std::make_unique<btSphereShape>(btScalar(radius));
  btRigidBody& body = addMovable(*scene.world, std::move(shape), mass, centre, 0.5);
  scene.rigidLooks.push_back({&body, colour, Finish::Metal});
  return body;
}

btRigidBody& addBox(Scene& scene, const Eigen::Vector3d& centre, const Eigen::Vector3d& halfExtents,
                    double mass, const Eigen::Vector3f& colour) {
  auto shape = std::make_unique<btBoxShape>(toBullet(halfExtents));
  btRigidBody& body = addMovable(*scene.world, std::move(shape), mass, centre, 0.5);
  scene.rigidLooks.push_back({&body, colour});
  return body;
}

void noteOddSize(Scene& scene, double size) {
  if (size >= 0.01 && size <= 100.0) return;
  char line[160];
  std::snprintf(line, sizeof line, "the bodies are %.3g m across; contacts work best between 0.05 m and 10 m",
                size);
  scene.notes.push_back(line);
}

void apply(const SceneOptions& options, SoftBodySettings& settings) {
  if (options.stiffness) settings.extensionStiffness = settings.compressionStiffness = *options.stiffness;
  if (options.damping) settings.damping = *options.damping;
  if (options.mass) settings.totalMass = *options.mass;
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
