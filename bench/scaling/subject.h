// SPDX-License-Identifier: Zlib
#pragma once

#include "clocks.h"
#include "scaling/bare_spheres.h"
#include "scaling/scaling_options.h"
#include "scene_renderer.h"

#include <memory>

namespace limber::bench {

constexpr int kTicksPerSecond = 50;

/// What is measured: soft cubes, drawn or not, or loose spheres.
struct Subject {
  std::uint32_t bodies = 0;
  std::size_t points = 0, springs = 0;
  std::unique_ptr<scenes::Scene> scene;           ///< the cubes, or nullptr
  std::unique_ptr<BareSpheres> bare;              ///< the spheres, or nullptr
  std::unique_ptr<demo::SceneRenderer> renderer;  ///< nullptr: no pictures
  render::Image image;
};

/// Throws std::runtime_error with the reason, as when there is no OpenGL.
Subject makeSubject(const ScalingOptions& options, Mode mode, std::uint32_t count);

/// Steps the world by 1/50 s.
WorkTime tick(Subject& subject);

/// Draws a frame. Returns milliseconds from reading positions until the GPU is done (glFinish), without
/// copying the picture to main memory, which a window does not need.
double draw(Subject& subject);

/// The plugin's part of the last tick; zeros for spheres.
TickProfile ownPart(const Subject& subject);

std::size_t contactCount(const Subject& subject);
double asleepShare(const Subject& subject);
std::uint64_t stateHash(const Subject& subject);

}  // namespace limber::bench
