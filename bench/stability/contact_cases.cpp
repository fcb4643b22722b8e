// SPDX-License-Identifier: Zlib
#include "stability/case_parts.h"
#include "stability/obstacles.h"

namespace limber::bench {
namespace {

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

}  // namespace

void addContactCases(std::vector<HardCase>& cases, bool quick) {
  addImpacts(cases, quick);
  addCrushes(cases, quick);
  addLoads(cases, quick);
}

}  // namespace limber::bench
