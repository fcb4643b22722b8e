// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <cmath>
#include <memory>

namespace limber::scenes {
namespace {

constexpr std::uint32_t kFlagColumns = 30, kFlagRows = 20;  // cells
constexpr double kFlagWidth = 1.5, kFlagHeight = 1.0;       // m
constexpr double kFlagMass = 0.25;                          // kg
constexpr double kPoleHeight = 2.4, kPoleRadius = 0.03;     // m
constexpr double kFlagSpacing = 2.2;                        // m from pole to pole
constexpr double kWindSeconds = 7.0;                        // then the wind drops
constexpr double kFlagPi = 3.141592653589793;
const Eigen::Vector3d kFlagWind(7.0, 0.0, 1.5);  // m/s
const Eigen::Vector3f kPoleColour(0.45f, 0.47f, 0.52f);

double topOf() { return kPoleHeight - 0.05; }

std::string addFlag(Scene& scene, const SharedNetwork& network, const SceneOptions& options, double z) {
  addBox(scene, {0.0, 0.5 * kPoleHeight, z}, {kPoleRadius, 0.5 * kPoleHeight, kPoleRadius}, 0.0, kPoleColour);
  SoftBodySettings settings;
  settings.totalMass = kFlagMass;
  settings.extensionStiffness = settings.compressionStiffness = 500.0;
  settings.damping = 0.05;
  settings.pointRadius = 0.008;
  settings.flow.linearDrag = 0.5;
  // upright, its first row on top
  settings.rotation = Eigen::AngleAxisd(0.5 * kFlagPi, Eigen::Vector3d::UnitX());
  settings.position = {0.5 * kFlagWidth + 1.5 * kPoleRadius, topOf() - 0.5 * kFlagHeight, z};
  settings.linearVelocity = {0.0, 0.0, Random(options.seed + scene.looks.size()).between(-0.1, 0.1)};
  apply(options, settings);
  const BodyLook look = clothLook(paletteColour(scene.looks.size()));
  if (const std::string reason = addBody(scene, network, settings, look); !reason.empty()) return reason;
  SoftBody& flag = *scene.soft->body(scene.soft->bodyCount() - 1);
  for (std::uint32_t j = 0; j <= kFlagRows; j += 2) flag.pin(j * (kFlagColumns + 1));
  return {};
}

/// m, mean distance of the free edge from the pole.
double reachOf(const SoftBody& flag) {
  double sum = 0.0;
  for (std::uint32_t j = 0; j <= kFlagRows; ++j) {
    const Eigen::Vector3d p = flag.position(j * (kFlagColumns + 1) + kFlagColumns);
    sum += std::hypot(p.x(), p.z() - flag.position(0).z());
  }
  return sum / (kFlagRows + 1);
}

/// Notes how far the flags fly in the wind.
struct FlagWatch {
  double reach = 0.0;  ///< m, largest mean of all flags
  void look(const Scene& scene) {
    double sum = 0.0;
    for (std::size_t i = 0; i < scene.soft->bodyCount(); ++i) sum += reachOf(*scene.soft->body(i));
    reach = std::max(reach, sum / double(scene.soft->bodyCount()));
  }
};

Check checkFlags(const std::shared_ptr<FlagWatch>& watch) {
  return [watch](const Scene& scene) {
    if (watch->reach < 0.75 * kFlagWidth) return std::string("the flags have not flown in the wind");
    for (std::size_t i = 0; i < scene.soft->bodyCount(); ++i)
      if (reachOf(*scene.soft->body(i)) > 0.6 * kFlagWidth)
        return "flag " + std::to_string(i) + " does not hang down after the wind";
    return std::string();
  };
}

void setGusts(Scene& scene) {
  Air air;
  air.wind = kFlagWind;
  air.windAt = gusts(kFlagWind, 3.0, 0.8);
  static_cast<void>(scene.soft->setAir(air));
}

}  // namespace

SceneResult createFlag(const SceneOptions& options) {
  const Result<SharedNetwork> network = clothNetwork(kFlagWidth, kFlagHeight, kFlagColumns, kFlagRows);
  if (!network) return Error{network.error()};
  const std::uint32_t count = options.count.value_or(2);
  const double half = 0.5 * kFlagSpacing * double(count - 1);
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 10.0 + half);
  for (std::uint32_t i = 0; i < count; ++i)
    if (const std::string reason = addFlag(*scene, *network, options, kFlagSpacing * i - half);
        !reason.empty())
      return Error{reason};
  setGusts(*scene);
  const auto watch = std::make_shared<FlagWatch>();
  scene->afterTick = [watch](Scene& now) { watch->look(now); };
  scene->beforeTick = [](Scene& now) {
    if (now.ticks == static_cast<std::int64_t>(kWindSeconds) * kTicksPerSecond)
      static_cast<void>(now.soft->setAir(Air()));
  };
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-0.1, 0, -half - 0.5),
                                        Eigen::Vector3d(kFlagWidth, kPoleHeight, half + 0.5));
  scene->view.direction = {0.5, 0.25, 1.0};
  scene->endChecks = {checkFinite, checkFlags(watch), checkStretch(0.3), checkCalm(0.1)};
  return scene;
}

}  // namespace limber::scenes
