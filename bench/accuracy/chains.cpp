// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "accuracy/scene.h"

#include <algorithm>

namespace limber::bench {
namespace {

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
Scene hangingChain(const std::string& name, const SharedNetwork& network, double mass, double stiffness,
                   double slowest, double ratio, double seconds) {
  Scene scene;
  scene.name = name;
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
  scene.measures = {"sag"};
  scene.judge = [sag](const Trace& trace) {
    return std::vector<double>{relativeError(-trace.last().positions[0](1, kLinks) - 1.0, sag)};
  };
  return scene;
}

/// A chain of 17 points of 0.1 kg, the first pinned:  sag = (m g / k) M (M + 1) / 2.
Scene evenChain(int exponent) {
  const double mass = 0.1, stiffness = std::pow(10.0, exponent);
  const double slowest = 2 * std::sqrt(stiffness / mass) * std::sin(M_PI / (2 * (2 * kLinks + 1)));
  return hangingChain("hanging chain 1e" + std::to_string(exponent), chainNetwork(kLinks),
                      mass * (kLinks + 1), stiffness, slowest, 0.2, exponent < 4 ? 16.0 : 8.0);
}

Scene loadedChain() {
  const double heavier = 1e4, light = 0.01, stiffness = 1e6;
  const double slowest = std::sqrt(stiffness / kLinks / (heavier * light));
  return hangingChain("chain with 10 000 x end mass", loadedChainNetwork(kLinks, heavier),
                      light * (heavier + kLinks), stiffness, slowest, 0.05, 8.0);
}

}  // namespace

void addChains(std::vector<Scene>& scenes, bool quick) {
  for (int exponent = 2; exponent <= 8; exponent += quick ? 3 : 1) scenes.push_back(evenChain(exponent));
  scenes.push_back(loadedChain());
}

}  // namespace limber::bench
