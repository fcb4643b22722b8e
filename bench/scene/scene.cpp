// SPDX-License-Identifier: Zlib
#include "scene/scene.h"

namespace limber::bench {

std::unique_ptr<Engine> open(const Scenario& scenario, const EngineChoice& choice, const EngineUse& use,
                             RigidBodies& rigid) {
  std::unique_ptr<Engine> engine = choice.make(use);
  engine->world().setGravity(toBullet(scenario.gravity));
  if (scenario.addRigidBodies) scenario.addRigidBodies(rigid, engine->world());
  for (const BodySetup& body : scenario.bodies) engine->addBody(body);
  return engine;
}

}  // namespace limber::bench
