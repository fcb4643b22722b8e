// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene_list.h"

#include <gtest/gtest.h>

namespace limber::scenes {

inline std::unique_ptr<Scene> created(const char* name, std::uint32_t count) {
  SceneOptions options;
  options.count = count;
  SceneResult scene = findScene(name)->create(options);
  EXPECT_TRUE(scene) << scene.error();
  return std::move(*scene);
}

}  // namespace limber::scenes
