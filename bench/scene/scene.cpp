// SPDX-License-Identifier: Zlib
#include "scene/scene.h"

#include <cstring>

namespace limber::bench {

std::unique_ptr<Engine> open(const Scenario& scenario, const EngineChoice& choice, const EngineUse& use,
                             RigidBodies& rigid) {
  std::unique_ptr<Engine> engine = choice.make(use);
  engine->world().setGravity(toBullet(scenario.gravity));
  if (scenario.addRigidBodies) scenario.addRigidBodies(rigid, engine->world());
  for (const BodySetup& body : scenario.bodies) engine->addBody(body);
  return engine;
}

void addToHash(std::uint64_t& hash, const Eigen::Matrix3Xd& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, values.data() + i, sizeof bits);
    hash = (hash ^ bits) * 1099511628211ull;
  }
}

}  // namespace limber::bench
