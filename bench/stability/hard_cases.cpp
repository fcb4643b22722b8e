// SPDX-License-Identifier: Zlib
#include "results.h"
#include "stability/stability.h"

#include <cmath>

namespace limber::bench {
namespace {

const char* const kDamped[] = {"undamped", "damped"};

// --- extreme parameters ---

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
        cases.push_back(shaken("stiffness", format("k %.0e %s", k, kDamped[damped]), seed,
                               hardCube(k, damped ? 0.3 : 0.0)));
      }
}

/// Makes the chosen points `ratio` times as heavy as the others.
void setMassRatio(BodySetup& cube, double ratio, const std::vector<std::size_t>& heavy) {
  auto network = std::make_shared<SpringNetwork>(*cube.network);
  auto& fractions = network->massFractions;
  const double sum = double(fractions.size()) + double(heavy.size()) * (ratio - 1.0);
  fractions.assign(fractions.size(), 1.0 / sum);
  for (const std::size_t i : heavy) fractions[i] = ratio / sum;
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
          const double ratio = std::pow(10.0, exponent);
          setMassRatio(cube, ratio, heavy);
          cases.push_back(shaken(
              "mass ratio", format("ratio %.0e %s k %.0e %s", ratio, name, k, kDamped[damped]), 1, cube));
        }
}

void addDampings(std::vector<HardCase>& cases, bool quick) {
  for (const double damping : {0.0, 0.01, 0.1, 1.0, 10.0, 100.0, 1000.0})
    for (const double k : {1e3, 1e5, 1e7})
      for (unsigned seed = 1; seed <= (quick ? 1u : 2u); ++seed) {
        if (quick && (k != 1e5 || damping == 0.01 || damping == 10.0)) continue;
        BodySetup cube = hardCube(k, damping);
        HardCase hard = shaken("damping", format("x %.0e k %.0e", damping, k), seed, cube);
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
          HardCase hard =
              caseOf("spin", format("rad/s %.0e k %.0e %s", speed, k, kDamped[damping > 0.0]), seed, cube);
          setFree(hard, dice);
          cases.push_back(hard);
        }
}

// --- extreme initial shapes ---

constexpr double kDamping = 0.3;

using Points = Eigen::Matrix3Xd;

/// An initial shape that is not the rest shape.
struct Start {
  const char* name;
  void (*change)(Points& x, Dice& dice);  ///< from the rest positions
  bool inBalance = false;                 ///< two points coincide with equal forces: no force separates them
};

void addNoise(Points& x, Dice& dice) { x += dice.vectors(x.cols(), 1e-3); }

/// Moves one corner through the body and beyond the opposite corner.
void pushCornerThrough(Points& x, Dice& dice) {
  const Eigen::Vector3d beyond = 1.5 * x.col(7);
  addNoise(x, dice);
  x.col(0) = beyond;
}

/// Moves the lower four points above the upper four.
void pushHalfThrough(Points& x, Dice& dice) {
  addNoise(x, dice);
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    if (x(1, i) < 0.0) x(1, i) += 1.6;
}

void flatten(Points& x) { x.row(1).setZero(); }  // some points then coincide

/// Inverts the body along one axis and doubles its length.
void invert(Points& x) { x.row(0) *= -2.0; }

const std::vector<Start> kMisshapen = {
    {"flat", [](Points& x, Dice&) { flatten(x); }, true},
    {"nearly flat", [](Points& x, Dice& dice) { flatten(x), addNoise(x, dice); }},
    {"inverted", [](Points& x, Dice& dice) { invert(x), addNoise(x, dice); }},
    {"corner through", pushCornerThrough},
    {"half through", pushHalfThrough},
    {"randomised", [](Points& x, Dice& dice) { x = dice.vectors(x.cols(), 0.5); }},
    {"scattered", [](Points& x, Dice& dice) { x = dice.vectors(x.cols(), 3.0); }}};

void joinPairs(Points& x, Dice&) {
  for (Eigen::Index i = 0; i < 8; i += 2) x.col(i + 1) = x.col(i);
}

const std::vector<Start> kCoincident = {
    {"one pair", [](Points& x, Dice&) { x.col(1) = x.col(0).eval(); }, true},
    {"all pairs", joinPairs, true},
    {"seven in one", [](Points& x, Dice&) { x.rightCols(7).colwise() = x.col(1).eval(); }, true},
    {"all in one", [](Points& x, Dice&) { x.setZero(); }, true}};

HardCase startedAs(const std::string& group, const Start& start, double k, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, kDamping);
  cube.positions = restPositions(cube);
  start.change(cube.positions, dice);
  HardCase hard = caseOf(group, format("%s k %.0e", start.name, k), seed, cube);
  hard.startsInBalance = start.inBalance;
  setFree(hard, dice);
  letSettle(hard);
  return hard;
}

void addStarts(std::vector<HardCase>& cases, const std::string& group, const std::vector<Start>& starts,
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
  HardCase hard = caseOf("zero length", format("in the network k %.0e", k), seed, cube);
  setFree(hard, dice);
  letSettle(hard);
  return hard;
}

/// A spring pulls two corners of a cube, or of two cubes, together.
HardCase pulledTogether(double k, bool twoBodies, bool damped) {
  Dice dice(1);
  BodySetup cube = hardCube(k, damped ? kDamping : 0.0);
  const char* where = twoBodies ? "between bodies" : "within a body";
  HardCase hard = caseOf("zero length", format("%s k %.0e %s", where, k, kDamped[damped]), 1, cube);
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
  HardCase hard = caseOf("impact", format("%s k %.0e", nameOf(obstacle), k), seed, cube);
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
  HardCase hard = caseOf("crush", format("k %.0e x %.0e", k, damping), seed, cube);
  setObstacle(hard, Obstacle::Box);
  addPress(hard, 2.5 * radius);
  letSettle(hard);
  hard.seconds = wholeTicks(hard.energyFrom + std::max(2.0, hard.seconds));
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
  HardCase hard = caseOf("heavy on soft", format("k %.0e", k), seed, cube);
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
  HardCase hard =
      caseOf("size", format("%s free k %.0e %s", size.name, k, kDamped[damping > 0.0]), seed, cube);
  setFree(hard, dice);
  if (damping > 0.0) letSettle(hard);
  return hard;
}

HardCase dropped(const Size& size, double k, unsigned seed) {
  Dice dice(seed);
  BodySetup cube = hardCube(k, 1.0, size.edge, size.mass);
  cube.settings.rotation = dice.rotation();
  cube.settings.position = {0, 2.0 * size.edge, 0};
  HardCase hard = caseOf("size", format("%s dropped k %.0e", size.name, k), seed, cube);
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
  HardCase hard = caseOf("stack of ten", format("k %.0e", k), seed, cube);
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
  HardCase hard = caseOf("hour of rest", format("%s k %.0e", nameOf(obstacle), k), 1, cube);
  setObstacle(hard, obstacle);
  letSettle(hard);
  letFall(hard, seconds);
  return hard;
}

void addStacks(std::vector<HardCase>& cases, bool quick) {
  for (const double k : {1e4, 1e6})
    for (unsigned seed = 1; seed <= (quick ? 1u : 2u); ++seed)
      if (!quick || k == 1e4) cases.push_back(stack(k, seed));
}

}  // namespace

std::vector<HardCase> allHardCases(bool quick) {
  std::vector<HardCase> cases;
  for (const auto add : {addStiffnesses, addMassRatios, addDampings, addSpins, addZeroLengths})
    add(cases, quick);
  addStarts(cases, "coincident", kCoincident, 1, quick);
  addStarts(cases, "misshapen", kMisshapen, 4, quick);
  for (const auto add : {addImpacts, addCrushes, addLoads, addSizes, addStacks}) add(cases, quick);
  cases.push_back(rest(Obstacle::Box, 1e4, quick ? 30.0 : 3600.0));
  return cases;
}

}  // namespace limber::bench
