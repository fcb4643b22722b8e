// SPDX-License-Identifier: Zlib
#pragma once

#include "scene/scene.h"
#include "scene_renderer.h"
#include "scenes/scene.h"
#include "timing.h"

#include <cstdint>
#include <memory>

namespace limber::bench {

constexpr int kTicksPerSecond = 50;

enum class Mode {
  Bare,  ///< as many loose Bullet spheres as the cubes have points: no springs, no plugin, no pictures
  None,  ///< soft cubes without a renderer
  Shaded,
  Wireframe
};
inline bool isDrawn(Mode mode) { return mode == Mode::Shaded || mode == Mode::Wireframe; }

struct ScalingOptions {
  double seconds = 10.0;  ///< simulated, per run
  std::uint32_t maxBodies = 65536;
  int width = 1280, height = 720;  ///< pixels of a frame
  int repeats = 3;                 ///< runs per row, where a run is short
  double minutes = 12.0;           ///< wall time after which no more rows are begun
  bool sleep = false;              ///< bodies at rest may fall asleep
};

/// What is measured: soft cubes, drawn or not, or loose spheres.
struct Cubes {
  std::uint32_t bodies = 0;
  std::size_t points = 0, springs = 0;
  std::unique_ptr<scenes::Scene> scene;           ///< the cubes, or nullptr
  RigidBodies rigid;                              ///< the floor of the spheres, which outlives their world
  std::unique_ptr<Engine> spheres;                ///< or nullptr
  std::unique_ptr<demo::SceneRenderer> renderer;  ///< nullptr: no pictures
  render::Image image;
};

/// Throws std::runtime_error with the reason, as when there is no OpenGL.
Cubes makeCubes(const ScalingOptions& options, Mode mode, std::uint32_t count);

/// Steps the world by 1/50 s.
WorkTime tick(Cubes& cubes);

/// Draws a frame. Returns milliseconds from reading positions until the GPU is done (glFinish), without
/// copying the picture to main memory, which a window does not need.
double draw(Cubes& cubes);

/// The plugin's part of the last tick; zeros for spheres.
TickProfile ownPart(const Cubes& cubes);

std::size_t contactCount(const Cubes& cubes);
double asleepShare(const Cubes& cubes);
std::uint64_t stateHash(const Cubes& cubes);

}  // namespace limber::bench
