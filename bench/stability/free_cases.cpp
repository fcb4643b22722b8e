// SPDX-License-Identifier: Zlib
#include "stability/case_parts.h"

#include <cmath>

namespace limber::bench {
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

}  // namespace

void addFreeCases(std::vector<HardCase>& cases, bool quick) {
  addStiffnesses(cases, quick);
  addMassRatios(cases, quick);
  addDampings(cases, quick);
  addSpins(cases, quick);
}

}  // namespace limber::bench
