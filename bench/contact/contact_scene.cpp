// SPDX-License-Identifier: Zlib
#include "contact/contact_scene.h"

namespace limber::bench {

const char* nameOf(Role role) {
  const char* const names[] = {"airborne", "landing", "rest", "asleep", "cloth", "pile", "dense"};
  return names[static_cast<int>(role)];
}

std::vector<ContactScene> allContactScenes(bool quick) {
  std::vector<ContactScene> scenes;
  addCubeScenes(scenes, quick);
  addLargeBodies(scenes, quick);
  addPile(scenes, quick);
  return scenes;
}

}  // namespace limber::bench
