// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "accuracy/scene.h"
#include "accuracy/signals.h"

#include <algorithm>

// The forces along a straight line of springs without sideways forces are linear in the displacements. So
// every motion is a sum of modes with known shapes and frequencies.

namespace limber::bench {
namespace {

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

Scene bar(const std::string& name, int links, double mass, double stiffness, const Eigen::VectorXd& start) {
  Scene scene;
  scene.name = name;
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

Signal modeSignal(const Trace& trace, const Eigen::VectorXd& shape) {
  Signal signal{trace.dt, {}};
  for (const Frame& frame : trace.frames)
    signal.samples.push_back(shape.dot(displacement(frame, static_cast<int>(shape.size()) - 1)));
  return signal;
}

double periodError(const Trace& trace, const Modes& modes, int mode) {
  const double measured = period(modeSignal(trace, modes.shapes.col(mode)));
  return std::isfinite(measured) ? std::abs(measured * modes.frequencies[mode] / (2 * M_PI) - 1) : 1.0;
}

/// The first three modes at once. They do not affect each other.
Scene chainModes(bool quick) {
  const int links = 16;
  const double mass = 0.1, stiffness = quick ? 400.0 : 100.0;
  const Modes modes = modesOf(links, stiffness, mass, false);
  const Eigen::VectorXd start = 0.02 * modes.shapes.leftCols(3).rowwise().sum();
  Scene scene = bar("modes of a chain", links, mass, stiffness, start);
  scene.seconds = wholeTicks(3.4 * 2 * M_PI / modes.frequencies[0]);
  scene.measures = {"mode 1", "mode 2", "mode 3"};
  scene.judge = [modes](const Trace& trace) {
    std::vector<double> errors;
    for (int mode = 0; mode < 3; ++mode) errors.push_back(periodError(trace, modes, mode));
    return errors;
  };
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
  Scene scene = bar("wave in a bar", links, mass, stiffness, start);
  scene.bodies[0].pins = {0, static_cast<std::uint32_t>(links)};
  scene.seconds = wholeTicks(44.0 / std::sqrt(stiffness / mass));
  scene.measures = {"shape", "arrival"};
  const auto arrival = [height](const Signal& signal) { return firstReaches(signal, 0.5 * 0.5 * height); };
  scene.judge = [=](const Trace& trace) {
    Signal probe{trace.dt, {}}, exact{trace.dt / 8, {}};
    for (const Frame& frame : trace.frames) probe.samples.push_back(displacement(frame, links)[48]);
    for (std::size_t i = 0; i <= 8 * (trace.frames.size() - 1); ++i)
      exact.samples.push_back(exactDisplacement(modes, start, exact.dt * static_cast<double>(i))[48]);
    const Eigen::VectorXd error =
        displacement(trace.last(), links) - exactDisplacement(modes, start, probe.end());
    const double rms = error.norm() / std::sqrt(links + 1.0);
    return std::vector<double>{rms / height, relativeError(arrival(probe), arrival(exact))};
  };
  return scene;
}

/// Measures dispersion: a wave of eight links oscillates with 2 sqrt(k / m) sin(q a / 2), where q a = pi / 4.
/// This is 2.6 % less than the speed of long waves gives.
Scene waveOfEight() {
  const int links = 64;
  const double mass = 0.01, stiffness = 10.0;
  const Modes modes = modesOf(links, stiffness, mass, true);
  const int eight = links / 4 - 1;
  Scene scene = bar("standing wave of 8 links", links, mass, stiffness, 0.004 * modes.shapes.col(eight));
  scene.bodies[0].pins = {0, static_cast<std::uint32_t>(links)};
  scene.seconds = wholeTicks(8.4 * 2 * M_PI / modes.frequencies[eight]);
  scene.measures = {"dispersion"};
  scene.judge = [=](const Trace& trace) { return std::vector<double>{periodError(trace, modes, eight)}; };
  return scene;
}

}  // namespace

void addWaves(std::vector<Scene>& scenes, bool quick) {
  scenes.push_back(chainModes(quick));
  scenes.push_back(travellingWave());
  scenes.push_back(waveOfEight());
}

}  // namespace limber::bench
