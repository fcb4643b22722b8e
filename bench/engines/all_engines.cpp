// SPDX-License-Identifier: Zlib
#include "engines/engine.h"
#include "engines/engines.h"

namespace limber::bench {
namespace {

void addSteppers(std::vector<EngineChoice>& choices) {
  const std::pair<const char*, Stepper> steppers[] = {{"default", Stepper::Auto},
                                                      {"Verlet", Stepper::Verlet},
                                                      {"implicit midpoint", Stepper::ImplicitMidpoint},
                                                      {"banded Newton", Stepper::BandedNewton}};
  for (const auto& [name, stepper] : steppers)
    choices.push_back({"Limber", name, [s = stepper](const EngineUse&) { return makeLimberEngine(s); }});
}

void addSoftBodies(std::vector<EngineChoice>& choices) {
  for (const int iterations : {1, 4, 10})
    for (const LinkStiffness stiffness : {LinkStiffness::Full, LinkStiffness::Calibrated}) {
      const char* links = stiffness == LinkStiffness::Full ? "full stiffness" : "calibrated";
      choices.push_back({"btSoftBody", iterationsText(iterations) + ", " + links, [=](const EngineUse& use) {
                           return makeSoftBodyEngine(use.dt, iterations, stiffness);
                         }});
    }
}

const std::vector<Key>& engineKeys() {
  static const std::vector<Key> kKeys = {
      {"stepper", "Limber's stepper", 0, 0, {"auto", "verlet", "midpoint", "newton"}},
      {"minSubsteps", "Limber's smallest number of substeps", 1, 10000},
      {"maxSubsteps", "Limber's largest number of substeps, 0: no limit", 0, 10000},
      {"periodTolerance", "Limber's tolerance of the fastest period", 1e-8, 1},
      {"relativeTolerance", "Limber's tolerance of the error, in sizes per second", 0, 1e6},
      {"collision", "Limber's kind of collision", 0, 0, {"surface", "points"}},
      {"iterations", "btSoftBody's iterations", 1, 1000},
      {"hardness", "btSoftBody's hardness of contacts, kKHR", 0, 1},
      {"links", "btSoftBody's links, see LinkStiffness", 0, 0, {"full", "calibrated"}}};
  return kKeys;
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

std::string iterationsText(int count) {
  return std::to_string(count) + (count == 1 ? " iteration" : " iterations");
}

std::vector<EngineChoice> allEngines() {
  std::vector<EngineChoice> choices;
  addSteppers(choices);
  addSoftBodies(choices);
  choices.push_back(
      {"btDeformable", "implicit", [](const EngineUse&) { return makeDeformableEngine(true); }});
  choices.push_back(
      {"btDeformable", "explicit", [](const EngineUse&) { return makeDeformableEngine(false); }});
  return choices;
}

std::vector<EngineChoice> wantedEngines(const std::vector<EngineChoice>& engines, const Options& options) {
  std::vector<EngineChoice> wanted;
  for (const EngineChoice& choice : engines) {
    if (!options.wantsEngine(choice.engine, choice.setting)) continue;
    wanted.push_back(choice);
    wanted.back().make = [make = choice.make, sets = options.sets](const EngineUse& use) {
      std::unique_ptr<Engine> engine = make(use);
      for (const auto& [key, value] : sets) engine->set(key, value);
      return engine;
    };
  }
  return wanted;
}

std::vector<Key> withEngineKeys(std::vector<Key> keys) {
  keys.insert(keys.begin(), engineKeys().begin(), engineKeys().end());
  return keys;
}

}  // namespace limber::bench
