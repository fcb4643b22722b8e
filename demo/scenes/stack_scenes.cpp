// SPDX-License-Identifier: Zlib
// A stack of soft cubes, and a tower of soft blocks and rigid plates.

#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <cmath>

namespace limber::scenes {

// --- stack -------------------------------------------------------------------------------------------------

namespace {

constexpr double kEdge = 1.0;          // m
constexpr double kGap = 2e-3;          // m, at first
constexpr double kStartOffset = 0.02;  // m, largest initial offset from the axis
constexpr double kMinDistance = 0.85;  // m between the centres of two cubes: the lowest carries nine others
constexpr double kMaxOffset = 0.3;     // m, largest final offset from the lowest one
constexpr double kMaxDepth = 5e-3;     // m, allowed penetration

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
  const Result<SharedNetwork> cube = cubeNetwork();
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
    const std::string reason = addBody(*scene, *cube, settings, {paletteColour(i)});
    if (!reason.empty()) return Error{reason};
  }
  scene->view.box =
      Eigen::AlignedBox3d(Eigen::Vector3d(-1, 0, -1), Eigen::Vector3d(1, 1.05 * kEdge * count, 1));
  scene->endChecks = {checkFinite,     checkAboveFloor,  checkStands, checkSoftApart(kMaxDepth),
                      checkCalm(0.02), checkShapes(0.05)};
  return scene;
}

// --- tower -------------------------------------------------------------------------------------------------

namespace {

constexpr double kWidth = 0.8, kBlock = 0.4;            // m, of a block of jelly
constexpr double kPlateHalf = 0.5, kPlateThick = 0.04;  // m, half extents of a plate
constexpr double kPlateMass = 0.8;                      // kg
constexpr double kFloorHeight = kBlock + 2.0 * kPlateThick + 2.0 * (kThinRadius + kGap);  // m, of a storey
constexpr std::int64_t kNudgeTick = 4 * kTicksPerSecond;
constexpr double kNudge = 0.4;               // N s, at the topmost plate
constexpr double kMaxSway = 0.2;             // m, largest final offset from the lowest block
constexpr double kMinHeightFraction = 0.75;  // smallest fraction of a storey's height at the end
constexpr double kMinTiltCosine = 0.98;      // smallest cosine of a plate's tilt: 11 degrees
const Eigen::Vector3f kPlateColour(0.45f, 0.47f, 0.52f);

/// Checks that blocks and plates still alternate from the floor up, at their initial positions except for
/// sagging.
std::string checkTower(const Scene& scene) {
  const Eigen::Vector3d lowest = middleOf(*scene.soft->body(0));
  for (std::size_t i = 0; i < scene.soft->bodyCount(); ++i) {
    const btTransform& plate = scene.world->movables[i]->getWorldTransform();
    const Eigen::Vector3d at = fromBullet(plate.getOrigin()), block = middleOf(*scene.soft->body(i));
    const std::string name = "storey " + std::to_string(i);
    if (at.y() < block.y() || block.y() < kMinHeightFraction * (kFloorHeight * double(i) + 0.5 * kBlock))
      return name + " has come down";
    if (double(plate.getBasis()[1][1]) < kMinTiltCosine) return name + " is not level";
    if (std::hypot(at.x() - lowest.x(), at.z() - lowest.z()) > kMaxSway) return name + " has slipped aside";
  }
  return {};
}

SoftBodySettings blockSettings(const SceneOptions& options) {
  SoftBodySettings settings;
  settings.scale = {kWidth, kBlock, kWidth};
  settings.totalMass = 0.6;
  settings.extensionStiffness = settings.compressionStiffness = 5000.0;
  settings.damping = 20.0;
  settings.pointRadius = kThinRadius;
  settings.friction = 0.8;
  apply(options, settings);
  return settings;
}

/// Nudges the topmost plate once, when everything is at rest.
void nudge(btRigidBody& top, const Scene& scene) {
  if (scene.ticks != kNudgeTick) return;
  top.activate(true);
  top.applyCentralImpulse(btVector3(btScalar(kNudge), 0, 0));
}

}  // namespace

SceneResult createTower(const SceneOptions& options) {
  const Result<SharedNetwork> cube = cubeNetwork();
  if (!cube) return Error{cube.error()};
  const std::uint32_t count = options.count.value_or(4);
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 10.0);
  Random random(options.seed);
  SoftBodySettings settings = blockSettings(options);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double base = kFloorHeight * i;
    settings.position = {0.0, base + kThinRadius + 0.5 * kBlock, 0.0};
    settings.rotation = Eigen::AngleAxisd(random.between(-0.2, 0.2), Eigen::Vector3d::UnitY());
    const BodyLook look{paletteColour(i), false, false, Finish::Jelly};
    const std::string reason = addBody(*scene, *cube, settings, look);
    if (!reason.empty()) return Error{reason};
    addBox(*scene, {0.0, base + 2.0 * kThinRadius + kBlock + kGap + kPlateThick, 0.0},
           {kPlateHalf, kPlateThick, kPlateHalf}, kPlateMass, kPlateColour);
  }
  scene->beforeTick = [top = scene->world->movables.back().get()](Scene& s) { nudge(*top, s); };
  scene->view.box =
      Eigen::AlignedBox3d(Eigen::Vector3d(-0.8, 0, -0.8), Eigen::Vector3d(0.8, kFloorHeight * count, 0.8));
  scene->endChecks = {checkFinite,     checkAboveFloor,         checkTower,       checkRigidApart(kMaxDepth),
                      checkCalm(0.02), checkMovablesCalm(0.02), checkShapes(0.05)};
  return scene;
}

}  // namespace limber::scenes
