// SPDX-License-Identifier: Zlib
#include "stability/case_parts.h"
#include "stability/obstacles.h"

namespace limber::bench {
namespace {

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

}  // namespace

void addRestCases(std::vector<HardCase>& cases, bool quick) {
  addSizes(cases, quick);
  for (const double k : {1e4, 1e6})
    for (unsigned seed = 1; seed <= (quick ? 1u : 2u); ++seed)
      if (!quick || k == 1e4) cases.push_back(stack(k, seed));
  cases.push_back(rest(Obstacle::Box, 1e4, quick ? 30.0 : 3600.0));
}

}  // namespace limber::bench
