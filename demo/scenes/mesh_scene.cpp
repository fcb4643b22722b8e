// SPDX-License-Identifier: Zlib
// Copies of any mesh fall onto a floor.

#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/scene_list.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace limber::scenes {
namespace {

/// Points in all copies, beyond which fewer than nine are dropped.
constexpr std::size_t kMaxScenePoints = 6000;

/// The same for drawn vertices: without a GPU a frame of nine copies of 50 000 takes half a second.
constexpr std::size_t kMaxSceneVertices = 150000;
constexpr std::uint32_t kUsualCount = 9;

/// Largest RMS error of shape, relative to the size: hard materials sag by a hundredth, soft ones by a tenth.
constexpr double kMaxHardError = 0.1, kMaxSoftError = 0.3;

constexpr const char* kShapeRemedy = "; a harder material (--feel stiff) or more --points hold it";

/// Largest stretch of a drawn edge: more is a spike.
constexpr double kMaxStretch = 3.0;

/// Sizes of the mesh between it and its origin. A single-precision file has errors of 0.6 % of the size
/// there.
constexpr double kFarFromOrigin = 1e5;

/// Bodies farther than this from the middle of the scene, in sizes of the scene, have flown away.
constexpr double kFarAway = 100.0;

/// A mesh and the size of its bodies together.
struct DroppedMesh {
  CookedMesh cooked;
  double scale = 1.0;                                ///< of the cooked bodies
  double size = 1.0, radius = 1.0;                   ///< m, largest extent, and of the ball around the box
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< m, of the box
};

/// Bodies smaller than this share of their whole mesh are made 1 m long, instead of the whole: small bodies
/// of the usual materials are so stiff that they would need very many substeps.
constexpr double kScattered = 0.1;

DroppedMesh measure(CookedMesh cooked, const std::optional<double>& scale) {
  Eigen::AlignedBox3d box;
  double largest = 0.0;
  for (const SharedNetwork& body : cooked.bodies) {
    for (const Eigen::Vector3d& p : body->restPoints) box.extend(p);
    largest = std::max(largest, sizeOf(body->restPoints));
  }
  const double extent = box.sizes().maxCoeff();
  DroppedMesh mesh;
  mesh.scale = scale ? *scale / cooked.scale : 1.0 / (largest < kScattered * extent ? largest : extent);
  mesh.size = mesh.scale * extent;
  mesh.radius = 0.5 * mesh.scale * box.diagonal().norm();
  mesh.middle = mesh.scale * box.center();
  mesh.cooked = std::move(cooked);
  return mesh;
}

/// Returns as many copies as a scene can show soon: nine of usual bodies.
std::uint32_t usualCount(const CookedMesh& cooked) {
  std::size_t points = 1, vertices = 1;
  for (const SharedNetwork& body : cooked.bodies) {
    points += body->restPoints.size();
    vertices += body->render.skin.size();
  }
  const std::size_t fitting = std::min(kMaxScenePoints / points, kMaxSceneVertices / vertices);
  const std::size_t byBodies = 2 * kUsualCount / cooked.bodies.size();
  return static_cast<std::uint32_t>(
      std::clamp<std::size_t>(std::min(fitting, byBodies), 1, std::size_t{kUsualCount}));
}

Result<std::vector<SoftBodySettings>> settingsOf(const DroppedMesh& mesh, const SceneOptions& options) {
  std::vector<SoftBodySettings> all;
  for (const SharedNetwork& body : mesh.cooked.bodies) {
    SoftBodySettings settings;
    settings.scale.setConstant(mesh.scale);
    Result<SoftBodySettings> made = withMaterial(*body, materialOf(options.feel), settings);
    if (!made) return Error{made.error()};
    apply(options, *made);
    all.push_back(std::move(*made));
  }
  return all;
}

/// Fills the scene with copies over the floor. Returns the reason of a failure, or an empty string.
std::string dropCopies(Scene& scene, const DroppedMesh& mesh, const SceneOptions& options) {
  Result<std::vector<SoftBodySettings>> settings = settingsOf(mesh, options);
  if (!settings) return settings.error();
  Random random(options.seed);
  const DropGridSettings grid =
      dropGridOf(options.count.value_or(usualCount(mesh.cooked)), mesh.size, mesh.radius);
  addDropFloor(scene, grid, mesh.size, mesh.radius);
  std::size_t index = 0;
  for (const Placement& placement : dropGrid(grid, random)) {
    BodyLook look;
    look.colour = variedColour(index + index / gridColumns(grid.count) * 3, random);
    for (std::size_t b = 0; b < mesh.cooked.bodies.size(); ++b) {
      const SharedNetwork& network = mesh.cooked.bodies[b];
      (*settings)[b].position = placement.centre - placement.rotation * mesh.middle;
      (*settings)[b].rotation = placement.rotation;
      if (options.feel == Feel::Jelly) look.finish = Finish::Jelly;
      look.smooth = usualBend(*network) < kSmoothBend;
      if (std::string reason = addBody(scene, network, (*settings)[b], look); !reason.empty()) return reason;
    }
    ++index;
  }
  return {};
}

}  // namespace

const std::map<std::string, Feel>& feels() {
  static const std::map<std::string, Feel> feels = {
      {"jelly", Feel::Jelly}, {"rubber", Feel::Rubber}, {"foam", Feel::Foam}, {"stiff", Feel::Stiff}};
  return feels;
}

Material materialOf(Feel feel) {
  switch (feel) {
    case Feel::Jelly:
      return Material::jelly();
    case Feel::Foam:
      return Material::foam();
    case Feel::Stiff:
      return Material::stiff();
    case Feel::Rubber:
      break;
  }
  return Material::rubber();
}

SceneResult createMeshDrop(const SceneOptions& options) {
  if (options.meshFile.empty()) return Error{"the scene mesh needs a file"};
  CookSettings settings = options.cook;
  settings.size = 1.0;
  Result<CookedMesh> cooked = readBodies(options.meshFile, settings, options.cacheFolder);
  if (!cooked) return Error{cooked.error()};
  const DroppedMesh mesh = measure(std::move(*cooked), options.scale);
  if (mesh.middle.norm() > kFarFromOrigin * mesh.size)
    return Error{
        options.meshFile + ": the mesh is more than " + std::to_string(int(kFarFromOrigin)) +
        " times its size away from its origin, where files have too few digits for its shape; move it to "
        "the origin"};
  auto scene = std::make_unique<Scene>();
  std::string reason = dropCopies(*scene, mesh, options);
  if (!reason.empty()) return Error{options.meshFile + ": " + reason};
  for (const std::string& line : mesh.cooked.report)
    if (!line.empty()) scene->notes.push_back(line);
  if (options.scale) {
    char line[80];
    std::snprintf(line, sizeof line, "size: %.3g times all lengths above", *options.scale);
    scene->notes.push_back(line);
  }
  noteOddSize(*scene, mesh.size);
  const bool isHard = options.feel == Feel::Rubber || options.feel == Feel::Stiff;
  const double reach = kFarAway * scene->view.box.diagonal().norm();
  scene->endChecks = {checkFinite, checkWithin(reach), checkAboveFloor,
                      checkShapes(isHard ? kMaxHardError : kMaxSoftError, kShapeRemedy),
                      checkSpikes(kMaxStretch)};
  return scene;
}

}  // namespace limber::scenes
