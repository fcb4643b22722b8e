// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <algorithm>
#include <cmath>

namespace limber::scenes {
namespace {

constexpr double kPoolHalf = 2.2, kPoolDepth = 1.2;                          // m, of the basin
constexpr double kPoolWall = 0.08;                                           // m, half thickness
constexpr double kFloatSize = 0.5;                                           // m, a side of a box
constexpr double kFloatVolume = kFloatSize * kFloatSize * 0.5 * kFloatSize;  // m^3
constexpr double kLevel = 0.9;                                               // m, of the water
const Eigen::Vector3f kBasinColour(0.80f, 0.84f, 0.88f), kWetColour(0.30f, 0.52f, 0.66f);
/// kg/m^3: the last of each four sinks.
constexpr double kDensities[] = {250.0, 500.0, 800.0, 1500.0};

double densityOf(std::size_t body) { return kDensities[body % 4]; }

/// Adds a wall, dark up to the water's level.
void addWall(Scene& scene, double x, double z, double halfX, double halfZ) {
  const double wet = 0.5 * kLevel, dry = 0.5 * (kPoolDepth - kLevel);
  addBox(scene, {x, wet, z}, {halfX, wet, halfZ}, 0.0, kWetColour);
  addBox(scene, {x, kLevel + dry, z}, {halfX, dry, halfZ}, 0.0, kBasinColour);
}

void addBasin(Scene& scene) {
  const double at = kPoolHalf + kPoolWall, length = kPoolHalf + 2.0 * kPoolWall;
  addWall(scene, -at, 0.0, kPoolWall, length);
  addWall(scene, at, 0.0, kPoolWall, length);
  addWall(scene, 0.0, -at, kPoolHalf, kPoolWall);
  // the front wall is low, so that the view is clear
  addBox(scene, {0.0, 0.05, at}, {kPoolHalf, 0.05, kPoolWall}, 0.0, kWetColour);
}

std::string addFloats(Scene& scene, const SharedNetwork& network, const SceneOptions& options) {
  Random random(options.seed);
  const std::vector<Placement> places = dropGrid({options.count.value_or(12), 1.05, 1.3, 1.9}, random);
  for (std::size_t i = 0; i < places.size(); ++i) {
    SoftBodySettings settings;
    settings.position = places[i].centre;
    settings.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(random.between(-0.3, 0.3), Eigen::Vector3d::UnitX()) *
                           Eigen::AngleAxisd(random.between(0.0, 3.0), Eigen::Vector3d::UnitY()));
    settings.scale = Eigen::Vector3d(kFloatSize, 0.5 * kFloatSize, kFloatSize);
    settings.totalMass = densityOf(i) * kFloatVolume;
    settings.extensionStiffness = settings.compressionStiffness = 4e4;
    settings.damping = 60.0;
    apply(options, settings);
    const BodyLook look{paletteColour(i % 4)};
    if (const std::string reason = addBody(scene, network, settings, look); !reason.empty()) return reason;
  }
  return {};
}

/// Checks that light boxes float at their draught and heavy ones lie on the floor.
Check checkDraughts() {
  return [](const Scene& scene) {
    for (std::size_t i = 0; i < scene.soft->bodyCount(); ++i) {
      const double height = middleOf(*scene.soft->body(i)).y(), thickness = 0.5 * kFloatSize;
      const double share = densityOf(i) / 1000.0;
      const double expected = share < 1.0 ? kLevel + 0.5 * thickness - share * thickness : 0.5 * thickness;
      if (std::abs(height - expected) > 0.04)
        return "box " + std::to_string(i) + " is at " + std::to_string(height) + " m instead of " +
               std::to_string(expected) + " m";
    }
    return std::string();
  };
}

}  // namespace

SceneResult createPool(const SceneOptions& options) {
  const Result<SharedNetwork> network = cubeNetwork();
  if (!network) return Error{network.error()};
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 12.0);
  addBasin(*scene);
  if (const std::string reason = addFloats(*scene, *network, options); !reason.empty()) return Error{reason};
  Water water;
  water.level = kLevel;
  if (const Result<void> set = scene->soft->setWater(water); !set) return Error{set.error()};
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-kPoolHalf, 0, -kPoolHalf),
                                        Eigen::Vector3d(kPoolHalf, 1.6, kPoolHalf));
  scene->view.direction = {0.25, 0.55, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkDraughts(), checkShapes(0.05), checkCalm(0.05)};
  return scene;
}

}  // namespace limber::scenes
