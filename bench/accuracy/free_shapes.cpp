// SPDX-License-Identifier: Zlib
#include "accuracy/networks.h"
#include "accuracy/scene_list.h"
#include "accuracy/spring_system.h"
#include "text_format.h"

#include <memory>
#include <optional>

namespace limber::bench {
namespace {

/// Root mean square distance of the points from where they should be, over the body's size.
double shapeError(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& exact, double size) {
  return (points - exact).norm() / std::sqrt(static_cast<double>(points.cols())) / size;
}

/// Bullet's ticks are rounded: how much later than `seconds` they end together.
double delay(double seconds, double dt) { return seconds * (double(static_cast<btScalar>(dt)) / dt - 1.0); }

/// Errors at the scene's end against a Runge-Kutta solution of the same equations, found when first asked
/// for.
void judgeByReference(Scene& scene, double size) {
  scene.ordered = true;
  scene.keepSeconds = 0.0;
  scene.measures = {"shape"};
  auto reference = std::make_shared<std::optional<State>>();
  scene.judge = [reference, size, body = scene.bodies[0], gravity = scene.gravity,
                 seconds = scene.seconds](const Trace& trace) {
    if (!*reference) *reference = integrate(systemOf(body, gravity), seconds);
    const Eigen::Matrix3Xd exact = (*reference)->x + delay(seconds, trace.dt) * (*reference)->v;
    return std::vector<double>{shapeError(trace.last().positions[0], exact, size)};
  };
}

/// Thrown with a spin and a little too large, so that it breathes while it turns: 3 % at 1e3 N/m, and with as
/// much energy when stiffer. Eight of them, as in a game.
Scene spinningCubes(const std::string& name, double stiffness) {
  Scene scene;
  scene.name = name;
  BodySetup body = bodyOf(cubeNetwork(), 0.8, stiffness);
  body.settings.angularVelocity = 3.4 * Eigen::Vector3d(1, 2, 3).normalized();
  body.settings.linearVelocity = {1, 3, 0};
  body.positions = (1 + 0.03 * std::sqrt(1e3 / stiffness)) *
                   Eigen::Matrix3Xd::NullaryExpr(3, 8, [&](Eigen::Index r, Eigen::Index c) {
                     return body.network->restPoints[static_cast<std::size_t>(c)][r];
                   });
  scene.bodies = {body};
  judgeByReference(scene, 1.0);
  scene.copies = 8;
  scene.finest = 64;  // it breathes 45 times in the second, 450 when stiff
  return scene;
}

/// A chain pinned at one end and let go when level.
Scene fallingChain(const std::string& name, double stiffness) {
  Scene scene;
  scene.name = name;
  BodySetup body = bodyOf(barNetwork(16), 1.7, stiffness);
  body.pins = {0};
  scene.bodies = {body};
  judgeByReference(scene, 1.0);
  return scene;
}

constexpr double kSpacing = 0.1;  // m, of the block's points
constexpr int kBlock[] = {10, 4, 4};

BodySetup block(double stiffness, double damping) {
  BodySetup body =
      bodyOf(latticeNetwork(kBlock[0], kBlock[1], kBlock[2], kSpacing), 0.02 * 160, stiffness, damping);
  for (std::uint32_t i = 0; i < 16; ++i) body.pins.push_back(i);
  return body;
}

/// A block of 10 x 4 x 4 points held at one end and let go when level.
Scene cantilever(const std::string& name, double stiffness) {
  Scene scene;
  scene.name = name;
  scene.bodies = {block(stiffness, 0.0)};
  judgeByReference(scene, 9 * kSpacing);
  scene.finest = stiffness > 1e4 ? 64 : 8;  // what rings in the stiff one is far faster than what sags
  return scene;
}

double tip(const Eigen::Matrix3Xd& points) { return points.row(1).rightCols(16).mean(); }

/// Euler and Bernoulli:  tip = w L^4 / (8 E I).  Springs k along the edges and diagonals of cells of size a
/// make C11 = 4.33 k / a and C12 = 2.33 k / a, so E = C11 - 2 C12^2 / (C11 + C12) = 2.7 k / a. The lattice is
/// stiffer than a beam of three cells and softer than one of four: its outer springs belong to it whole.
std::string beamFormula(double stiffness, double sag) {
  const double length = 9 * kSpacing, weight = 0.02 * 160 * kGravity / length;
  const auto bend = [&](int cells) {
    const double inertia = std::pow(cells * kSpacing, 4) / 12;
    return weight * std::pow(length, 4) / (8 * 2.7 * stiffness / kSpacing * inertia);
  };
  return format("tip %.4f m by statics of the lattice; Euler-Bernoulli %.4f to %.4f m", sag, bend(4),
                bend(3));
}

/// The same with dampers, until it hangs still.
Scene settledBlock() {
  const double stiffness = 1e4;
  Scene scene;
  scene.name = "settled cantilever";
  BodySetup body = block(stiffness, 40.0);
  body.drag = 4.0;
  const double level = tip(startOf(body).positions);
  const Eigen::Matrix3Xd rest = equilibrium(systemOf(body, scene.gravity));
  scene.seconds = 6.0;
  scene.keepSeconds = 0.0;
  scene.bodies = {body};
  scene.measures = {"tip"};
  scene.judge = [=](const Trace& trace) {
    return std::vector<double>{relativeError(level - tip(trace.last().positions[0]), level - tip(rest))};
  };
  scene.remark = beamFormula(stiffness, level - tip(rest));
  return scene;
}

/// 24 x 24 points, let go level and hung by two corners.
Scene cloth() {
  Scene scene;
  scene.name = "cloth";
  scene.seconds = 0.5;
  BodySetup body = bodyOf(clothNetwork(24), 0.02 * 576, 1e3);
  body.pins = {0, 23};
  scene.bodies = {body};
  judgeByReference(scene, 1.0);
  return scene;
}

}  // namespace

void addFreeShapes(std::vector<Scene>& scenes, bool quick) {
  scenes.push_back(spinningCubes("spinning cubes 1e3", 1e3));
  scenes.push_back(spinningCubes("spinning cubes 1e5", 1e5));
  scenes.push_back(fallingChain("falling chain 1e3", 1e3));
  scenes.push_back(fallingChain("falling chain 1e5", 1e5));
  scenes.push_back(cantilever("block cantilever 1e3", 1e3));
  if (!quick) {
    scenes.push_back(cantilever("block cantilever 1e5", 1e5));
    scenes.push_back(settledBlock());
  }
  scenes.push_back(cloth());
}

}  // namespace limber::bench
