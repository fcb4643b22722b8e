// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/networks.h"
#include "scenes/overlap.h"
#include "scenes/scene_list.h"

#include <cstdio>

namespace limber::scenes {
namespace {

constexpr double kEdge = 1.0;       // m, of a cube
constexpr double kMarble = 0.06;    // m, radius: far smaller than a face
constexpr double kMass = 0.05;      // kg, of a marble
constexpr double kDrop = 0.6;       // m above the cube
constexpr double kShotSpeed = 8.0;  // m/s
constexpr double kSpacing = 2.4;    // m from cube to cube
constexpr double kMaxOffset = 0.2;  // m, at most, from a face's middle
constexpr double kDent = 0.02;      // m, allowed depth of a marble in a face during the hit
constexpr double kRestDent = 2e-3;  // m, at rest
const Eigen::Vector3f kMarbleColour(0.20f, 0.22f, 0.28f);

bool isShotAt(std::size_t cube) { return cube % 2 == 1; }

void addMarble(Scene& scene, std::size_t cube, const Eigen::Vector3d& centre, Random& random) {
  const double u = random.between(-kMaxOffset, kMaxOffset), v = random.between(-kMaxOffset, kMaxOffset);
  const bool shot = isShotAt(cube);
  const Eigen::Vector3d from = shot ? Eigen::Vector3d(u, v, 2.0 * kEdge)
                                    : Eigen::Vector3d(u, 0.5 * kEdge + kThinRadius + kMarble + kDrop, v);
  btRigidBody& marble = addBall(scene, centre + from, kMarble, kMass, kMarbleColour);
  marble.setRollingFriction(btScalar(0.02));
  marble.setDamping(0, btScalar(0.5));
  if (shot) marble.setLinearVelocity(btVector3(0, 0, btScalar(-kShotSpeed)));
}

std::string failure(std::size_t marble, const char* what) {
  return "marble " + std::to_string(marble) + " " + what;
}

/// Checks that each dropped marble lies on its cube, and each shot one in front of its cube.
std::string checkMarbles(const Scene& scene) {
  for (std::size_t i = 0; i < scene.soft->bodyCount(); ++i) {
    const SoftBody& cube = *scene.soft->body(i);
    const PosedSurface surface = posed(cube);
    const Eigen::Vector3d marble = fromBullet(scene.world->movables[i]->getWorldTransform().getOrigin());
    const double gap = signedDistance(surface, marble) - kMarble;
    if (gap < -kMarble) return failure(i, "is inside its cube");
    if (isShotAt(i)) {
      if (marble.z() < middleOf(cube).z()) return failure(i, "has passed its cube");
      continue;
    }
    if (marble.y() < middleOf(cube).y()) return failure(i, "does not lie on top of its cube");
    if (gap < -kRestDent || gap > 3.0 * kThinRadius) return failure(i, "does not rest on a face");
  }
  return {};
}

std::string addCube(Scene& scene, const SharedNetwork& network, SoftBodySettings settings, double x,
                    Random& random) {
  const std::size_t index = scene.looks.size();
  settings.position = {x, 0.5 * kEdge + kThinRadius, 0.0};
  settings.rotation = Eigen::AngleAxisd(random.between(-0.2, 0.2), Eigen::Vector3d::UnitY());
  std::string reason = addBody(scene, network, settings, {paletteColour(index)});
  if (reason.empty()) addMarble(scene, index, settings.position, random);
  return reason;
}

SoftBodySettings cubeSettings(const SceneOptions& options) {
  SoftBodySettings settings;
  settings.pointRadius = kThinRadius;
  settings.damping = 3.0;
  apply(options, settings);
  return settings;
}

}  // namespace

SceneResult createMarble(const SceneOptions& options) {
  const Result<SharedNetwork> cube = cubeNetwork();
  if (!cube) return Error{cube.error()};
  const std::uint32_t count = options.count.value_or(2);
  const double half = 0.5 * kSpacing * double(count - 1);
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 8.0 + half);
  Random random(options.seed);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string reason = addCube(*scene, *cube, cubeSettings(options), kSpacing * i - half, random);
    if (!reason.empty()) return Error{reason};
  }
  const double halfView = half + 0.8 * kEdge;
  scene->view.box =
      Eigen::AlignedBox3d(Eigen::Vector3d(-halfView, 0, -0.6), Eigen::Vector3d(halfView, 1.7, 1.2));
  scene->view.direction = {0.5, 0.5, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkMarbles};
  watchMovablesApart(*scene, kDent);
  for (Check check : {checkCalm(0.02), checkShapes(0.03), checkRigidApart(kRestDent)})
    scene->endChecks.push_back(std::move(check));
  return scene;
}

}  // namespace limber::scenes
