// SPDX-License-Identifier: Zlib
#include "scenes/scene_list.h"

namespace limber::scenes {

const std::vector<SceneEntry>& sceneList() {
  static const std::vector<SceneEntry> kScenes = {
      {"cubes", "64 soft cubes fall onto a floor, bounce and come to rest", 10.0, true, &createCubes},
      {"collapse", "the paper's cubes fold up, braced ones beside them do not", 10.0, false, &createCollapse},
      {"mesh", "9 bodies of any mesh you name with --mesh fall onto a floor", 8.0, true, &createMeshDrop},
      {"rope", "ropes fall across a box and hang down on both sides", 8.0, false, &createRope},
      {"cloth", "a cloth falls onto a sphere and drapes it", 6.0, false, &createCloth},
      {"marble", "hard marbles are dropped on and shot at soft cubes, whose faces hold them", 6.0, false,
       &createMarble},
      {"pile", "48 soft bodies of several shapes fall into a bin", 10.0, false, &createPile},
      {"stack", "ten soft cubes stand on one another", 8.0, false, &createStack},
      {"tower-of-jelly", "soft blocks and rigid plates alternate; the top is nudged", 10.0, false,
       &createTower},
      {"curtain", "balls and a box push a curtain that hangs from its upper edge", 10.0, false,
       &createCurtain},
      {"flag", "flags fly in gusts of wind, which then drops", 18.0, false, &createFlag},
      {"pool", "soft boxes of four densities fall into water; three float at their draughts", 12.0, false,
       &createPool},
      {"dent", "balls press an elastic block and two that yield, which keep their dents", 5.0, false,
       &createDent, 3},
      {"tear", "a heavy ball falls on a stretched sheet and tears it", 10.0, false, &createTear, 1},
      {"cut", "a blade cuts a hanging cloth, two planes cut a block of jelly", 10.0, false, &createCut, 2},
      {"wobble", "a jelly wobbles on a dish that is shaken", 5.0, false, &createWobble, 1},
      {"stiffness", "balls of five stiffnesses, each four times the one before, fall side by side", 8.0,
       false, &createStiffness, 5},
      {"balloon", "two plates squeeze a balloon and let it go", 9.0, false, &createBalloon, 1},
      {"bridge", "a car drives over a bridge of cloth", 8.0, false, &createBridge, 1},
      {"statue", "a cloth falls over the statue of a head", 5.0, false, &createStatue, 1},
      {"skeleton", "a dancer turns in a dress that the bones carry", 9.0, false, &createSkeleton},
  };
  return kScenes;
}

const SceneEntry* findScene(const std::string& name) {
  for (const SceneEntry& entry : sceneList()) {
    if (entry.name == name) return &entry;
  }
  return nullptr;
}

}  // namespace limber::scenes
