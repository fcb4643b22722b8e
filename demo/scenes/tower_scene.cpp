// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <cmath>

namespace limber::scenes {
namespace {

constexpr double kWidth = 0.8, kBlock = 0.4;            // m, of a block of jelly
constexpr double kPlateHalf = 0.5, kPlateThick = 0.04;  // m, half extents of a plate
constexpr double kPlateMass = 0.8;                      // kg
constexpr double kGap = 2e-3;                           // m, at first
constexpr double kFloorHeight = kBlock + 2.0 * kPlateThick + 2.0 * (kThinRadius + kGap);  // m, of a storey
constexpr std::int64_t kNudgeTick = 4 * kTicksPerSecond;
constexpr double kNudge = 0.4;               // N s, at the topmost plate
constexpr double kMaxOffset = 0.2;           // m, largest final offset from the lowest block
constexpr double kMinHeightFraction = 0.75;  // smallest fraction of a storey's height at the end
constexpr double kMinTiltCosine = 0.98;      // smallest cosine of a plate's tilt: 11 degrees
constexpr double kMaxDepth = 5e-3;           // m, allowed penetration of blocks and plates
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
    if (std::hypot(at.x() - lowest.x(), at.z() - lowest.z()) > kMaxOffset) return name + " has slipped aside";
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
void nudgeTop(Scene& scene) {
  if (scene.ticks != kNudgeTick) return;
  btRigidBody& top = *scene.world->movables.back();
  top.activate(true);
  top.applyCentralImpulse(btVector3(btScalar(kNudge), 0, 0));
}

}  // namespace

SceneResult createTower(const SceneOptions& options) {
  const Result<SharedNetwork> cube = readNetwork(LIMBER_MESH_DIR "/cube.obj");
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
    BodyLook look;
    look.colour = paletteColour(i);
    look.finish = Finish::Jelly;
    const std::string reason = addBody(*scene, *cube, settings, look);
    if (!reason.empty()) return Error{reason};
    addBox(*scene, {0.0, base + 2.0 * kThinRadius + kBlock + kGap + kPlateThick, 0.0},
           {kPlateHalf, kPlateThick, kPlateHalf}, kPlateMass, kPlateColour);
  }
  scene->beforeTick = nudgeTop;
  scene->view.box =
      Eigen::AlignedBox3d(Eigen::Vector3d(-0.8, 0, -0.8), Eigen::Vector3d(0.8, kFloorHeight * count, 0.8));
  scene->endChecks = {checkFinite,     checkAboveFloor,         checkTower,       checkRigidApart(kMaxDepth),
                      checkCalm(0.02), checkMovablesCalm(0.02), checkShapes(0.05)};
  return scene;
}

}  // namespace limber::scenes
