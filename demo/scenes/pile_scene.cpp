// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene_list.h"

#include <cmath>

namespace limber::scenes {
namespace {

constexpr double kSize = 0.5;          // m, of a body
constexpr std::uint32_t kColumns = 3;  // along x and z
constexpr double kSpacing = 0.9;       // m: neighbours do not touch at first, whatever their rotation
constexpr double kHalf = 0.5 * kColumns * kSpacing;  // m, of the bin's inside
constexpr double kWall = 0.1;                        // m, half thickness
constexpr double kHeight = 1.8;                      // m, of the walls
constexpr double kMaxDepth = 0.05;                   // allowed penetration, relative to a body's size
const Eigen::Vector3f kWallColour(0.80f, 0.81f, 0.83f);

struct Kind {
  SharedNetwork network;
  bool smooth = false;
};

/// Returns a network about 1 m large with about `points` points.
Result<SharedNetwork> networkOf(const char* file, std::uint32_t points) {
  const Result<TriangleMesh> mesh = importMesh(std::string(LIMBER_MESH_DIR "/") + file);
  if (!mesh) return Error{mesh.error()};
  const Result<TriangleMesh> coarse = simplify(*mesh, points);
  if (!coarse) return Error{coarse.error()};
  return buildNetwork(*coarse);
}

Result<std::vector<Kind>> readKinds() {
  std::vector<Kind> kinds;
  const std::pair<const char*, std::uint32_t> files[] = {
      {"cube.obj", 8}, {"icosphere.obj", 42}, {"cylinder.obj", 40}, {"torus.obj", 64}};
  for (const auto& [file, points] : files) {
    const Result<SharedNetwork> network = networkOf(file, points);
    if (!network) return Error{std::string(file) + ": " + network.error()};
    kinds.push_back({*network, sharpestBend(**network) < kSmoothBend});
  }
  return kinds;
}

void addWall(Scene& scene, const Eigen::Vector3d& centre, const Eigen::Vector3d& half) {
  auto box = std::make_unique<btBoxShape>(toBullet(half));
  addStatic(scene, std::move(box), centre, 0.5, kWallColour);
}

void addBin(Scene& scene) {
  const double at = kHalf + kWall, up = 0.5 * kHeight;
  for (const double side : {-1.0, 1.0}) {
    addWall(scene, {side * at, up, 0}, {kWall, up, kHalf + 2 * kWall});
    addWall(scene, {0, up, side * at}, {kHalf, up, kWall});
  }
}

SoftBodySettings settingsOf(const SceneOptions& options) {
  SoftBodySettings settings;
  settings.scale.setConstant(kSize);
  settings.totalMass = 0.5;
  settings.damping = 3.0;
  settings.pointRadius = kThinRadius;
  apply(options, settings);
  return settings;
}

/// Returns the start of body i; layers above the floor.
Eigen::Vector3d startOf(std::uint32_t i) {
  const Eigen::Vector3d cell(i % kColumns, i / (kColumns * kColumns), i / kColumns % kColumns);
  return kSpacing * (cell + Eigen::Vector3d::Constant(0.5)) - Eigen::Vector3d(kHalf, 0, kHalf);
}

std::string checkInBin(const Scene& scene) {
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const Eigen::Vector3d middle = middleOf(*scene.soft->body(b));
    if (std::abs(middle.x()) > kHalf || std::abs(middle.z()) > kHalf)
      return "body " + std::to_string(b) + " is not in the bin";
  }
  return {};
}

}  // namespace

SceneResult createPile(const SceneOptions& options) {
  const Result<std::vector<Kind>> kinds = readKinds();
  if (!kinds) return Error{kinds.error()};
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 10.0);
  addBin(*scene);
  Random random(options.seed);
  SoftBodySettings settings = settingsOf(options);
  for (std::uint32_t i = 0; i < options.count.value_or(48); ++i) {
    const Kind& kind = (*kinds)[i % kinds->size()];
    settings.position = startOf(i);
    settings.rotation = random.rotation();
    const BodyLook look{variedColour(i + i / kinds->size(), random), kind.smooth};
    const std::string reason = addBody(*scene, kind.network, settings, look);
    if (!reason.empty()) return Error{reason};
  }
  const double halfView = kHalf + 2.0 * kWall;
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-halfView, 0, -halfView),
                                        Eigen::Vector3d(halfView, kHeight, halfView));
  scene->view.direction = {0.35, 1.2, 1.0};
  scene->endChecks = {checkFinite,
                      checkAboveFloor,
                      checkInBin,
                      checkSoftApart(kMaxDepth * kSize),
                      checkRigidApart(kMaxDepth * kSize),
                      checkCalm(0.04 * kSize),
                      checkShapes(0.15)};
  return scene;
}

}  // namespace limber::scenes
