// SPDX-License-Identifier: Zlib
#include "stability/hard_case.h"

#include <cmath>

namespace limber::bench {

// --- extreme parameters ---

namespace {

/// Displaces the points by up to `limit` times the size.
void shake(BodySetup& body, Dice& dice, double limit) {
  const Eigen::Matrix3Xd rest = restPositions(body);
  body.positions = rest + dice.vectors(rest.cols(), limit * body.settings.scale.x());
}

/// Sets velocities that would displace the points by about the same distance again.
void stir(BodySetup& body, Dice& dice, double limit) {
  const double omega = std::sqrt(8.0 * body.settings.extensionStiffness / body.settings.totalMass);
  body.velocities = dice.vectors(body.positions.cols(), limit * omega * body.settings.scale.x());
}

HardCase shaken(const std::string& group, const std::string& name, unsigned seed, BodySetup cube) {
  Dice dice(seed);
  cube.settings.rotation = dice.rotation();
  shake(cube, dice, 0.15);
  const bool damped = cube.settings.damping > 0.0;
  if (!damped) stir(cube, dice, 0.15);
  HardCase hard = caseOf(group, name, seed, cube);
  setFree(hard, dice);
  if (damped) letSettle(hard);
  return hard;
}

void addStiffnesses(std::vector<HardCase>& cases, bool quick) {
  for (int exponent = 0; exponent <= 8; exponent += quick ? 4 : 1)
    for (unsigned seed = 1; seed <= (quick ? 1u : 2u); ++seed)
      for (const bool damped : {false, true}) {
        const double k = std::pow(10.0, exponent);
        cases.push_back(shaken("stiffness", exponentName("k", k) + (damped ? " damped" : " undamped"), seed,
                               hardCube(k, damped ? 0.3 : 0.0)));
      }
}

/// Makes the chosen points `ratio` times as heavy as the others.
void setMassRatio(BodySetup& cube, double ratio, const std::vector<std::size_t>& heavy) {
  auto network = std::make_shared<SpringNetwork>(*cube.network);
  auto& fractions = network->massFractions;
  fractions.assign(fractions.size(), 1.0);
  for (const std::size_t i : heavy) fractions[i] = ratio;
  double sum = 0.0;
  for (const double fraction : fractions) sum += fraction;
  for (double& fraction : fractions) fraction /= sum;
  cube.network = network;
}

void addMassRatios(std::vector<HardCase>& cases, bool quick) {
  const std::pair<const char*, std::vector<std::size_t>> loads[] = {{"one heavy", {0}},
                                                                    {"half heavy", {0, 3, 5, 6}}};
  for (int exponent = quick ? 4 : 1; exponent <= 4; ++exponent)
    for (const double k : {1e2, 1e5})
      for (const auto& [name, heavy] : loads)
        for (const bool damped : {false, true}) {
          BodySetup cube = hardCube(k, damped ? 1.0 : 0.0);
          setMassRatio(cube, std::pow(10.0, exponent), heavy);
          const std::string full = exponentName("ratio", std::pow(10.0, exponent)) + " " + name + " " +
                                   exponentName("k", k) + (damped ? " damped" : " undamped");
          cases.push_back(shaken("mass ratio", full, 1, cube));
        }
}

void addDampings(std::vector<HardCase>& cases, bool quick) {
  for (const double damping : {0.0, 0.01, 0.1, 1.0, 10.0, 100.0, 1000.0})
    for (const double k : {1e3, 1e5, 1e7})
      for (unsigned seed = 1; seed <= (quick ? 1u : 2u); ++seed) {
        if (quick && (k != 1e5 || damping == 0.01 || damping == 10.0)) continue;
        BodySetup cube = hardCube(k, damping);
        HardCase hard =
            shaken("damping", exponentName("x", damping) + " " + exponentName("k", k), seed, cube);
        if (damping > 0.0 && settleTime(cube) > hard.seconds + 0.1) hard.recovers = false;
        cases.push_back(hard);
      }
}

/// Adds cubes that rotate about a random axis through the centre of mass, from the rest shape.
void addSpins(std::vector<HardCase>& cases, bool quick) {
  for (const double speed : {100.0, 1000.0})
    for (const double k : {1e4, 1e6, 1e8})
      for (const double damping : {0.0, 0.1})
        for (unsigned seed = 1; seed <= (quick ? 1u : 2u); ++seed) {
          if (quick && (speed < 1000.0 || k != 1e6)) continue;
          Dice dice(seed);
          BodySetup cube = hardCube(k, damping);
          cube.settings.rotation = dice.rotation();
          cube.settings.angularVelocity = speed * dice.direction();
          HardCase hard = caseOf("spin",
                                 exponentName("rad/s", speed) + " " + exponentName("k", k) +
                                     (damping > 0.0 ? " damped" : " undamped"),
                                 seed, cube);
          setFree(hard, dice);
          cases.push_back(hard);
        }
}

void addFreeCases(std::vector<HardCase>& cases, bool quick) {
  addStiffnesses(cases, quick);
  addMassRatios(cases, quick);
  addDampings(cases, quick);
  addSpins(cases, quick);
}

// --- extreme initial shapes ---

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

void addShapeCases(std::vector<HardCase>& cases, bool quick) {
  addZeroLengths(cases, quick);
  addStarts(cases, "coincident", kCoincident, 1, quick);
  addStarts(cases, "misshapen", kMisshapen, 4, quick);
}

// --- extreme hits and loads ---

constexpr Obstacle kObstacles[] = {Obstacle::Plane, Obstacle::BoxEdge, Obstacle::TriangleMesh};

/// A cube with a random rotation falls at 100 m/s with a small sideways velocity. The height is random, so
/// that the hit is at any time within a tick.
HardCase impact(Obstacle obstacle, double k, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, 1.0);
  cube.settings.rotation = dice.rotation();
  cube.settings.position = {0, 3.0 + dice.within(1.5), 0.2 * dice.within(1.0)};
  cube.settings.linearVelocity = Eigen::Vector3d(0, -100.0, 0) + dice.vector(2.0);
  HardCase hard = caseOf("impact", nameOf(obstacle) + (" " + exponentName("k", k)), seed, cube);
  setObstacle(hard, obstacle);
  letSettle(hard);
  letFall(hard, 6.0);
  return hard;
}

void addImpacts(std::vector<HardCase>& cases, bool quick) {
  for (const Obstacle obstacle : kObstacles)
    for (const double k : {1e4, 1e6})
      for (unsigned seed = 1; seed <= (quick ? 1u : 4u); ++seed)
        if (!quick || k == 1e4) cases.push_back(impact(obstacle, k, seed));
}

/// A press squeezes the cube to about the thickness of its points.
HardCase crushed(double k, double damping, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, damping);
  const double radius = pointRadius(*cube.network, cube.settings);
  cube.settings.rotation =
      Eigen::AngleAxisd(0.02 * dice.within(1.0), dice.direction()) * Eigen::Quaterniond::Identity();
  cube.settings.position = {0, 0.5 + 1.5 * radius, 0};
  HardCase hard = caseOf("crush", exponentName("k", k) + " " + exponentName("x", damping), seed, cube);
  setObstacle(hard, Obstacle::Box);
  Press press;
  press.gap = 2.5 * radius;
  addPress(hard, press);
  letSettle(hard);
  hard.seconds = wholeTicks(press.leaves() + std::max(2.0, hard.seconds));
  return hard;
}

void addCrushes(std::vector<HardCase>& cases, bool quick) {
  for (const double k : {1e2, 1e4, 1e6})
    for (const double damping : {0.1, 1.0})
      for (unsigned seed = 1; seed <= (quick ? 1u : 3u); ++seed)
        if (!quick || k == 1e4) cases.push_back(crushed(k, damping, seed));
}

/// A box 100 times as heavy as the cube falls on it from 1 m above it. Only the stiffest cube is not deformed
/// by the load at rest.
HardCase loaded(double k, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, 0.3);
  const double radius = pointRadius(*cube.network, cube.settings);
  cube.settings.rotation =
      Eigen::AngleAxisd(dice.within(0.5), Eigen::Vector3d::UnitY()) * Eigen::Quaterniond::Identity();
  cube.settings.position = {0, 0.5 + radius, 0};
  HardCase hard = caseOf("heavy on soft", exponentName("k", k), seed, cube);
  setObstacle(hard, Obstacle::Box);
  addFallingBox(hard, 100.0, 2.0 + 2.0 * radius);
  letSettle(hard);
  hard.recovers = k >= 1e7;
  letFall(hard, 6.0);
  return hard;
}

void addLoads(std::vector<HardCase>& cases, bool quick) {
  for (const double k : {1e3, 1e4, 1e5, 1e7})
    for (unsigned seed = 1; seed <= (quick ? 1u : 3u); ++seed)
      if (!quick || k == 1e4) cases.push_back(loaded(k, seed));
}

void addContactCases(std::vector<HardCase>& cases, bool quick) {
  addImpacts(cases, quick);
  addCrushes(cases, quick);
  addLoads(cases, quick);
}

// --- sizes, stacks, long rest ---

/// Returns whether the weight is so small compared to the stiffness that a cube at rest keeps its shape well
/// within the required 1e-3 of its size. It sinks by about m g / (6 k), and by less than m g / k in any
/// orientation.
bool carriesItself(const HardCase& hard, double mass) {
  return mass * kGravity / hard.stiffness < 1e-3 * hard.size;
}

struct Size {
  const char* name;
  double edge, mass, stiffnesses[2];
};

/// Cubes of 1 mg and a million tons: densities of 1000 and 1 kg/m^3.
const Size kSizes[] = {{"millimetre", 1e-3, 1e-6, {1e1, 1e3}}, {"kilometre", 1e3, 1e9, {1e8, 1e10}}};

HardCase flying(const Size& size, double k, double damping, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, damping, size.edge, size.mass);
  cube.positions = restPositions(cube) + dice.vectors(8, 0.2 * size.edge);
  HardCase hard = caseOf(
      "size",
      std::string(size.name) + " free " + exponentName("k", k) + (damping > 0.0 ? " damped" : " undamped"),
      seed, cube);
  setFree(hard, dice);
  if (damping > 0.0) letSettle(hard);
  return hard;
}

HardCase dropped(const Size& size, double k, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, 1.0, size.edge, size.mass);
  cube.settings.rotation = dice.rotation();
  cube.settings.position = {0, 2.0 * size.edge, 0};
  HardCase hard = caseOf("size", std::string(size.name) + " dropped " + exponentName("k", k), seed, cube);
  setObstacle(hard, Obstacle::Box, size.edge);
  letSettle(hard);
  hard.recovers = carriesItself(hard, size.mass);
  letFall(hard, size.edge > 1.0 ? 60.0 : 4.0);  // a kilometre falls for 15 s
  return hard;
}

void addSizes(std::vector<HardCase>& cases, bool quick) {
  for (const Size& size : kSizes)
    for (const double k : size.stiffnesses)
      for (unsigned seed = 1; seed <= (quick ? 1u : 2u); ++seed) {
        if (quick && k != size.stiffnesses[1]) continue;
        for (const double damping : {0.0, 0.3}) cases.push_back(flying(size, k, damping, seed));
        cases.push_back(dropped(size, k, seed));
      }
}

constexpr int kStackHeight = 10;

/// A stack of cubes, corner on corner, with small horizontal offsets.
HardCase stack(double k, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, 1.0);
  const double radius = pointRadius(*cube.network, cube.settings);
  HardCase hard = caseOf("stack of ten", exponentName("k", k), seed, cube);
  letSettle(hard);
  cube.drag = hard.bodies[0].drag;
  hard.bodies.clear();
  for (int i = 0; i < kStackHeight; ++i) {
    cube.settings.position = {dice.within(0.02), 0.5 + radius + i * (1.0 + 2.0 * radius), dice.within(0.02)};
    hard.bodies.push_back(cube);
  }
  setObstacle(hard, Obstacle::Box);
  hard.recovers = carriesItself(hard, kStackHeight);
  letFall(hard, 5.0);
  return hard;
}

/// A cube at rest for an hour, always awake.
HardCase rest(Obstacle obstacle, double k, double seconds) {
  BodySetup cube = hardCube(k, 0.3);
  cube.settings.position = {0.1, 0.5 + pointRadius(*cube.network, cube.settings), 0.05};
  HardCase hard = caseOf("hour of rest", std::string(nameOf(obstacle)) + " " + exponentName("k", k), 1, cube);
  setObstacle(hard, obstacle);
  letSettle(hard);
  letFall(hard, seconds);
  return hard;
}

void addRestCases(std::vector<HardCase>& cases, bool quick) {
  addSizes(cases, quick);
  for (const double k : {1e4, 1e6})
    for (unsigned seed = 1; seed <= (quick ? 1u : 2u); ++seed)
      if (!quick || k == 1e4) cases.push_back(stack(k, seed));
  cases.push_back(rest(Obstacle::Box, 1e4, quick ? 30.0 : 3600.0));
}

}  // namespace

std::vector<HardCase> allHardCases(bool quick) {
  std::vector<HardCase> cases;
  addFreeCases(cases, quick);
  addShapeCases(cases, quick);
  addContactCases(cases, quick);
  addRestCases(cases, quick);
  return cases;
}

}  // namespace limber::bench
