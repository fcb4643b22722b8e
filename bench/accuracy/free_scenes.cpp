// SPDX-License-Identifier: Zlib
// The forces along a straight line of springs without sideways forces are linear in the displacements. So
// every motion is a sum of modes with known shapes and frequencies.
#include "accuracy/accuracy_scene.h"
#include "results.h"

#include <algorithm>
#include <memory>
#include <optional>

namespace limber::bench {

namespace {

// --- one spring ---

constexpr double kElongation = 0.1;  // m, at the start

/// Returns the distance along x of the second point from `zero`.
Signal secondPoint(const Trace& trace, double zero) {
  return signalOf(trace, [=](const Frame& frame) { return frame.positions[0](0, 1) - zero; });
}

/// Returns the error of the period, or 1 without oscillation.
double periodError(const Signal& signal, double exact) {
  const double measured = period(signal);
  return std::isfinite(measured) ? std::abs(measured / exact - 1) : 1.0;
}

/// A mass on a pinned spring:  T = 2 pi sqrt(m / k).  Without oscillation both errors are 1.
Scene oscillator() {
  const double mass = 0.1, stiffness = 16.0, exact = 2 * M_PI * std::sqrt(mass / stiffness);
  Scene scene;
  scene.seconds = wholeTicks(10.5 * exact);
  scene.gravity.setZero();
  BodySetup body = bodyOf(pairNetwork(), 2 * mass, stiffness);
  body.pins = {0};
  body.positions = Eigen::Matrix3Xd::Zero(3, 2);
  body.positions(0, 1) = 1.0 + kElongation;
  scene.bodies = {body};
  scene.ordered = true;
  scene.periodTolerance = 1e-4;
  const auto amplitudeError = [exact](const Trace& trace) {
    return std::abs(amplitude(secondPoint(trace, 1.0), 9.4 * exact, 10.4 * exact) / kElongation - 1);
  };
  scene.measures = {{"period", [exact](const Trace& t) { return periodError(secondPoint(t, 1.0), exact); }},
                    {"amplitude", amplitudeError}};
  return scene;
}

/// Returns the period of a pendulum of length l released at the angle a:  T = 4 sqrt(l / g) K(sin(a / 2)).
/// K(k) is pi / (2 agm(1, sqrt(1 - k^2))).
double pendulumPeriod(double length, double angle) {
  double a = 1.0, b = std::cos(angle / 2);
  for (int i = 0; i < 30; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2 * M_PI * std::sqrt(length / kGravity) / a;
}

Eigen::Vector3d rodOf(const Eigen::Matrix3Xd& points) { return points.col(1) - points.col(0); }

/// Returns the rod's period, by fine integration of the equations of mass and spring.
double springPendulumPeriod(const BodySetup& body, const Scene& scene) {
  SpringSystem system = systemOf(body, scene.gravity);
  Signal x{1.0 / 120, {}};
  for (double t = 0; t < scene.seconds; t += x.dt) {
    x.samples.push_back(system.start.positions(0, 1));
    const State next = integrate(system, x.dt);
    system.start.positions = next.x;
    system.start.velocities = next.v;
  }
  return period(x);
}

/// Returns the largest deviation of the rod's length from  l + (m g / k)(3 cos phi - 2 cos a),  which
/// supports weight and centripetal force, over the largest stretch.
double stretchError(const Trace& trace, double sag, double angle) {
  double worst = 0.0;
  for (const Frame& frame : trace.frames) {
    const Eigen::Vector3d rod = rodOf(frame.positions[0]);
    const double cosine = -rod.y() / rod.norm();
    worst = std::max(worst, std::abs(rod.norm() - 1.0 - sag * (3 * cosine - 2 * std::cos(angle))));
  }
  return worst / (sag * (3 - 2 * std::cos(angle)));
}

/// A pendulum that starts with the stretch of its weight, so that the rod's length hardly oscillates.
Scene pendulum() {
  const double mass = 1.0, stiffness = 1e6, angle = M_PI / 3, sag = mass * kGravity / stiffness;
  Scene scene;
  scene.seconds = wholeTicks(5.3 * pendulumPeriod(1.0, angle));
  BodySetup body = bodyOf(pairNetwork(), 2 * mass, stiffness);
  body.pins = {0};
  const double length = 1.0 + sag * std::cos(angle);
  body.positions = Eigen::Matrix3Xd::Zero(3, 2);
  body.positions.col(1) = length * Eigen::Vector3d(std::sin(angle), -std::cos(angle), 0);
  const double exact = springPendulumPeriod(body, scene);
  scene.bodies = {body};
  scene.measures = {{"period", [=](const Trace& t) { return periodError(secondPoint(t, 0.0), exact); }},
                    {"stretch", [=](const Trace& t) { return stretchError(t, sag, angle); }}};
  scene.remark = format("period %.7f s; of a rigid rod, by the elliptic integral, %.7f s", exact,
                        pendulumPeriod(1.0, angle));
  return scene;
}

// --- hanging chains ---

constexpr int kLinks = 16;
constexpr double kDisturbance = 0.01;  // fraction of the sag by which the chain starts too long

/// Returns the rest positions of a hanging chain: link i carries all masses below it.
Eigen::Matrix3Xd restPositions(const SpringNetwork& network, double mass, double stiffness) {
  const auto count = static_cast<Eigen::Index>(network.restPoints.size());
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, count);
  double massBelow = mass;
  for (Eigen::Index i = 1; i < count; ++i) {
    const auto n = static_cast<std::size_t>(i);
    massBelow -= mass * network.massFractions[n - 1];
    const double rest = (network.restPoints[n] - network.restPoints[n - 1]).norm();
    points(1, i) = points(1, i - 1) - rest - massBelow * kGravity / stiffness;
  }
  return points;
}

/// A hanging chain that starts 1 % of its sag too long. It swings with `slowest` rad/s, damped by `ratio` of
/// critical damping. An engine without dampers along springs uses drag of the same strength.
Scene hangingChain(const SharedNetwork& network, double mass, double stiffness, double slowest, double ratio,
                   double seconds) {
  Scene scene;
  scene.seconds = seconds;
  scene.keepSeconds = 0.0;
  BodySetup body = bodyOf(network, mass, stiffness, 2 * ratio * stiffness / slowest);
  body.pins = {0};
  body.drag = std::min(2 * ratio * slowest, 2.0);
  const Eigen::Matrix3Xd rest = restPositions(*network, mass, stiffness);
  const double sag = -rest(1, kLinks) - 1.0;
  body.positions = rest;
  for (Eigen::Index i = 0; i <= kLinks; ++i)
    body.positions(1, i) += kDisturbance * (rest(1, i) + static_cast<double>(i) / kLinks);
  scene.bodies = {body};
  scene.measures = {{"sag", [sag](const Trace& trace) {
                       return relativeError(-trace.last().positions[0](1, kLinks) - 1.0, sag);
                     }}};
  return scene;
}

/// A chain of 17 points of 0.1 kg, the first pinned:  sag = (m g / k) M (M + 1) / 2.
Scene evenChain(int exponent) {
  const double mass = 0.1, stiffness = std::pow(10.0, exponent);
  const double slowest = 2 * std::sqrt(stiffness / mass) * std::sin(M_PI / (2 * (2 * kLinks + 1)));
  return hangingChain(chainNetwork(kLinks), mass * (kLinks + 1), stiffness, slowest, 0.2,
                      exponent < 4 ? 16.0 : 8.0);
}

Scene loadedChain() {
  const double heavier = 1e4, light = 0.01, stiffness = 1e6;
  const double slowest = std::sqrt(stiffness / kLinks / (heavier * light));
  return hangingChain(loadedChainNetwork(kLinks, heavier), light * (heavier + kLinks), stiffness, slowest,
                      0.05, 8.0);
}

// --- waves along a bar ---

/// Modes of N springs between N + 1 points of mass m.
struct Modes {
  Eigen::MatrixXd shapes;       ///< #points x #modes, columns orthonormal
  Eigen::VectorXd frequencies;  ///< #modes, rad/s
};

/// First end held, last free:   omega_j = 2 sqrt(k / m) sin((2 j - 1) pi / (2 (2 N + 1))).
/// Both held:                   omega_j = 2 sqrt(k / m) sin(j pi / (2 N)).
Modes modesOf(int links, double stiffness, double mass, bool lastHeld) {
  const int count = lastHeld ? links - 1 : links;
  Modes modes{Eigen::MatrixXd::Zero(links + 1, count), Eigen::VectorXd(count)};
  for (int j = 1; j <= count; ++j) {
    const double wave = lastHeld ? j * M_PI / links : (2 * j - 1) * M_PI / (2 * links + 1);  // rad per point
    modes.frequencies[j - 1] = 2 * std::sqrt(stiffness / mass) * std::sin(wave / 2);
    for (int i = 0; i < links + !lastHeld; ++i) modes.shapes(i, j - 1) = std::sin(wave * i);
    modes.shapes.col(j - 1).normalize();
  }
  return modes;
}

/// Returns the displacements along x after t seconds, starting at rest.
Eigen::VectorXd exactDisplacement(const Modes& modes, const Eigen::VectorXd& start, double t) {
  const Eigen::VectorXd amplitudes = modes.shapes.transpose() * start;
  return modes.shapes * (amplitudes.array() * (modes.frequencies * t).array().cos()).matrix();
}

Eigen::VectorXd displacement(const Frame& frame, int links) {
  return frame.positions[0].row(0).transpose() - Eigen::VectorXd::LinSpaced(links + 1, 0.0, 1.0);
}

Scene bar(int links, double mass, double stiffness, const Eigen::VectorXd& start) {
  Scene scene;
  scene.gravity.setZero();
  BodySetup body = bodyOf(barNetwork(links), mass * (links + 1), stiffness);
  body.pins = {0};
  body.positions = Eigen::Matrix3Xd::Zero(3, links + 1);
  body.positions.row(0) = (Eigen::VectorXd::LinSpaced(links + 1, 0.0, 1.0) + start).transpose();
  scene.bodies = {body};
  scene.ordered = true;
  scene.periodTolerance = 1e-4;
  return scene;
}

/// Returns the error of the period of a mode.
std::function<double(const Trace&)> modeError(const Modes& modes, int mode) {
  return [shape = Eigen::VectorXd(modes.shapes.col(mode)),
          exact = 2 * M_PI / modes.frequencies[mode]](const Trace& trace) {
    const int links = static_cast<int>(shape.size()) - 1;
    return periodError(signalOf(trace, [&](const Frame& f) { return shape.dot(displacement(f, links)); }),
                       exact);
  };
}

/// The first three modes at once. They do not affect each other.
Scene chainModes(bool quick) {
  const int links = 16;
  const double mass = 0.1, stiffness = quick ? 400.0 : 100.0;
  const Modes modes = modesOf(links, stiffness, mass, false);
  const Eigen::VectorXd start = 0.02 * modes.shapes.leftCols(3).rowwise().sum();
  Scene scene = bar(links, mass, stiffness, start);
  scene.seconds = wholeTicks(3.4 * 2 * M_PI / modes.frequencies[0]);
  for (int mode = 0; mode < 3; ++mode)
    scene.measures.push_back({format("mode %d", mode + 1), modeError(modes, mode)});
  return scene;
}

/// A hump splits into two waves, and one of them runs to the far end. Errors: the displacements at that time,
/// over the hump's height, and the time at which half the height of the wave passes three quarters of the
/// bar. A run of its own (waveOfEight) measures the frequency of a standing wave of eight links.
Scene travellingWave() {
  const int links = 64;
  const double mass = 0.01, stiffness = 10.0, height = 0.004;
  const Modes modes = modesOf(links, stiffness, mass, true);
  Eigen::VectorXd start = Eigen::VectorXd::Zero(links + 1);
  for (int i = 1; i < links; ++i) start[i] = height * std::exp(-std::pow((i - 16.0) / 4.0, 2));
  Scene scene = bar(links, mass, stiffness, start);
  scene.bodies[0].pins = {0, static_cast<std::uint32_t>(links)};
  scene.seconds = wholeTicks(44.0 / std::sqrt(stiffness / mass));
  const auto shape = [=](const Trace& trace) {
    const double end = trace.dt * static_cast<double>(trace.frames.size() - 1);
    const Eigen::VectorXd error = displacement(trace.last(), links) - exactDisplacement(modes, start, end);
    return error.norm() / std::sqrt(links + 1.0) / height;
  };
  const auto arrival = [=](const Trace& trace) {
    const Signal probe = signalOf(trace, [&](const Frame& frame) { return displacement(frame, links)[48]; });
    Signal exact{trace.dt / 8, {}};
    for (std::size_t i = 0; i <= 8 * (trace.frames.size() - 1); ++i)
      exact.samples.push_back(exactDisplacement(modes, start, exact.dt * static_cast<double>(i))[48]);
    return relativeError(firstReaches(probe, height / 4), firstReaches(exact, height / 4));
  };
  scene.measures = {{"shape", shape}, {"arrival", arrival}};
  return scene;
}

/// Measures dispersion: a wave of eight links oscillates with 2 sqrt(k / m) sin(q a / 2), where q a = pi / 4.
/// This is 2.6 % less than the speed of long waves gives.
Scene waveOfEight() {
  const int links = 64;
  const double mass = 0.01, stiffness = 10.0;
  const Modes modes = modesOf(links, stiffness, mass, true);
  const int eight = links / 4 - 1;
  Scene scene = bar(links, mass, stiffness, 0.004 * modes.shapes.col(eight));
  scene.bodies[0].pins = {0, static_cast<std::uint32_t>(links)};
  scene.seconds = wholeTicks(8.4 * 2 * M_PI / modes.frequencies[eight]);
  scene.measures = {{"dispersion", modeError(modes, eight)}};
  return scene;
}

// --- cubes, chains, blocks and cloth ---

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
  auto reference = std::make_shared<std::optional<State>>();
  const auto error = [reference, size, body = scene.bodies[0], gravity = scene.gravity,
                      seconds = scene.seconds](const Trace& trace) {
    if (!*reference) *reference = integrate(systemOf(body, gravity), seconds);
    const Eigen::Matrix3Xd exact = (*reference)->x + delay(seconds, trace.dt) * (*reference)->v;
    return shapeError(trace.last().positions[0], exact, size);
  };
  scene.measures = {{"shape", error}};
}

/// Eight cubes, as in a game. They are thrown with a spin and start slightly too large, so that their size
/// oscillates while they rotate: by 3 % at 1e3 N/m, and with the same energy when stiffer.
Scene spinningCubes(double stiffness) {
  Scene scene;
  BodySetup body = bodyOf(cubeNetwork(), 0.8, stiffness);
  body.settings.angularVelocity = 3.4 * Eigen::Vector3d(1, 2, 3).normalized();
  body.settings.linearVelocity = {1, 3, 0};
  body.positions = (1 + 0.03 * std::sqrt(1e3 / stiffness)) * startOf(body).positions;
  scene.bodies = {body};
  judgeByReference(scene, 1.0);
  scene.copies = 8;
  scene.finest = 64;  // the size oscillates 45 times in the second, 450 times when stiff
  return scene;
}

/// A chain pinned at one end and released from the horizontal.
Scene fallingChain(double stiffness) {
  Scene scene;
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
Scene cantilever(double stiffness) {
  Scene scene;
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
  BodySetup body = block(stiffness, 40.0);
  body.drag = 4.0;
  const double startHeight = tip(startOf(body).positions);
  const Eigen::Matrix3Xd rest = equilibrium(systemOf(body, scene.gravity));
  scene.seconds = 6.0;
  scene.keepSeconds = 0.0;
  scene.bodies = {body};
  const double sag = startHeight - tip(rest);
  scene.measures = {{"tip", [=](const Trace& trace) {
                       return relativeError(startHeight - tip(trace.last().positions[0]), sag);
                     }}};
  scene.remark = beamFormula(stiffness, sag);
  return scene;
}

/// A cloth of 24 x 24 points, released from the horizontal and held at two corners.
Scene cloth() {
  Scene scene;
  scene.seconds = 0.5;
  BodySetup body = bodyOf(clothNetwork(24), 0.02 * 576, 1e3);
  body.pins = {0, 23};
  scene.bodies = {body};
  judgeByReference(scene, 1.0);
  return scene;
}

}  // namespace

std::vector<SceneMaker> freeScenes(bool quick) {
  std::vector<SceneMaker> scenes = {{"oscillator", oscillator}, {"stiff pendulum", pendulum}};
  for (int exponent = 2; exponent <= 8; exponent += quick ? 3 : 1)
    scenes.push_back({"hanging chain 1e" + std::to_string(exponent), [=] { return evenChain(exponent); }});
  const std::vector<SceneMaker> others = {{"chain with 10 000 x end mass", loadedChain},
                                          {"modes of a chain", [=] { return chainModes(quick); }},
                                          {"wave in a bar", travellingWave},
                                          {"standing wave of 8 links", waveOfEight},
                                          {"spinning cubes 1e3", [] { return spinningCubes(1e3); }},
                                          {"spinning cubes 1e5", [] { return spinningCubes(1e5); }},
                                          {"falling chain 1e3", [] { return fallingChain(1e3); }},
                                          {"falling chain 1e5", [] { return fallingChain(1e5); }},
                                          {"block cantilever 1e3", [] { return cantilever(1e3); }},
                                          {"cloth", cloth}};
  scenes.insert(scenes.end(), others.begin(), others.end());
  if (quick) return scenes;
  scenes.push_back({"block cantilever 1e5", [] { return cantilever(1e5); }});
  scenes.push_back({"settled cantilever", settledBlock});
  return scenes;
}

}  // namespace limber::bench
