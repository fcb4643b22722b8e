// SPDX-License-Identifier: Zlib
#include "engines/bullet_soft_engines.h"
#include "engines/engine.h"
#include "engines/limber_engine.h"

namespace limber::bench {
namespace {

void addSteppers(std::vector<EngineChoice>& choices) {
  const std::pair<const char*, Stepper> steppers[] = {{"auto", Stepper::Auto},
                                                      {"verlet", Stepper::Verlet},
                                                      {"midpoint", Stepper::ImplicitMidpoint},
                                                      {"newton", Stepper::BandedNewton}};
  for (const auto& [name, stepper] : steppers)
    choices.push_back({"limber", name, [s = stepper](double) { return makeLimberEngine(s); }});
}

void addSoftBodies(std::vector<EngineChoice>& choices) {
  for (const int iterations : {1, 4, 10})
    for (const LinkStiffness stiffness : {LinkStiffness::Full, LinkStiffness::Calibrated}) {
      const char* setting = stiffness == LinkStiffness::Full ? "kLST 1" : "kLST from k";
      choices.push_back({"btSoftBody", std::to_string(iterations) + " it " + setting,
                         [=](double dt) { return makeSoftBodyEngine(dt, iterations, stiffness); }});
    }
}

}  // namespace

double asleepShare(btDiscreteDynamicsWorld& world) {
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  int movable = 0, asleep = 0;
  for (int i = 0; i < objects.size(); ++i) {
    // Limber's object that marks the step boundary is awake and has no contacts
    if (objects[i]->isStaticObject() || !objects[i]->hasContactResponse()) continue;
    ++movable;
    asleep += !objects[i]->isActive();
  }
  return movable ? static_cast<double>(asleep) / movable : 0.0;
}

std::vector<EngineChoice> allEngines() {
  std::vector<EngineChoice> choices;
  addSteppers(choices);
  addSoftBodies(choices);
  choices.push_back({"btDeformable", "implicit", [](double) { return makeDeformableEngine(true); }});
  choices.push_back({"btDeformable", "explicit", [](double) { return makeDeformableEngine(false); }});
  return choices;
}

}  // namespace limber::bench
