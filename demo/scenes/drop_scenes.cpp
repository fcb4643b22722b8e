// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene_list.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace limber::scenes {
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
  Result<SharedNetwork> cube = readNetwork(LIMBER_MESH_DIR "/cube.obj");
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

}  // namespace limber::scenes
