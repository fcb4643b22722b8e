// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/scene_list.h"

namespace limber::scenes {
namespace {

constexpr double kRopeLength = 2.6;          // m
constexpr std::uint32_t kRopeSegments = 48;  // of 54 mm: the centre line stays outside the box's edges
constexpr double kRopeRadius = 0.025;        // m
constexpr double kRopeSpacing = 0.24;        // m between neighbours along z

const Eigen::Vector3f kBoxColour(0.80f, 0.81f, 0.83f);

Eigen::Vector3d boxHalfExtents(std::uint32_t ropes) {
  return {0.45, 0.55, 0.5 * kRopeSpacing * (double(ropes) + 0.6)};
}

void addBox(Scene& scene, const Eigen::Vector3d& half) {
  const Eigen::Vector3d centre(0.0, half.y(), 0.0);
  auto box = std::make_unique<btBoxShape>(toBullet(half));
  scene.rigidLooks.push_back({&addStatic(*scene.world, std::move(box), centre, 1.0), kBoxColour});
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
  addBox(*scene, half);
  Random random(options.seed);
  SoftBodySettings settings = ropeSettings(options);
  for (std::uint32_t i = 0; i < count; ++i) {
    setStart(settings, kRopeSpacing * (double(i) - 0.5 * double(count - 1)), random);
    BodyLook look;
    look.colour = paletteColour(i);
    const std::string reason = addBody(*scene, *network, settings, look);
    if (!reason.empty()) return Error{reason};
  }
  scene->view.box =
      Eigen::AlignedBox3d(Eigen::Vector3d(-0.8, 0.1, -half.z()), Eigen::Vector3d(0.8, 1.7, half.z()));
  scene->view.direction = {0.9, 0.55, 0.8};
  scene->endChecks = {checkFinite, checkAboveFloor, checkCalm(0.05), checkStretch(0.05),
                      checkHangsOver(half)};
  return scene;
}

}  // namespace limber::scenes
