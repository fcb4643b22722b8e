// SPDX-License-Identifier: Zlib
#include "scenes/scene_list.h"

namespace limber::scenes {

const std::vector<SceneEntry>& sceneList() {
  static const std::vector<SceneEntry> kScenes = {
      {"cubes", "64 soft cubes fall onto a floor, bounce and come to rest", 10.0, true, &createCubes},
      {"collapse", "the paper's cubes fold up, braced ones beside them do not", 10.0, false, &createCollapse},
      {"mesh", "9 bodies of any mesh you name with --mesh fall onto a floor", 8.0, true, &createMeshDrop},
      {"rope", "ropes fall across a box and hang down on both sides", 5.0, false, &createRope},
      {"cloth", "a cloth falls onto a sphere and drapes it", 6.0, false, &createCloth},
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
