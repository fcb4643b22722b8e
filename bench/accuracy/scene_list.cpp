// SPDX-License-Identifier: Zlib
#include "accuracy/scene_list.h"

#include <utility>

namespace limber::bench {

BodySetup bodyOf(SharedNetwork network, double mass, double stiffness, double damping) {
  BodySetup body;
  body.network = std::move(network);
  body.settings.totalMass = mass;
  body.settings.extensionStiffness = body.settings.compressionStiffness = stiffness;
  body.settings.damping = damping;
  return body;
}

std::vector<Scene> allScenes(bool quick) {
  std::vector<Scene> scenes;
  addOscillators(scenes, quick);
  addChains(scenes, quick);
  addWaves(scenes, quick);
  addFreeShapes(scenes, quick);
  addImpacts(scenes, quick);
  addResting(scenes, quick);
  addRigidPartners(scenes, quick);
  return scenes;
}

}  // namespace limber::bench
