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

constexpr double kBlockWidth = 1.2, kBlockHeight = 0.5;  // m
constexpr double kBlockSpacing = 1.6;                    // m
constexpr double kPressRadius = 0.28;                    // m, of the press
constexpr double kPressDepth = 0.22;                     // m
constexpr double kAbove = 0.6;                           // m, of the press over the block before and after
/// Strains beyond which the springs of a block yield; 0: never.
constexpr double kYields[] = {0.0, 0.08, 0.03};

/// Returns the surface of a box about the origin, with square cells.
TriangleMesh boxOfCells(const Eigen::Vector3d& size, double cell) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const int columns = int(std::lround(size[u] / cell)), rows = int(std::lround(size[v] / cell));
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
          Eigen::Vector3d p;
          p[axis] = 0.5 * side * size[axis];
          p[u] = size[u] * (double(i) / columns - 0.5);
          p[v] = size[v] * (double(j) / rows - 0.5);
          mesh.positions.push_back(p);
        }
      for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
          const auto a = first + static_cast<std::uint32_t>(j * (columns + 1) + i), b = a + 1,
                     c = a + static_cast<std::uint32_t>(columns) + 1, d = c + 1;
          mesh.triangles.push_back(side > 0.0 ? Triangle{a, b, d} : Triangle{a, d, b});
          mesh.triangles.push_back(side > 0.0 ? Triangle{a, d, c} : Triangle{a, c, d});
        }
    }
  return mesh;
}

double blockAt(std::size_t block) { return kBlockSpacing * (double(block) - 1.0); }

/// Returns how deep (m) the top of a block is dented.
double dentOf(const SoftBody& block) {
  double lowest = 1e9, highest = -1e9;
  for (std::uint32_t i = 0; i < block.pointCount(); ++i) {
    const Eigen::Vector3d rest = block.network().restPoints[i];
    if (rest.y() < 0.5 * kBlockHeight - 1e-6) continue;
    lowest = std::min(lowest, block.position(i).y());
    highest = std::max(highest, block.position(i).y());
  }
  return highest - lowest;
}

/// Returns the height (m) of the press over the tops of the blocks, at a time (s): down within a second, up
/// within another.
double pressAt(double time) {
  const double swing = std::clamp(time, 0.0, 2.0) - 1.0;
  return -kPressDepth + (kAbove + kPressDepth) * std::abs(swing);
}

Check checkDents() {
  return [](const Scene& scene) {
    const auto dent = [&](std::size_t i) { return dentOf(*scene.soft->body(i)); };
    const std::string heights = std::to_string(dent(0)) + ", " + std::to_string(dent(1)) + " and " +
                                std::to_string(dent(2)) + " m deep";
    if (dent(0) > 0.01) return "the elastic block keeps a dent: " + heights;
    if (dent(1) < 0.03 || dent(2) < dent(1) + 0.005)
      return "blocks that yield do not keep their dents: " + heights;
    return std::string();
  };
}

std::string addBlocks(Scene& scene, const SharedNetwork& network, const SceneOptions& options) {
  Random random(options.seed);
  for (std::size_t i = 0; i < 3; ++i) {
    SoftBodySettings settings;
    settings.rotation = Eigen::AngleAxisd(random.between(-0.05, 0.05), Eigen::Vector3d::UnitY());
    settings.position = {blockAt(i), 0.5 * kBlockHeight, 0.0};
    const Result<SoftBodySettings> material = withMaterial(*network, {3e5, 0.3, 500.0, 0.03}, settings);
    if (!material) return material.error();
    settings = *material;
    settings.elasticLimit.yieldStrain = kYields[i];
    settings.friction = 1.0;
    apply(options, settings);
    const BodyLook look{paletteColour(i)};
    if (const std::string reason = addBody(scene, network, settings, look); !reason.empty()) return reason;
  }
  return {};
}

}  // namespace

SceneResult createDent(const SceneOptions& options) {
  MaterialMesh filling;
  filling.points = 900;
  const Result<SharedNetwork> network =
      buildMaterialNetwork(boxOfCells({kBlockWidth, kBlockHeight, kBlockWidth}, 0.04), filling);
  if (!network) return Error{network.error()};
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 10.0);
  if (const std::string reason = addBlocks(*scene, *network, options); !reason.empty()) return Error{reason};
  const double above = kBlockHeight + kPressRadius;
  std::vector<btRigidBody*> presses;
  for (std::size_t i = 0; i < 3; ++i)
    presses.push_back(
        &addBall(*scene, {blockAt(i), above + kAbove, 0.0}, kPressRadius, 0.0, {0.55f, 0.58f, 0.62f}));
  scene->beforeTick = [presses, above](Scene& now) {
    const double time = double(now.ticks + 1) / double(kTicksPerSecond);
    for (std::size_t i = 0; i < presses.size(); ++i)
      moveTo(*presses[i], {blockAt(i), above + pressAt(time), 0.0});
  };
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-2.3, 0, -0.7), Eigen::Vector3d(2.3, 1.3, 0.7));
  scene->view.direction = {0.15, 0.55, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkDents(), checkCalm(0.05)};
  return scene;
}

}  // namespace limber::scenes
