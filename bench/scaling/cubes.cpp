// SPDX-License-Identifier: Zlib
#include "scaling/cubes.h"

#include "engines/engines.h"
#include "scene/rigid_bodies.h"
#include "scenes/scene_list.h"

#include <limber/contacts.h>

#include <algorithm>
#include <stdexcept>

namespace limber::bench {

namespace {

/// Adds a sphere of the same radius, mass and friction for each point mass, over the same floor. Nothing
/// supports the upper ones, so all of them come to lie on the floor.
void addSpheres(const scenes::Scene& scene, Cubes& cubes) {
  const btRigidBody& floor = *scene.world->statics.front();
  const auto& box = static_cast<const btBoxShape&>(*floor.getCollisionShape());
  cubes.spheres = makeBareEngine();
  cubes.spheres->world().setGravity(scene.world->dynamics.getGravity());
  addBox(cubes.rigid, cubes.spheres->world(), fromBullet(box.getHalfExtentsWithMargin()), 0,
         fromBullet(floor.getWorldTransform().getOrigin()), double(floor.getFriction()));
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const SoftBody& body = *scene.soft->body(b);
    BodySetup setup;
    setup.network = body.sharedNetwork();
    setup.settings = body.settings();
    setup.maySleep = true;  // see keepAwake()
    cubes.spheres->addBody(setup);
  }
}

btDiscreteDynamicsWorld& worldOf(const Cubes& cubes) {
  return cubes.scene ? cubes.scene->world->dynamics : cubes.spheres->world();
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
    addSpheres(*cubes.scene, cubes);
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
  if (cubes.scene) return scenes::stateHash(*cubes.scene);
  std::uint64_t hash = kHashStart;
  for (std::size_t body = 0; body < cubes.bodies; ++body) {
    addToHash(hash, cubes.spheres->positions(body));
    addToHash(hash, cubes.spheres->velocities(body));
  }
  return hash;
}

}  // namespace limber::bench
