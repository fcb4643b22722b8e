// SPDX-License-Identifier: Zlib
#include "scaling/subject.h"

#include "engines/engine.h"
#include "scenes/scene_list.h"

#include <limber/contacts.h>

#include <algorithm>
#include <stdexcept>

namespace limber::bench {
namespace {

btDiscreteDynamicsWorld& worldOf(const Subject& subject) {
  return subject.scene ? subject.scene->world->dynamics : subject.bare->world.dynamics;
}

/// A body asleep costs next to nothing: what is to be measured must stay awake.
void keepAwake(btDiscreteDynamicsWorld& world) {
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    if (!objects[i]->isStaticObject()) objects[i]->forceActivationState(DISABLE_DEACTIVATION);
  }
}

std::unique_ptr<scenes::Scene> makeCubes(std::uint32_t count) {
  scenes::SceneOptions options;
  options.count = count;
  scenes::SceneResult scene = scenes::createCubes(options);
  if (!scene) throw std::runtime_error(scene.error());
  return std::move(*scene);
}

void addRenderer(Subject& subject, const ScalingOptions& options, Mode mode) {
  demo::DemoOptions look;
  look.width = options.width;
  look.height = options.height;
  look.mode = mode == Mode::Wireframe ? demo::PictureMode::Wireframe : demo::PictureMode::Shaded;
  subject.renderer = std::make_unique<demo::SceneRenderer>(*subject.scene, look);
  draw(subject);  // the first frame compiles shaders
}

}  // namespace

Subject makeSubject(const ScalingOptions& options, Mode mode, std::uint32_t count) {
  Subject subject;
  subject.scene = makeCubes(count);
  subject.bodies = count;
  subject.points = scenes::pointCount(*subject.scene);
  if (mode == Mode::Bare) {
    subject.bare = makeBareSpheres(*subject.scene);
    subject.scene.reset();
  } else {
    subject.springs = scenes::springCount(*subject.scene);
  }
  if (!options.sleep) keepAwake(worldOf(subject));
  if (isDrawn(mode)) addRenderer(subject, options, mode);
  return subject;
}

WorkTime tick(Subject& subject) {
  constexpr btScalar kTick = btScalar(1) / btScalar(kTicksPerSecond);
  btDiscreteDynamicsWorld& world = worldOf(subject);
  const Stopwatch watch;
  world.stepSimulation(kTick, 0, kTick);
  return watch.time();
}

double draw(Subject& subject) {
  const Stopwatch watch;
  subject.renderer->draw({}, subject.image);
  return watch.time().wallMs - subject.renderer->lastFrame().readMs;
}

TickProfile ownPart(const Subject& subject) {
  return subject.scene ? subject.scene->soft->profile() : TickProfile();
}

std::size_t contactCount(const Subject& subject) {
  btDispatcher& dispatcher = *worldOf(subject).getDispatcher();
  std::size_t count = 0;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    if (dispatcher.getManifoldByIndexInternal(i)->getNumContacts() > 0) ++count;
  }
  for (std::size_t i = 0; subject.scene && i < subject.scene->soft->bodyCount(); ++i)
    if (subject.scene->soft->body(i)->surfaceObject())
      count += subject.scene->soft->body(i)->contacts().size();
  return count;
}

double asleepShare(const Subject& subject) { return asleepShare(worldOf(subject)); }

std::uint64_t stateHash(const Subject& subject) {
  return subject.scene ? scenes::stateHash(*subject.scene) : stateHash(*subject.bare);
}

}  // namespace limber::bench
