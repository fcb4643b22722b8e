// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <algorithm>
#include <cmath>

namespace limber::scenes {
namespace {

constexpr std::uint32_t kColumns = 28, kRows = 26;  // cells
constexpr double kWidth = 2.0, kHeight = 1.95;      // m
constexpr double kTop = 2.0;                        // m, of the pinned edge
constexpr double kRadius = 0.015;                   // m, of each point
constexpr double kSpacing = 2.6;                    // m from curtain to curtain
constexpr double kBall = 0.2, kBallMass = 0.2;      // m, kg
constexpr double kBallSpeed = 2.0;                  // m/s
// two of it fit between four points; its displacement in a tick is about its radius, so that a check once per
// tick sees it pass
constexpr double kMarble = 0.015, kMarbleMass = 0.01;    // m, kg
constexpr double kMarbleFrom = 0.5, kMarbleSpeed = 1.0;  // m, m/s
constexpr double kBallFrom = 1.2;                        // m before the curtain
constexpr double kBoxHalf = 0.2;                         // m
constexpr double kBoxAway = 0.8, kBoxThrough = -0.3;     // m, positions where the pushing box reverses
constexpr double kPushSeconds = 4.0;                     // time of the pushing motion, forth and back
constexpr double kDent = 0.05;                           // m, allowed depth of a rigid body in the cloth
const Eigen::Vector3f kBallColour(0.92f, 0.92f, 0.92f), kBoxColour(0.45f, 0.47f, 0.52f),
    kMarbleColour(1.0f, 0.75f, 0.05f);

/// Boxes and middles have the index of their curtain; each curtain has two balls.
struct Curtains {
  std::vector<btRigidBody*> boxes, balls;
  std::vector<double> middles;  ///< m, x of each curtain
};

/// Returns z of the pushing box, m: a smooth motion through the curtain's plane and back, then at rest.
double boxPosition(double seconds) {
  constexpr double kPi = 3.141592653589793;
  const double phase = std::min(seconds / kPushSeconds, 1.0);
  return kBoxAway + (kBoxThrough - kBoxAway) * 0.5 * (1.0 - std::cos(2.0 * kPi * phase));
}

Eigen::Vector3d boxCentre(double x, double seconds) { return {x, 1.1, boxPosition(seconds)}; }

btRigidBody* throwBall(Scene& scene, const Eigen::Vector3d& from, double speed, double radius, double mass,
                       const Eigen::Vector3f& colour) {
  btRigidBody& ball = addBall(scene, from, radius, mass, colour);
  ball.setLinearVelocity(btVector3(0, btScalar(1), btScalar(-speed)));
  ball.setRollingFriction(btScalar(0.02));
  ball.setDamping(btScalar(0.1), btScalar(0.5));
  return &ball;
}

/// A box, two balls, and a marble that only faces can stop. The marble may end behind the curtain, whose hem
/// swings over it; watchMovablesApart() checks that it does not pass through.
void addPushers(Scene& scene, Curtains& curtains, double x, Random& random) {
  curtains.middles.push_back(x);
  curtains.boxes.push_back(
      &addBox(scene, boxCentre(x, 0.0), Eigen::Vector3d::Constant(kBoxHalf), 0.0, kBoxColour));
  const auto height = [&] { return 1.3 + random.between(0.0, 0.3); };
  for (const double side : {-0.65, 0.65})
    curtains.balls.push_back(
        throwBall(scene, {x + side, height(), kBallFrom}, kBallSpeed, kBall, kBallMass, kBallColour));
  throwBall(scene, {x - 0.3, height(), kMarbleFrom}, kMarbleSpeed, kMarble, kMarbleMass, kMarbleColour);
}

std::string addCurtain(Scene& scene, const SharedNetwork& network, SoftBodySettings settings, double x,
                       Random& random) {
  // upright, its first row on top
  const double yaw = random.between(-0.01, 0.01);
  settings.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) *
                      Eigen::AngleAxisd(0.5 * 3.141592653589793, Eigen::Vector3d::UnitX());
  settings.position = {x, kTop - 0.5 * kHeight, 0.0};
  const BodyLook look = clothLook(paletteColour(scene.looks.size()));
  const std::string reason = addBody(scene, network, settings, look);
  if (!reason.empty()) return reason;
  SoftBody& cloth = *scene.soft->body(scene.soft->bodyCount() - 1);
  for (std::uint32_t i = 0; i <= kColumns; ++i) cloth.pin(i);
  return {};
}

/// Checks that the curtains hang from their pins and the balls are on their initial side.
Check checkCurtains(const Curtains& curtains) {
  return [curtains](const Scene& scene) {
    for (std::size_t c = 0; c < scene.soft->bodyCount(); ++c) {
      const SoftBody& cloth = *scene.soft->body(c);
      const std::string name = "curtain " + std::to_string(c);
      for (std::uint32_t i = 0; i <= kColumns; ++i)
        if (std::abs(cloth.position(i).y() - kTop) > 1e-3) return name + " does not hang from its pins";
      const Eigen::Vector3d hem = cloth.position(cloth.pointCount() - 1 - kColumns / 2);
      if (hem.y() > kTop - 0.9 * kHeight) return name + " does not hang down";
    }
    for (std::size_t b = 0; b < curtains.balls.size(); ++b)
      if (double(curtains.balls[b]->getWorldTransform().getOrigin().z()) < 0.0)
        return "ball " + std::to_string(b) + " has passed through";
    return std::string();
  };
}

SoftBodySettings clothSettings(const SceneOptions& options) {
  SoftBodySettings settings;
  settings.totalMass = 1.0;
  settings.damping = 0.5;
  settings.pointRadius = kRadius;
  settings.flow.linearDrag = 1.6;
  apply(options, settings);
  return settings;
}

}  // namespace

SceneResult createCurtain(const SceneOptions& options) {
  const Result<SharedNetwork> network = clothNetwork(kWidth, kHeight, kColumns, kRows);
  if (!network) return Error{network.error()};
  const std::uint32_t count = options.count.value_or(1);
  const double half = 0.5 * kSpacing * double(count - 1);
  auto scene = std::make_unique<Scene>();
  addFloor(*scene, 10.0 + half);
  Random random(options.seed);
  Curtains curtains;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double x = kSpacing * i - half;
    const std::string reason = addCurtain(*scene, *network, clothSettings(options), x, random);
    if (!reason.empty()) return Error{reason};
    addPushers(*scene, curtains, x, random);
  }
  scene->beforeTick = [curtains](Scene& now) {
    const double seconds = double(now.ticks + 1) / double(kTicksPerSecond);
    for (std::size_t i = 0; i < curtains.boxes.size(); ++i)
      moveTo(*curtains.boxes[i], boxCentre(curtains.middles[i], seconds));
  };
  const double halfView = half + 0.6 * kWidth;
  scene->view.box =
      Eigen::AlignedBox3d(Eigen::Vector3d(-halfView, 0, -0.6), Eigen::Vector3d(halfView, kTop, 1.2));
  scene->view.direction = {0.8, 0.4, 1.0};
  scene->endChecks = {checkFinite, checkAboveFloor, checkCurtains(curtains)};
  watchMovablesApart(*scene, kDent);
  scene->endChecks.push_back(checkStretch(0.1));
  scene->endChecks.push_back(checkCalm(0.05));
  return scene;
}

}  // namespace limber::scenes
