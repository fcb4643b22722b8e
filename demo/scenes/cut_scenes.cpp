// SPDX-License-Identifier: Zlib
// A cloth and a block that are cut, and a sheet that a ball tears.

#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <Eigen/Geometry>

#include <cmath>
#include <memory>
#include <utility>

namespace limber::scenes {

// --- cut ---------------------------------------------------------------------------------------------------

namespace {

constexpr std::uint32_t kBannerCells = 24;
constexpr double kBannerSize = 1.4, kBannerTop = 1.8;  // m
constexpr std::int64_t kFirstCut = 60, kSweep = 60;    // ticks
constexpr double kPart = 0.6;                          // m/s, at which pieces part
const Eigen::Vector3d kBlockCentre(1.5, 0.45, 0.0);    // m

/// Adds a square cloth with a side of `size` (m) and so many cells along it.
std::string addCloth(Scene& scene, double size, std::uint32_t cells, SoftBodySettings settings,
                     const SceneOptions& options) {
  const Result<SharedNetwork> network = clothNetwork(size, size, cells, cells);
  if (!network) return network.error();
  settings.pointRadius = 0.012;
  settings.flow.linearDrag = 1.6;
  apply(options, settings);
  return addBody(scene, *network, settings, clothLook(paletteColour(0)));
}

std::string addBanner(Scene& scene, const SceneOptions& options) {
  SoftBodySettings settings;
  settings.totalMass = 0.4;
  settings.damping = 0.4;
  // upright, its first row on top
  settings.rotation = Eigen::AngleAxisd(0.5 * 3.141592653589793, Eigen::Vector3d::UnitX());
  settings.position = {-0.6, kBannerTop - 0.5 * kBannerSize, 0.0};
  const std::string reason = addCloth(scene, kBannerSize, kBannerCells, settings, options);
  if (!reason.empty()) return reason;
  for (std::uint32_t i = 0; i <= kBannerCells; ++i) scene.soft->body(0)->pin(i);
  return {};
}

std::string addBlock(Scene& scene, const SceneOptions& options) {
  const Result<SharedNetwork> cube = cubeNetwork();
  if (!cube) return cube.error();
  TriangleMesh mesh;
  mesh.positions = (*cube)->restPoints;
  mesh.triangles = (*cube)->surface;
  MaterialMesh fill;
  fill.points = 250;
  const Result<SharedNetwork> network = buildMaterialNetwork(mesh, fill);
  if (!network) return network.error();
  SoftBodySettings settings;
  settings.scale = Eigen::Vector3d(0.9, 0.7, 0.7);
  settings.position = kBlockCentre;
  settings.rotation = Eigen::AngleAxisd(Random(options.seed).between(-0.02, 0.02), Eigen::Vector3d::UnitY());
  settings.selfCollision = true;
  settings.pointRadius = 0.012;
  const Result<SoftBodySettings> jelly = withMaterial(**network, Material::jelly(), settings);
  if (!jelly) return jelly.error();
  settings = *jelly;
  apply(options, settings);
  return addBody(scene, *network, settings, {paletteColour(1), false, false, Finish::Jelly});
}

/// Gives the points on each side of a plane a velocity away from it.
void partAt(SoftBody& body, const Eigen::Vector3d& place, const Eigen::Vector3d& normal) {
  const double speed = kPart * body.totalMass();
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    const double side = normal.dot(body.position(i) - place) > 0.0 ? 1.0 : -1.0;
    const double push = side * speed * body.network().massFractions[i];
    static_cast<void>(body.applyImpulse(toBullet(push * normal), i));
  }
}

/// Cuts the block by planes, and the banner by a blade that moves across it.
void cutAll(Scene& scene, std::size_t& made) {
  SoftBody &banner = *scene.soft->body(0), &block = *scene.soft->body(1);
  const std::int64_t ticks = scene.ticks - kFirstCut;
  if (ticks >= 0 && ticks <= kSweep && ticks % 5 == 0) {
    // always in the same plane, and at last beyond the other edge
    const double way = 0.07 + 0.93 * double(ticks) / double(kSweep);
    const btVector3 away(0, 0, 1), start(btScalar(-1.4), btScalar(kBannerTop - 0.75 * kBannerSize), 0),
        tip = start + btVector3(btScalar(1.65), btScalar(0.35), 0) * btScalar(way);
    if (const auto cut = banner.cut({start - away, start + away, tip + away, tip - away})) made += *cut;
  }
  const std::pair<std::int64_t, Eigen::Vector3d> planes[] = {{0, Eigen::Vector3d::UnitX()},
                                                             {kSweep, Eigen::Vector3d::UnitZ()}};
  for (const auto& [when, normal] : planes) {
    if (ticks != when) continue;
    const Eigen::Vector3d place = fromBullet(block.transform().getOrigin()) + 0.02 * normal;
    if (const auto cut = block.cut(toBullet(place), toBullet(normal))) made += *cut;
    partAt(block, place, normal);
  }
}

/// Checks that the parts of both bodies are apart.
Check checkCut(const std::shared_ptr<std::size_t>& made) {
  return [made](const Scene& scene) {
    if (*made < 60) return "only " + std::to_string(*made) + " points were divided";
    const SoftBody& banner = *scene.soft->body(0);
    // the last row of the banner as it was made
    for (std::uint32_t i = 0; i <= kBannerCells; ++i)
      if (banner.position(kBannerCells * (kBannerCells + 1) + i).y() > 0.2)
        return std::string("the lower part of the banner has not fallen");
    Eigen::AlignedBox3d box;
    const SoftBody& block = *scene.soft->body(1);
    for (std::uint32_t i = 0; i < block.pointCount(); ++i) box.extend(block.position(i));
    if (box.sizes().x() < 1.0 || box.sizes().z() < 0.8)
      return std::string("the parts of the block are together");
    return std::string();
  };
}

}  // namespace

SceneResult createCut(const SceneOptions& options) {
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 10.0);
  if (const std::string reason = addBanner(*scene, options); !reason.empty()) return Error{reason};
  if (const std::string reason = addBlock(*scene, options); !reason.empty()) return Error{reason};
  const auto made = std::make_shared<std::size_t>(0);
  scene->beforeTick = [made](Scene& now) { cutAll(now, *made); };
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-1.4, 0, -0.6), Eigen::Vector3d(2.4, 1.9, 1.3));
  scene->view.direction = {0.3, 0.4, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkCut(made), checkCalm(0.1)};
  return scene;
}

// --- tear --------------------------------------------------------------------------------------------------

namespace {

constexpr std::uint32_t kSheetCells = 32;
constexpr double kSheetSize = 2.0, kSheetHeight = 1.4;                          // m
constexpr double kTearStrain = 0.12;                                            // of a spring that tears
constexpr double kTearBall = 0.3, kTearBallMass = 15.0, kTearBallHeight = 3.0;  // m, kg, m
const Eigen::Vector3f kTearBallColour(0.92f, 0.92f, 0.92f);

std::string addSheet(Scene& scene, const SceneOptions& options) {
  SoftBodySettings settings;
  settings.totalMass = 0.6;
  settings.extensionStiffness = settings.compressionStiffness = 3000.0;
  settings.damping = 1.0;
  settings.elasticLimit.breakStrain = kTearStrain;
  settings.elasticLimit.tear = true;
  settings.position = {0.0, kSheetHeight + Random(options.seed).between(-0.005, 0.005), 0.0};
  const std::string reason = addCloth(scene, kSheetSize, kSheetCells, settings, options);
  if (!reason.empty()) return reason;
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
