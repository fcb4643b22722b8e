// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene_list.h"

#include <cmath>

namespace limber::scenes {
namespace {

constexpr double kEdge = 1.0;          // m
constexpr double kGap = 2e-3;          // m, at first
constexpr double kStartOffset = 0.02;  // m, largest initial offset from the axis
constexpr double kMinDistance = 0.85;  // m between the centres of two cubes: the lowest carries nine others
constexpr double kMaxOffset = 0.3;     // m, largest final offset from the lowest one
constexpr double kMaxDepth = 5e-3;     // m, allowed penetration of cubes

/// Checks that each cube is above the next lower one and over the lowest.
std::string checkStands(const Scene& scene) {
  const Eigen::Vector3d lowest = middleOf(*scene.soft->body(0));
  Eigen::Vector3d below = lowest;
  for (std::size_t b = 1; b < scene.soft->bodyCount(); ++b) {
    const Eigen::Vector3d middle = middleOf(*scene.soft->body(b));
    const std::string name = "cube " + std::to_string(b);
    if (middle.y() - below.y() < kMinDistance * kEdge) return name + " does not stand on the one below";
    if (std::hypot(middle.x() - lowest.x(), middle.z() - lowest.z()) > kMaxOffset)
      return name + " has slipped aside";
    below = middle;
  }
  return {};
}

SoftBodySettings cubeSettings(const SceneOptions& options) {
  SoftBodySettings settings;
  // stiff enough that the load is far below that at which a column of ten buckles: near it, the column would
  // sway for minutes
  settings.extensionStiffness = settings.compressionStiffness = 5000.0;
  settings.damping = 20.0;
  settings.pointRadius = kThinRadius;
  settings.friction = 0.7;
  apply(options, settings);
  return settings;
}

}  // namespace

SceneResult createStack(const SceneOptions& options) {
  const Result<SharedNetwork> cube = readNetwork(LIMBER_MESH_DIR "/cube.obj");
  if (!cube) return Error{cube.error()};
  const std::uint32_t count = options.count.value_or(10);
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 12.0);
  Random random(options.seed);
  SoftBodySettings settings = cubeSettings(options);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double height = kThinRadius + 0.5 * kEdge + (kEdge + 2.0 * kThinRadius + kGap) * i;
    settings.position = {random.between(-kStartOffset, kStartOffset), height,
                         random.between(-kStartOffset, kStartOffset)};
    settings.rotation = Eigen::AngleAxisd(random.between(-0.1, 0.1), Eigen::Vector3d::UnitY());
    BodyLook look;
    look.colour = paletteColour(i);
    const std::string reason = addBody(*scene, *cube, settings, look);
    if (!reason.empty()) return Error{reason};
  }
  scene->view.box =
      Eigen::AlignedBox3d(Eigen::Vector3d(-1, 0, -1), Eigen::Vector3d(1, 1.05 * kEdge * count, 1));
  scene->endChecks = {checkFinite,     checkAboveFloor,  checkStands, checkSoftApart(kMaxDepth),
                      checkCalm(0.02), checkShapes(0.05)};
  return scene;
}

}  // namespace limber::scenes
