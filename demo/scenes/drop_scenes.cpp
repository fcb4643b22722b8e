// SPDX-License-Identifier: Zlib
// Cubes that drop on a floor, and cubes that fold up.

#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene_list.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace limber::scenes {

// --- drop --------------------------------------------------------------------------------------------------

namespace {

/// The dropped shape at its scale.
struct DroppedShape {
  SharedNetwork network;
  double scale = 1.0;
  double size = 1.0;                                 // m, largest extent
  double radius = 1.0;                               // m, of the ball around its box
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // m, of its box, from the network's origin
};

DroppedShape measure(SharedNetwork network, const std::optional<double>& scale) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : network->restPoints) box.extend(p);
  const double extent = box.sizes().maxCoeff();
  DroppedShape shape;
  shape.scale = scale ? *scale : 1.0 / extent;
  shape.size = shape.scale * extent;
  shape.radius = 0.5 * shape.scale * box.diagonal().norm();
  shape.middle = shape.scale * box.center();
  shape.network = std::move(network);
  return shape;
}

/// Fills the scene with `count` bodies over the floor.
std::string dropBodies(Scene& scene, const DroppedShape& shape, const SceneOptions& options,
                       std::uint32_t defaultCount, SoftBodySettings settings) {
  Random random(options.seed);
  const DropGridSettings grid = dropGridOf(options.count.value_or(defaultCount), shape.size, shape.radius);
  settings.scale.setConstant(shape.scale);
  apply(options, settings);
  BodyLook look;
  look.smooth = sharpestBend(*shape.network) < kSmoothBend;
  settings.pointRadius = kThinRadius * shape.size;
  addDropFloor(scene, grid, shape.size, shape.radius);

  std::size_t index = 0;
  for (const Placement& placement : dropGrid(grid, random)) {
    settings.position = placement.centre - placement.rotation * shape.middle;
    settings.rotation = placement.rotation;
    look.colour = variedColour(index + index / gridColumns(grid.count) * 3, random);
    std::string reason = addBody(scene, shape.network, settings, look);
    if (!reason.empty()) return reason;
    ++index;
  }
  return {};
}

}  // namespace

SceneResult createCubes(const SceneOptions& options) {
  Result<SharedNetwork> cube = cubeNetwork();
  if (!cube) return Error{cube.error()};
  const DroppedShape shape = measure(*cube, options.scale.value_or(1.0));
  auto scene = std::make_unique<Scene>();
  std::string reason = dropBodies(*scene, shape, options, 64, {});
  if (!reason.empty()) return Error{reason};
  noteOddSize(*scene, shape.size);
  scene->endChecks = {checkFinite, checkAboveFloor, checkCalm(0.02 * shape.size), checkShapes(0.03),
                      checkAsleep};
  return scene;
}

// --- collapse ----------------------------------------------------------------------------------------------

namespace {

const Eigen::Vector3f kBareColour(0.86f, 0.33f, 0.27f);
const Eigen::Vector3f kBracedColour(0.16f, 0.58f, 0.55f);

/// Largest RMS error of shape, relative to the size. With k = 20 N/m a cube of 1 kg sags by 0.06; a folded
/// one has an error of 0.2 or more.
constexpr double kMaxShapeError = 0.1;

/// Checks the braced bodies: every second one.
std::string checkBraced(const Scene& scene) {
  for (std::size_t b = 1; b < scene.soft->bodyCount(); b += 2) {
    const ShapeError error = shapeError(*scene.soft->body(b));
    if (error.relativeRms <= kMaxShapeError && !error.mirrored) continue;
    char line[120];
    std::snprintf(line, sizeof line, "braced body %zu: shape off by %.3g of its size%s", b, error.relativeRms,
                  error.mirrored ? ", inside out" : "");
    return line;
  }
  return {};
}

/// Adds a cube: bare ones on the left, braced ones on the right.
std::string addCube(Scene& scene, const SharedNetwork& network, SoftBodySettings settings, bool braced,
                    double sideways) {
  if (!braced) settings.volumeModulus = 0.0;
  settings.position.x() += braced ? sideways : -sideways;
  return addBody(scene, network, settings, {braced ? kBracedColour : kBareColour});
}

void addFloorAndView(Scene& scene, double half) {
  addFloor(scene, 1.5 * half + 8.0);
  const Eigen::Vector3d halfView(2.0 * half, 0.0, half);
  scene.view.box = Eigen::AlignedBox3d(-halfView, halfView + Eigen::Vector3d(0.0, 0.5, 0.0));
  scene.view.direction = {0.0, 0.4, 1.0};
}

}  // namespace

SceneResult createCollapse(const SceneOptions& options) {
  const Result<SharedNetwork> bare = cubeNetwork(BraceRule::None), braced = cubeNetwork(BraceRule::Pipeline);
  if (!bare || !braced) return Error{bare ? braced.error() : bare.error()};
  auto scene = std::make_unique<Scene>();
  SoftBodySettings settings = SoftBodySettings::paper();
  settings.pointRadius = kThinRadius;
  apply(options, settings);
  Random random(options.seed);
  const std::uint32_t count = options.count.value_or(24);
  DropGridSettings grid;
  grid.count = (count + 1) / 2;
  grid.spacing = 2.2;
  grid.lowest = 1.5;
  grid.highest = 2.5;
  const double half = 0.5 * grid.spacing * gridColumns(grid.count);
  addFloorAndView(*scene, half);
  const std::vector<Placement> placements = dropGrid(grid, random);
  for (std::uint32_t i = 0; i < count; ++i) {
    const bool isBraced = i % 2 == 1;
    settings.position = placements[i / 2].centre;
    settings.rotation = placements[i / 2].rotation;
    std::string reason = addCube(*scene, isBraced ? *braced : *bare, settings, isBraced, half + 0.5);
    if (!reason.empty()) return Error{reason};
  }
  scene->notes.push_back("left: the paper's cube, 18 springs; right: braced, and with a volume to keep");
  scene->endChecks = {checkFinite, checkAboveFloor, checkBraced};
  return scene;
}

}  // namespace limber::scenes
