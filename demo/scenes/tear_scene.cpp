// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <Eigen/Geometry>

#include <cmath>
#include <memory>

namespace limber::scenes {
namespace {

constexpr std::uint32_t kSheetCells = 32;
constexpr double kSheetSize = 2.0, kSheetHeight = 1.4;                          // m
constexpr double kTearStrain = 0.12;                                            // of a spring that tears
constexpr double kTearBall = 0.3, kTearBallMass = 15.0, kTearBallHeight = 3.0;  // m, kg, m
const Eigen::Vector3f kTearBallColour(0.92f, 0.92f, 0.92f);

std::string addSheet(Scene& scene, const SceneOptions& options) {
  ClothSettings shape;
  shape.width = shape.depth = kSheetSize;
  shape.columns = shape.rows = kSheetCells;
  const Result<SharedNetwork> network = buildCloth(shape);
  if (!network) return network.error();
  SoftBodySettings settings;
  settings.totalMass = 0.6;
  settings.extensionStiffness = settings.compressionStiffness = 3000.0;
  settings.damping = 1.0;
  settings.pointRadius = 0.012;
  settings.flow.linearDrag = 1.6;
  settings.elasticLimit.breakStrain = kTearStrain;
  settings.elasticLimit.tear = true;
  settings.position = {0.0, kSheetHeight + Random(options.seed).between(-0.005, 0.005), 0.0};
  apply(options, settings);
  BodyLook look;
  look.colour = paletteColour(0);
  look.smooth = look.checkered = true;
  look.finish = Finish::Cloth;
  if (const std::string reason = addBody(scene, *network, settings, look); !reason.empty()) return reason;
  SoftBody& sheet = *scene.soft->body(0);
  for (std::uint32_t i = 0; i <= kSheetCells; ++i)
    for (const std::uint32_t column : {0u, kSheetCells}) sheet.pin(i * (kSheetCells + 1) + column);
  return {};
}

double restArea(const SpringNetwork& network) {
  double sum = 0.0;
  const auto& x = network.restPoints;
  for (const Triangle& t : network.surface) sum += 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
  return sum;
}

/// Checks that the ball has torn the sheet and lies below it, and that nothing of the sheet is lost.
Check checkTorn(const btRigidBody& ball, const std::shared_ptr<std::size_t>& tears) {
  return [&ball, tears](const Scene& scene) {
    const SoftBody& sheet = *scene.soft->body(0);
    if (*tears < 10) return "the sheet has torn at " + std::to_string(*tears) + " points only";
    if (fromBullet(ball.getWorldTransform().getOrigin()).y() > kSheetHeight - kTearBall)
      return std::string("the ball has not fallen through the sheet");
    if (std::abs(restArea(sheet.network()) - kSheetSize * kSheetSize) > 1e-9)
      return std::string("the sheet has lost triangles");
    return std::string();
  };
}

}  // namespace

SceneResult createTear(const SceneOptions& options) {
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 10.0);
  if (const std::string reason = addSheet(*scene, options); !reason.empty()) return Error{reason};
  btRigidBody& ball =
      addBall(*scene, {0.1, kTearBallHeight, 0.15}, kTearBall, kTearBallMass, kTearBallColour);
  ball.setRollingFriction(btScalar(0.05));
  ball.setDamping(btScalar(0.1), btScalar(0.5));
  const auto tears = std::make_shared<std::size_t>(0);
  scene->afterTick = [tears](Scene& now) { *tears += now.soft->body(0)->tears().size(); };
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-1.1, 0, -1.0), Eigen::Vector3d(1.1, 2.0, 1.0));
  scene->view.direction = {0.4, 0.55, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkTorn(ball, tears), checkCalm(0.1)};
  return scene;
}

}  // namespace limber::scenes
