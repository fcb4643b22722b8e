// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "accuracy/scene.h"
#include "accuracy/spring_system.h"
#include "text_format.h"

#include <memory>
#include <optional>

namespace limber::bench {
namespace {

/// Returns the root mean square distance of the points from their exact positions, over the body's size.
double shapeError(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& exact, double size) {
  return (points - exact).norm() / std::sqrt(static_cast<double>(points.cols())) / size;
}

/// Returns the delay of the end of the ticks after `seconds`, because Bullet rounds the length of a tick.
double delay(double seconds, double dt) { return seconds * (double(static_cast<btScalar>(dt)) / dt - 1.0); }

/// Measures the errors at the scene's end against a Runge-Kutta solution of the same equations, which is
/// computed on first use.
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

/// Eight cubes, as in a game. They are thrown with a spin and start slightly too large, so that their size
/// oscillates while they rotate: by 3 % at 1e3 N/m, and with the same energy when stiffer.
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
  scene.finest = 64;  // the size oscillates 45 times in the second, 450 times when stiff
  return scene;
}

/// A chain pinned at one end and released from the horizontal.
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

/// A block of 10 x 4 x 4 points held at one end and released from the horizontal.
Scene cantilever(const std::string& name, double stiffness) {
  Scene scene;
  scene.name = name;
  scene.bodies = {block(stiffness, 0.0)};
  judgeByReference(scene, 9 * kSpacing);
  scene.finest = stiffness > 1e4 ? 64 : 8;  // the stiff block oscillates far faster than it sags
  return scene;
}

double tip(const Eigen::Matrix3Xd& points) { return points.row(1).rightCols(16).mean(); }

/// Returns the sag of the tip of a beam (Euler and Bernoulli):  tip = w L^4 / (8 E I).  Springs k along the
/// edges and diagonals of cells of size a give C11 = 4.33 k / a and C12 = 2.33 k / a, so
/// E = C11 - 2 C12^2 / (C11 + C12) = 2.7 k / a. The lattice is stiffer than a beam of three cells and softer
/// than one of four, because its outer springs belong fully to it.
std::string beamFormula(double stiffness, double sag) {
  const double length = 9 * kSpacing, weight = 0.02 * 160 * kGravity / length;
  const auto beamSag = [&](int cells) {
    const double inertia = std::pow(cells * kSpacing, 4) / 12;
    return weight * std::pow(length, 4) / (8 * 2.7 * stiffness / kSpacing * inertia);
  };
  return format("tip %.4f m by statics of the lattice; Euler-Bernoulli %.4f to %.4f m", sag, beamSag(4),
                beamSag(3));
}

/// The same block with dampers, until it is at rest.
Scene settledBlock() {
  const double stiffness = 1e4;
  Scene scene;
  scene.name = "settled cantilever";
  BodySetup body = block(stiffness, 40.0);
  body.drag = 4.0;
  const double startHeight = tip(startOf(body).positions);
  const Eigen::Matrix3Xd rest = equilibrium(systemOf(body, scene.gravity));
  scene.seconds = 6.0;
  scene.keepSeconds = 0.0;
  scene.bodies = {body};
  scene.measures = {"tip"};
  scene.judge = [=](const Trace& trace) {
    return std::vector<double>{
        relativeError(startHeight - tip(trace.last().positions[0]), startHeight - tip(rest))};
  };
  scene.remark = beamFormula(stiffness, startHeight - tip(rest));
  return scene;
}

/// A cloth of 24 x 24 points, released from the horizontal and held at two corners.
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
