// SPDX-License-Identifier: Zlib
#include "stability/case_parts.h"

#include <cmath>

namespace limber::bench {
namespace {

constexpr double kDamping = 0.3;

/// An initial shape that is not the rest shape.
struct Start {
  const char* name;
  Eigen::Matrix3Xd (*make)(const Eigen::Matrix3Xd& rest, Dice& dice);
  bool inBalance = false;  ///< two points coincide with equal forces: no force separates them
};

Eigen::Matrix3Xd noise(const Eigen::Matrix3Xd& rest, Dice& dice) { return dice.vectors(rest.cols(), 1e-3); }

/// Projects all points onto a plane; some of them then coincide.
Eigen::Matrix3Xd flattened(const Eigen::Matrix3Xd& rest, Dice&) {
  Eigen::Matrix3Xd x = rest;
  x.row(1).setZero();
  return x;
}

Eigen::Matrix3Xd nearlyFlat(const Eigen::Matrix3Xd& rest, Dice& dice) {
  return flattened(rest, dice) + noise(rest, dice);
}

/// Inverts the body along one axis and doubles its length.
Eigen::Matrix3Xd inverted(const Eigen::Matrix3Xd& rest, Dice& dice) {
  Eigen::Matrix3Xd x = rest;
  x.row(0) *= -2.0;
  return x + noise(rest, dice);
}

/// Moves one corner through the body and beyond the opposite corner.
Eigen::Matrix3Xd cornerThrough(const Eigen::Matrix3Xd& rest, Dice& dice) {
  Eigen::Matrix3Xd x = rest + noise(rest, dice);
  x.col(0) = 1.5 * rest.col(7);
  return x;
}

/// Moves the lower four points above the upper four.
Eigen::Matrix3Xd halfThrough(const Eigen::Matrix3Xd& rest, Dice& dice) {
  Eigen::Matrix3Xd x = rest + noise(rest, dice);
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    if (rest(1, i) < 0.0) x(1, i) += 1.6;
  return x;
}

Eigen::Matrix3Xd randomised(const Eigen::Matrix3Xd& rest, Dice& dice) {
  return dice.vectors(rest.cols(), 0.5);
}

Eigen::Matrix3Xd scattered(const Eigen::Matrix3Xd& rest, Dice& dice) {
  return dice.vectors(rest.cols(), 3.0);
}

Eigen::Matrix3Xd onePair(const Eigen::Matrix3Xd& rest, Dice&) {
  Eigen::Matrix3Xd x = rest;
  x.col(1) = x.col(0);
  return x;
}

Eigen::Matrix3Xd allPairs(const Eigen::Matrix3Xd& rest, Dice&) {
  Eigen::Matrix3Xd x = rest;
  for (Eigen::Index i = 0; i < 8; i += 2) x.col(i + 1) = x.col(i);
  return x;
}

Eigen::Matrix3Xd sevenInOne(const Eigen::Matrix3Xd& rest, Dice&) {
  Eigen::Matrix3Xd x = rest;
  for (Eigen::Index i = 1; i < 8; ++i) x.col(i) = x.col(1);
  return x;
}

Eigen::Matrix3Xd allInOne(const Eigen::Matrix3Xd& rest, Dice&) {
  return Eigen::Matrix3Xd::Zero(3, rest.cols());
}

const Start kMisshapen[] = {{"flat", flattened, true},     {"nearly flat", nearlyFlat},
                            {"inverted", inverted},        {"corner through", cornerThrough},
                            {"half through", halfThrough}, {"randomised", randomised},
                            {"scattered", scattered}};

const Start kCoincident[] = {{"one pair", onePair, true},
                             {"all pairs", allPairs, true},
                             {"seven in one", sevenInOne, true},
                             {"all in one", allInOne, true}};

HardCase startedAs(const std::string& group, const Start& start, double k, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, kDamping);
  cube.positions = start.make(restPositions(cube), dice);
  HardCase hard = caseOf(group, start.name + (" " + exponentName("k", k)), seed, cube);
  hard.startsInBalance = start.inBalance;
  setFree(hard, dice);
  letSettle(hard);
  return hard;
}

template <std::size_t N>
void addStarts(std::vector<HardCase>& cases, const std::string& group, const Start (&starts)[N],
               unsigned seeds, bool quick) {
  for (const Start& start : starts)
    for (const double k : {1e2, 1e4, 1e6})
      for (unsigned seed = 1; seed <= (quick ? 1 : seeds); ++seed)
        if (!quick || k == 1e4) cases.push_back(startedAs(group, start, k, seed));
}

/// Adds a ninth point at the position of the first one. A spring with rest length 0 connects the two, and the
/// ninth point has the same springs to the other points as the first one.
SharedNetwork doubledPointNetwork(const SpringNetwork& cube) {
  auto network = std::make_shared<SpringNetwork>(cube);
  network->restPoints.push_back(cube.restPoints[0]);
  network->massFractions.assign(9, 1.0 / 9.0);
  std::vector<NetworkSpring> springs;
  for (std::uint32_t a = 0; a < 9; ++a)
    for (std::uint32_t b = a + 1; b < 9; ++b) springs.push_back({a, b, SpringKind::Structural, 1.0});
  network->springs = springs;
  return network;
}

HardCase doubledPoint(double k, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, kDamping);
  cube.network = doubledPointNetwork(*cube.network);
  cube.positions = restPositions(cube);
  if (seed > 1)
    cube.positions += dice.vectors(9, 0.1);
  else
    cube.positions.col(4) *= 1.2;  // the two points with the same rest position start at the same position
  HardCase hard = caseOf("zero length", "in the network " + exponentName("k", k), seed, cube);
  setFree(hard, dice);
  letSettle(hard);
  return hard;
}

/// A spring pulls two corners of a cube, or of two cubes, together.
HardCase pulledTogether(double k, bool twoBodies, bool damped) {
  Dice dice(1);
  BodySetup cube = hardCube(k, damped ? kDamping : 0.0);
  HardCase hard = caseOf("zero length",
                         std::string(twoBodies ? "between bodies " : "within a body ") +
                             exponentName("k", k) + (damped ? " damped" : " undamped"),
                         1, cube);
  SpringSettings spring;
  spring.restLength = 0.0;
  spring.stiffness = k;
  spring.damping = cube.settings.damping;
  if (twoBodies) {
    cube.settings.position = {1.5, 0.2, 0.1};
    hard.bodies.push_back(cube);
  }
  hard.springs = {{{0, 7}, {twoBodies ? 1u : 0u, 0}, spring}};
  setFree(hard, dice);
  return hard;
}

void addZeroLengths(std::vector<HardCase>& cases, bool quick) {
  for (const double k : {1e2, 1e4, 1e6}) {
    if (quick && k != 1e4) continue;
    for (unsigned seed = 1; seed <= 2; ++seed) cases.push_back(doubledPoint(k, seed));
    for (const bool two : {false, true})
      for (const bool damped : {false, true}) cases.push_back(pulledTogether(k, two, damped));
  }
}

}  // namespace

void addShapeCases(std::vector<HardCase>& cases, bool quick) {
  addZeroLengths(cases, quick);
  addStarts(cases, "coincident", kCoincident, 1, quick);
  addStarts(cases, "misshapen", kMisshapen, 4, quick);
}

}  // namespace limber::bench
