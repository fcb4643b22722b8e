// SPDX-License-Identifier: Zlib
// Softness by itself: a jelly that wobbles on a plate, balls of five stiffnesses, a balloon between plates.
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace limber::scenes {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad
const Eigen::Vector3f kPlateGrey(0.55f, 0.57f, 0.62f);

/// A point of a profile: distance from the axis y and height, m.
struct ProfilePoint {
  double radius, height;
};

/// Returns the surface that a profile describes about the y axis, from its foot to its top; both ends are on
/// the axis. `flutes`: share of the radius by which it swings, twelve times around.
TriangleMesh turned(const std::vector<ProfilePoint>& profile, std::uint32_t segments, double flutes) {
  TriangleMesh mesh;
  const auto rows = static_cast<std::uint32_t>(profile.size() - 2);
  mesh.positions.push_back({0.0, profile.front().height, 0.0});
  for (std::uint32_t r = 1; r <= rows; ++r)
    for (std::uint32_t s = 0; s < segments; ++s) {
      const double angle = kTurn * s / segments;
      const double radius = profile[r].radius * (1.0 + flutes * std::cos(12.0 * angle));
      mesh.positions.push_back({radius * std::cos(angle), profile[r].height, -radius * std::sin(angle)});
    }
  const auto top = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back({0.0, profile.back().height, 0.0});
  const auto at = [&](std::uint32_t row, std::uint32_t s) { return 1 + row * segments + s % segments; };
  for (std::uint32_t s = 0; s < segments; ++s) {
    mesh.triangles.push_back({0, at(0, s + 1), at(0, s)});
    for (std::uint32_t r = 0; r + 1 < rows; ++r) {
      mesh.triangles.push_back({at(r, s), at(r, s + 1), at(r + 1, s)});
      mesh.triangles.push_back({at(r, s + 1), at(r + 1, s + 1), at(r + 1, s)});
    }
    mesh.triangles.push_back({at(rows - 1, s), at(rows - 1, s + 1), top});
  }
  return mesh;
}

TriangleMesh ballOf(double radius, std::uint32_t segments) {
  std::vector<ProfilePoint> profile;
  const std::uint32_t rows = segments / 2;
  for (std::uint32_t r = 0; r <= rows; ++r) {
    const double angle = 0.5 * kTurn * r / rows;
    profile.push_back({radius * std::sin(angle), -radius * std::cos(angle)});
  }
  return turned(profile, segments, 0.0);
}

Result<SharedNetwork> filled(const TriangleMesh& mesh, std::uint32_t points) {
  MaterialMesh filling;
  filling.points = points;
  return buildMaterialNetwork(mesh, filling);
}

std::string addFilled(Scene& scene, const SharedNetwork& network, const Material& material,
                      const Eigen::Vector3d& position, const BodyLook& look, const SceneOptions& options) {
  SoftBodySettings settings;
  settings.position = position;
  settings.friction = 0.9;
  const Result<SoftBodySettings> made = withMaterial(*network, material, settings);
  if (!made) return made.error();
  settings = *made;
  apply(options, settings);
  return addBody(scene, network, settings, look);
}

// --- wobble ------------------------------------------------------------------------------------------------

constexpr double kShakeUntil = 1.2, kShakePeriod = 0.4, kShake = 0.05;  // s, s, m
constexpr double kDishHalf = 0.36, kDishHeight = 0.06;                  // m

TriangleMesh pudding() {
  std::vector<ProfilePoint> profile{{0.0, 0.0}, {0.10, 0.0}, {0.20, 0.0}, {0.225, 0.01}};
  for (int i = 1; i <= 7; ++i) profile.push_back({0.225 - 0.06 * i / 7.0, 0.01 + 0.24 * i / 7.0});
  for (const ProfilePoint p : {ProfilePoint{0.15, 0.275}, {0.11, 0.285}, {0.06, 0.285}, {0.0, 0.285}})
    profile.push_back(p);
  return turned(profile, 48, 0.05);
}

double shakenTo(double time) {
  return time < kShakeUntil ? kShake * std::sin(kTurn * time / kShakePeriod) : 0.0;
}

std::string checkOnDish(const Scene& scene) {
  const Eigen::Vector3d middle = middleOf(*scene.soft->body(0));
  if (std::hypot(middle.x(), middle.z()) > 0.1) return "the jelly has slid off the middle of its dish";
  return middle.y() < kDishHeight + 0.08 ? "the jelly has collapsed" : "";
}

}  // namespace

SceneResult createWobble(const SceneOptions& options) {
  const Result<SharedNetwork> network = filled(pudding(), 350);
  if (!network) return Error{network.error()};
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 4.0);
  const BodyLook look{{0.70f, 0.07f, 0.15f}, false, false, Finish::Jelly};
  const double lift = 1e-3 + Random(options.seed).between(0.0, 1e-3);
  if (std::string reason = addFilled(*scene, *network, {1.5e4, 0.4, 1000.0, 0.006},
                                     {0.0, kDishHeight + lift, 0.0}, look, options);
      !reason.empty())
    return Error{reason};
  btRigidBody& dish = addBox(*scene, {0.0, 0.5 * kDishHeight, 0.0}, {kDishHalf, 0.5 * kDishHeight, kDishHalf},
                             0.0, {0.92f, 0.92f, 0.90f});
  scene->beforeTick = [&dish](Scene& now) {
    moveTo(dish, {shakenTo(double(now.ticks + 1) / double(kTicksPerSecond)), 0.5 * kDishHeight, 0.0});
  };
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-0.42, 0, -0.36), Eigen::Vector3d(0.42, 0.36, 0.36));
  scene->view.direction = {0.25, 0.4, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkOnDish, checkCalm(0.02), checkShapes(0.1)};
  return scene;
}

// --- stiffness ---------------------------------------------------------------------------------------------

namespace {

constexpr std::array<double, 5> kModuli{1.5e4, 6e4, 2.4e5, 9.6e5, 3.84e6};  // Pa
/// s sqrt(Pa): a quarter of the critical damping for each ball.
constexpr double kDamping = 2.5;
constexpr double kDropRadius = 0.35, kDropHeight = 1.3, kDropSpacing = 0.95;  // m

/// Checks that stiffer balls, which sag less, are higher.
std::string checkOrder(const Scene& scene) {
  for (std::size_t i = 1; i < scene.soft->bodyCount(); ++i)
    if (middleOf(*scene.soft->body(i)).y() < middleOf(*scene.soft->body(i - 1)).y())
      return "ball " + std::to_string(i) + " is stiffer than the one before, but sags more";
  return {};
}

}  // namespace

SceneResult createStiffness(const SceneOptions& options) {
  const Result<SharedNetwork> network = filled(ballOf(kDropRadius, 32), 250);
  if (!network) return Error{network.error()};
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 6.0);
  Random random(options.seed);
  for (std::size_t i = 0; i < kModuli.size(); ++i) {
    const BodyLook look{paletteColour(i), true};
    const Eigen::Vector3d at(kDropSpacing * (double(i) - 2.0), kDropHeight + random.between(0.0, 1e-3), 0.0);
    const std::string reason = addFilled(
        *scene, *network, {kModuli[i], 0.4, 500.0, kDamping / std::sqrt(kModuli[i])}, at, look, options);
    if (!reason.empty()) return Error{reason};
    // as of a ball of felt
    scene->soft->body(i)->surfaceObject()->setRollingFriction(btScalar(0.05));
  }
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-2.4, 0, -0.5), Eigen::Vector3d(2.4, 1.3, 0.5));
  scene->view.direction = {0.0, 0.3, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkCalmOrRolling(0.05), checkShapes(0.2)};
  if (!options.stiffness) scene->endChecks.push_back(checkOrder);
  return scene;
}

// --- balloon -----------------------------------------------------------------------------------------------

namespace {

constexpr double kBalloonRadius = 0.5, kClosed = 0.55, kOpen = 1.3;  // m, of the gap between the plates

/// Returns the gap between the plates: closes within 3 s, opens again after 5 s.
double gapAt(double time) {
  const double closing = std::clamp(time / 3.0, 0.0, 1.0), opening = std::clamp(time - 5.0, 0.0, 1.0);
  return kOpen + (kClosed - kOpen) * (closing - opening);
}

double volumeOf(const SoftBody& body) {
  double sum = 0.0;
  for (const Triangle& t : body.network().surface)
    sum += body.position(t[0]).dot(body.position(t[1]).cross(body.position(t[2]))) / 6.0;
  return sum;
}

}  // namespace

SceneResult createBalloon(const SceneOptions& options) {
  NetworkSettings hollow;
  hollow.braces = BraceRule::None;
  const Result<SharedNetwork> network = buildNetwork(ballOf(kBalloonRadius, 32), hollow);
  if (!network) return Error{network.error()};
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 4.0);
  SoftBodySettings settings;
  settings.totalMass = 0.1;
  settings.extensionStiffness = settings.compressionStiffness = 400.0;
  settings.damping = 0.2;
  settings.pressure = 3000.0;
  settings.ambientPressure = 101325.0;
  settings.friction = 0.8;
  settings.pointRadius = 0.01;
  settings.position = {0.0, kBalloonRadius + 0.03 + Random(options.seed).between(0.0, 1e-3), 0.0};
  apply(options, settings);
  const BodyLook look{{0.90f, 0.16f, 0.20f}, true, false, Finish::Jelly};
  if (std::string reason = addBody(*scene, *network, settings, look); !reason.empty()) return Error{reason};
  btRigidBody& plate = addBox(*scene, {0.0, kOpen + 0.04, 0.0}, {0.7, 0.04, 0.7}, 0.0, kPlateGrey);
  const double filledVolume = volumeOf(*scene->soft->body(0));
  scene->beforeTick = [&plate](Scene& now) {
    moveTo(plate, {0.0, gapAt(double(now.ticks + 1) / double(kTicksPerSecond)) + 0.04, 0.0});
  };
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-0.9, 0, -0.7), Eigen::Vector3d(0.9, 1.2, 0.7));
  scene->view.direction = {0.2, 0.22, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkRigidApart(0.01), checkCalmOrRolling(0.1),
                      [filledVolume](const Scene& now) {
                        return volumeOf(*now.soft->body(0)) < filledVolume
                                   ? std::string(
                                         "the balloon is smaller than before, although it is open to "
                                         "its pressure again")
                                   : std::string();
                      }};
  return scene;
}

}  // namespace limber::scenes
