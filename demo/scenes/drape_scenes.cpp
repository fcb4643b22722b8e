// SPDX-License-Identifier: Zlib
// Ropes over a box, and cloths over balls.

#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/scene_list.h"

#include <algorithm>

namespace limber::scenes {

// --- ropes -------------------------------------------------------------------------------------------------

namespace {

constexpr double kRopeLength = 2.6;          // m
constexpr std::uint32_t kRopeSegments = 48;  // of 54 mm: the centre line stays outside the box's edges
constexpr double kRopeRadius = 0.025;        // m
constexpr double kRopeSpacing = 0.24;        // m between neighbours along z

const Eigen::Vector3f kBoxColour(0.80f, 0.81f, 0.83f);

Eigen::Vector3d boxHalfExtents(std::uint32_t ropes) {
  return {0.45, 0.55, 0.5 * kRopeSpacing * (double(ropes) + 0.6)};
}

/// Sets the start of a rope: level, across the box, a little off its centre.
void setStart(SoftBodySettings& settings, double z, Random& random) {
  const double yaw = random.between(-0.05, 0.05);
  const double shift = random.between(-0.12, 0.12);
  const double height = 1.4 + random.between(0.0, 0.6);
  settings.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY());
  // a rope begins at its network's origin
  settings.position =
      Eigen::Vector3d(shift, height, z) - settings.rotation * Eigen::Vector3d(0.5 * kRopeLength, 0, 0);
}

SoftBodySettings ropeSettings(const SceneOptions& options) {
  SoftBodySettings settings;
  settings.totalMass = 0.5;
  settings.extensionStiffness = settings.compressionStiffness = 5000.0;
  settings.damping = 1.0;
  settings.pointRadius = kRopeRadius;
  settings.friction = 0.5;
  settings.flow.linearDrag = 0.7;
  apply(options, settings);
  return settings;
}

/// Checks that both ends hang beside the box, below its top, and the middle lies on it.
Check checkHangsOver(const Eigen::Vector3d& half) {
  return [half](const Scene& scene) {
    const double top = 2.0 * half.y();
    for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
      const SoftBody& rope = *scene.soft->body(b);
      const Eigen::Vector3d first = rope.position(0);
      const Eigen::Vector3d last = rope.position(rope.pointCount() - 1);
      const std::string name = "rope " + std::to_string(b);
      if (first.x() > -half.x() || last.x() < half.x()) return name + " does not lie across the box";
      if (first.y() > top - 0.2 || last.y() > top - 0.2) return name + " does not hang down on both sides";
      if (rope.position(rope.pointCount() / 2).y() < top - kRopeRadius)
        return name + " does not lie on the box";
    }
    return std::string();
  };
}

}  // namespace

SceneResult createRope(const SceneOptions& options) {
  RopeSettings shape;
  shape.length = kRopeLength;
  shape.segments = kRopeSegments;
  const Result<SharedNetwork> network = buildRope(shape);
  if (!network) return Error{network.error()};

  const std::uint32_t count = options.count.value_or(5);
  const Eigen::Vector3d half = boxHalfExtents(count);
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 8.0 + half.z());
  addStatic(*scene, std::make_unique<btBoxShape>(toBullet(half)), {0.0, half.y(), 0.0}, 1.0, kBoxColour);
  Random random(options.seed);
  SoftBodySettings settings = ropeSettings(options);
  for (std::uint32_t i = 0; i < count; ++i) {
    setStart(settings, kRopeSpacing * (double(i) - 0.5 * double(count - 1)), random);
    const std::string reason = addBody(*scene, *network, settings, {paletteColour(i)});
    if (!reason.empty()) return Error{reason};
  }
  scene->view.box =
      Eigen::AlignedBox3d(Eigen::Vector3d(-0.8, 0.1, -half.z()), Eigen::Vector3d(0.8, 1.7, half.z()));
  scene->view.direction = {0.9, 0.55, 0.8};
  scene->endChecks = {checkFinite, checkAboveFloor, checkCalm(0.05), checkStretch(0.05),
                      checkHangsOver(half)};
  return scene;
}

// --- cloths ------------------------------------------------------------------------------------------------

namespace {

constexpr std::uint32_t kCells = 32;   // along each side
constexpr double kClothWidth = 2.4;    // m
constexpr double kClothRadius = 0.02;  // m, of each point mass
constexpr double kBallRadius = 0.75;   // m
constexpr double kSpacing = 3.2;       // m from ball to ball when there are several
const Eigen::Vector3f kBallColour(0.92f, 0.92f, 0.92f);

SoftBodySettings clothSettings(const SceneOptions& options) {
  SoftBodySettings settings;
  settings.totalMass = 0.6;
  settings.extensionStiffness = settings.compressionStiffness = 1000.0;
  settings.damping = 0.5;
  settings.pointRadius = kClothRadius;
  settings.friction = 0.5;
  // in air it would sail down flat, and its corners could stay up
  settings.flow.drag = 0.0;
  settings.flow.linearDrag = 0.7;
  apply(options, settings);
  return settings;
}

/// Checks that the cloth lies on its ball and its corners hang below the ball's centre.
std::string drapes(const SoftBody& cloth, const Eigen::Vector3d& ball) {
  double top = cloth.position(0).y();
  for (std::uint32_t i = 0; i < cloth.pointCount(); ++i) top = std::max(top, cloth.position(i).y());
  if (top < ball.y() + kBallRadius) return "does not lie on the sphere";
  if (top > ball.y() + kBallRadius + 0.1) return "does not touch the top of the sphere";
  constexpr std::uint32_t kRow = kCells + 1;
  for (const std::uint32_t corner : {0u, kCells, kCells * kRow, kCells * kRow + kCells})
    if (cloth.position(corner).y() > ball.y()) return "does not hang down at all its corners";
  return {};
}

std::string checkDrapes(const Scene& scene) {
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const std::string reason =
        drapes(*scene.soft->body(b), fromBullet(scene.rigidLooks[b].body->getWorldTransform().getOrigin()));
    if (!reason.empty()) return "cloth " + std::to_string(b) + " " + reason;
  }
  return {};
}

/// Adds a ball on the floor and a cloth above it, with a small random rotation.
std::string addPair(Scene& scene, const SharedNetwork& network, SoftBodySettings settings,
                    const Eigen::Vector3d& at, Random& random) {
  const Eigen::Vector3d ball = at + Eigen::Vector3d(0.0, kBallRadius, 0.0);
  addStatic(scene, std::make_unique<btSphereShape>(btScalar(kBallRadius)), ball, 1.0, kBallColour);
  settings.position = ball + Eigen::Vector3d(0.0, kBallRadius + 0.5, 0.0);
  settings.rotation = Eigen::AngleAxisd(random.between(0.1, 0.5), Eigen::Vector3d::UnitY());
  scene.endChecks.push_back(checkOutsideBall(ball, kBallRadius, 0.5 * kClothRadius));
  return addBody(scene, network, settings, clothLook(paletteColour(scene.looks.size())));
}

}  // namespace

SceneResult createCloth(const SceneOptions& options) {
  const Result<SharedNetwork> network = clothNetwork(kClothWidth, kClothWidth, kCells, kCells);
  if (!network) return Error{network.error()};
  const std::uint32_t count = options.count.value_or(1);
  const std::uint32_t columns = gridColumns(count);
  const double half = 0.5 * kSpacing * double(columns - 1);

  auto scene = std::make_unique<Scene>();
  scene->endChecks = {checkFinite, checkAboveFloor};
  addFloor(*scene, 8.0 + 2.0 * half);
  Random random(options.seed);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Eigen::Vector3d at(kSpacing * (i % columns) - half, 0.0, kSpacing * (i / columns) - half);
    const std::string reason = addPair(*scene, *network, clothSettings(options), at, random);
    if (!reason.empty()) return Error{reason};
  }
  const double halfView = half + 0.36 * kClothWidth;
  scene->view.box = Eigen::AlignedBox3d(Eigen::Vector3d(-halfView, 0.0, -halfView),
                                        Eigen::Vector3d(halfView, 1.7, halfView));
  scene->endChecks.push_back(checkCalm(0.05));
  scene->endChecks.push_back(checkStretch(0.05));
  scene->endChecks.push_back(checkDrapes);
  return scene;
}

}  // namespace limber::scenes
