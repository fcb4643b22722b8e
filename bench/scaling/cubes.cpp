// SPDX-License-Identifier: Zlib
#include "scaling/cubes.h"

#include "engines/engine.h"
#include "scenes/scene_list.h"

#include <limber/contacts.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace limber::bench {

// --- loose spheres ---

namespace {

/// Without inertia, as the point masses of soft bodies are.
std::unique_ptr<btRigidBody> sphereLike(const btRigidBody& point, btSphereShape& shape) {
  btRigidBody::btRigidBodyConstructionInfo info(point.getMass(), nullptr, &shape, btVector3(0, 0, 0));
  info.m_startWorldTransform = point.getWorldTransform();
  info.m_friction = point.getFriction();
  auto sphere = std::make_unique<btRigidBody>(info);
  sphere->setAngularFactor(btScalar(0));
  sphere->setFlags(sphere->getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  return sphere;
}

void addFloorOf(const scenes::Scene& scene, scenes::SceneWorld& world) {
  const btRigidBody& floor = *scene.world->statics.front();
  const auto& box = static_cast<const btBoxShape&>(*floor.getCollisionShape());
  const btVector3 centre = floor.getWorldTransform().getOrigin();
  scenes::addStatic(world, std::make_unique<btBoxShape>(box.getHalfExtentsWithMargin()),
                    {double(centre.x()), double(centre.y()), double(centre.z())},
                    double(floor.getFriction()));
}

void addToHash(std::uint64_t& hash, const btVector3& v) {
  for (const btScalar value : {v.x(), v.y(), v.z()}) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof value);
    hash = (hash ^ bits) * 1099511628211ull;  // FNV-1a
  }
}

/// A sphere of the same radius, mass and friction for each point mass of a scene of like bodies, where that
/// point is, over the same floor. Nothing holds the upper ones up, so all of them come to lie on the floor.
std::unique_ptr<BareSpheres> makeBareSpheres(const scenes::Scene& scene) {
  auto bare = std::make_unique<BareSpheres>();
  addFloorOf(scene, bare->world);
  const SoftBody& first = *scene.soft->body(0);
  bare->shape =
      std::make_unique<btSphereShape>(static_cast<btScalar>(pointRadius(first.network(), first.settings())));
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const SoftBody& body = *scene.soft->body(b);
    for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
      bare->spheres.push_back(sphereLike(*body.point(i), *bare->shape));
      bare->world.dynamics.addRigidBody(bare->spheres.back().get());
    }
  }
  return bare;
}

std::uint64_t stateHash(const BareSpheres& bare) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const auto& sphere : bare.spheres) {
    addToHash(hash, sphere->getWorldTransform().getOrigin());
    addToHash(hash, sphere->getLinearVelocity());
  }
  return hash;
}

// --- cubes ---

btDiscreteDynamicsWorld& worldOf(const Cubes& cubes) {
  return cubes.scene ? cubes.scene->world->dynamics : cubes.bare->world.dynamics;
}

/// A body asleep costs next to nothing: what is to be measured must stay awake.
void keepAwake(btDiscreteDynamicsWorld& world) {
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    if (!objects[i]->isStaticObject()) objects[i]->forceActivationState(DISABLE_DEACTIVATION);
  }
}

std::unique_ptr<scenes::Scene> makeScene(std::uint32_t count) {
  scenes::SceneOptions options;
  options.count = count;
  scenes::SceneResult scene = scenes::createCubes(options);
  if (!scene) throw std::runtime_error(scene.error());
  return std::move(*scene);
}

void addRenderer(Cubes& cubes, const ScalingOptions& options, Mode mode) {
  demo::DemoOptions look;
  look.width = options.width;
  look.height = options.height;
  look.mode = mode == Mode::Wireframe ? demo::PictureMode::Wireframe : demo::PictureMode::Shaded;
  cubes.renderer = std::make_unique<demo::SceneRenderer>(*cubes.scene, look);
  draw(cubes);  // the first frame compiles shaders
}

}  // namespace

Cubes makeCubes(const ScalingOptions& options, Mode mode, std::uint32_t count) {
  Cubes cubes;
  cubes.scene = makeScene(count);
  cubes.bodies = count;
  cubes.points = scenes::pointCount(*cubes.scene);
  if (mode == Mode::Bare) {
    cubes.bare = makeBareSpheres(*cubes.scene);
    cubes.scene.reset();
  } else {
    cubes.springs = scenes::springCount(*cubes.scene);
  }
  if (!options.sleep) keepAwake(worldOf(cubes));
  if (isDrawn(mode)) addRenderer(cubes, options, mode);
  return cubes;
}

WorkTime tick(Cubes& cubes) {
  constexpr btScalar kTick = btScalar(1) / btScalar(kTicksPerSecond);
  btDiscreteDynamicsWorld& world = worldOf(cubes);
  const Stopwatch watch;
  world.stepSimulation(kTick, 0, kTick);
  return watch.time();
}

double draw(Cubes& cubes) {
  const Stopwatch watch;
  cubes.renderer->draw({}, cubes.image);
  return watch.time().wallMs - cubes.renderer->lastFrame().readMs;
}

TickProfile ownPart(const Cubes& cubes) { return cubes.scene ? cubes.scene->soft->profile() : TickProfile(); }

std::size_t contactCount(const Cubes& cubes) {
  btDispatcher& dispatcher = *worldOf(cubes).getDispatcher();
  std::size_t count = 0;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    if (dispatcher.getManifoldByIndexInternal(i)->getNumContacts() > 0) ++count;
  }
  for (std::size_t i = 0; cubes.scene && i < cubes.scene->soft->bodyCount(); ++i)
    if (cubes.scene->soft->body(i)->surfaceObject()) count += cubes.scene->soft->body(i)->contacts().size();
  return count;
}

double asleepShare(const Cubes& cubes) { return asleepShare(worldOf(cubes)); }

std::uint64_t stateHash(const Cubes& cubes) {
  return cubes.scene ? scenes::stateHash(*cubes.scene) : stateHash(*cubes.bare);
}

}  // namespace limber::bench
