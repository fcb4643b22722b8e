// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"

#include <cstdint>
#include <vector>

namespace limber::scenes {

struct SceneEntry {
  const char* name;
  const char* about;  ///< one line
  double seconds;     ///< time after which all is at rest with the scene's defaults
  bool takesScale;    ///< SceneOptions::scale has a meaning here
  SceneResult (*create)(const SceneOptions&);
  std::uint32_t bodies = 0;  ///< 0: SceneOptions::count has a meaning here; else it always has as many
};

const std::vector<SceneEntry>& sceneList();

/// Returns nullptr if there is no scene of that name.
const SceneEntry* findScene(const std::string& name);

SceneResult createCubes(const SceneOptions& options);
SceneResult createCollapse(const SceneOptions& options);
SceneResult createMeshDrop(const SceneOptions& options);
SceneResult createRope(const SceneOptions& options);
SceneResult createCloth(const SceneOptions& options);
SceneResult createMarble(const SceneOptions& options);
SceneResult createPile(const SceneOptions& options);
SceneResult createStack(const SceneOptions& options);
SceneResult createTower(const SceneOptions& options);
SceneResult createCurtain(const SceneOptions& options);
SceneResult createFlag(const SceneOptions& options);
SceneResult createPool(const SceneOptions& options);
SceneResult createDent(const SceneOptions& options);
SceneResult createTear(const SceneOptions& options);
SceneResult createBridge(const SceneOptions& options);
SceneResult createWobble(const SceneOptions& options);
SceneResult createStiffness(const SceneOptions& options);
SceneResult createBalloon(const SceneOptions& options);
SceneResult createStatue(const SceneOptions& options);
SceneResult createSkeleton(const SceneOptions& options);
SceneResult createCut(const SceneOptions& options);

}  // namespace limber::scenes
