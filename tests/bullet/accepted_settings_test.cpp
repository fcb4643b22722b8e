// SPDX-License-Identifier: Zlib
// Random settings out of all that validate() accepts: the positions of a body stay finite for its first
// second, and no tick takes more substeps than a tick has at most.
#include "fuzz/dice.h"
#include "solver/stepping_choice.h"
#include "support/soft_world.h"
#include "support/variants.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace limber::test {
namespace {

using fuzz::Dice;

/// One of the bounds, or log-uniform between them. A range from 0 has its decades from `least`.
double anyIn(Dice& dice, double low, double high, double least) {
  if (dice.chance(0.2)) return dice.of({low, high});
  const double value = dice.decades(std::max(low, least), high);
  return std::clamp(value, low, high);
}

/// Half of the settings keep their defaults: extreme values of one field alone matter, too.
template <class Value>
void roll(Dice& dice, Value& value, double low, double high, double least) {
  if (dice.chance(0.5)) value = static_cast<Value>(anyIn(dice, low, high, least));
}

double anySigned(Dice& dice, double high, double least) {
  return (dice.chance(0.5) ? -1.0 : 1.0) * anyIn(dice, least, high, least);
}

void rollPlacement(Dice& dice, SoftBodySettings& s) {
  for (int axis = 0; axis < 3; ++axis) {
    if (dice.chance(0.1)) s.position[axis] = anySigned(dice, 1e6, 1e-6);
    if (dice.chance(0.15)) s.linearVelocity[axis] = anySigned(dice, 1e5, 1e-6);
    if (dice.chance(0.15)) s.angularVelocity[axis] = anySigned(dice, 1e5, 1e-6);
  }
  if (dice.chance(0.5)) s.scale.setConstant(anySigned(dice, 1e6, 1e-6));
  if (dice.chance(0.2)) s.scale[dice.below(3)] *= dice.of({0.5, 1e-3, 30.0});
  if (dice.chance(0.3)) s.rotation = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5);
}

void rollStepping(Dice& dice, Stepping& s) {
  s.stepper = dice.of({Stepper::Auto, Stepper::Verlet, Stepper::ImplicitMidpoint, Stepper::Newton});
  if (dice.chance(0.3)) roll(dice, s.minSubsteps, 1, 1e4, 1);
  roll(dice, s.periodTolerance, 1e-8, 1, 1e-8);
  roll(dice, s.tolerance, 0, 1e6, 1e-9);
  roll(dice, s.relativeTolerance, 0, 1e6, 1e-9);
  roll(dice, s.maxSubsteps, 0, 1e4, 1);
  roll(dice, s.searchDistance, 0.01, 0.25, 0.01);
}

void rollElasticLimit(Dice& dice, ElasticLimit& limit) {
  if (dice.chance(0.6)) return;
  roll(dice, limit.stiffenStrain, 0, 1e6, 1e-6);
  roll(dice, limit.stiffenFactor, 1, 1e6, 1);
  roll(dice, limit.yieldStrain, 0, 1e6, 1e-6);
  roll(dice, limit.yieldMaximum, 0, 0.999, 1e-6);
  roll(dice, limit.breakStrain, 0, 1e6, 1e-6);
}

SoftBodySettings rolledSettings(Dice& dice) {
  SoftBodySettings s = testedSettings();
  rollPlacement(dice, s);
  roll(dice, s.extensionStiffness, 0, 1e12, 1e-6);
  s.compressionStiffness = s.extensionStiffness;
  if (dice.chance(0.3)) roll(dice, s.compressionStiffness, 0, 1e12, 1e-6);
  roll(dice, s.damping, 0, 1e12, 1e-9);
  roll(dice, s.totalMass, 1e-9, 1e12, 1e-9);
  if (dice.chance(0.3)) s.volumeModulus = anyIn(dice, 0, 1e15, 1e-6);
  if (dice.chance(0.3)) roll(dice, s.pressure, 0, 1e12, 1e-6);
  if (dice.chance(0.3)) roll(dice, s.ambientPressure, 0, 1e12, 1e-6);
  if (dice.chance(0.3)) s.pointRadius = anyIn(dice, 1e-9, 1e4, 1e-9);
  roll(dice, s.friction, 0, 1e6, 1e-6);
  roll(dice, s.restitution, 0, 1, 1e-6);
  roll(dice, s.sleepingSpeed, 0, 1e6, 1e-6);
  s.selfCollision = s.collision == Collision::Surface && dice.chance(0.2);
  s.hollow = s.collision == Collision::Surface && dice.chance(0.2);
  s.continuousCollision = dice.chance(0.7);
  rollStepping(dice, s.stepping);
  rollElasticLimit(dice, s.elasticLimit);
  return s;
}

SharedNetwork rolledNetwork(Dice& dice) {
  switch (dice.below(8)) {
    case 0:
      return squareCloth(3);
    case 1:
      return ropeNetwork(9);
    case 2:
      return cubeNetwork();
    case 3:
      return fullCubeNetwork();
    case 4:
      return tetrahedronNetwork();
    case 5:
      return tetrahedralCubeNetwork();
    default:
      return closedCubeNetwork();
  }
}

void addFloor(Dice& dice, BulletWorld& bullet) {
  switch (dice.below(3)) {
    case 0:
      bullet.addPlaneFloor();
      break;
    case 1:
      bullet.addBoxFloor();
      break;
    default:
      break;  // free fall
  }
}

/// Places the body close above the floor, so that slow ones meet it within the second.
void placeAboveFloor(Dice& dice, const SpringNetwork& network, SoftBodySettings& s) {
  if (dice.chance(0.2)) return;
  double lowest = 0.0;
  for (const Eigen::Vector3d& p : network.restPoints)
    lowest = std::min(lowest, (s.rotation * p.cwiseProduct(s.scale)).y());
  const double height = -lowest + 1.1 * pointRadius(network, s);
  if (height < 1e6) s.position.y() = height * dice.of({1.0, 1.1, 0.9});
}

/// Plays the body of the seed until a second is over, or it has taken `allowance` substeps. Adds to `played`
/// unless the network has limits for the settings.
void play(std::uint64_t seed, int allowance, unsigned& played) {
  Dice dice(seed);
  SoftWorld bullet;
  addFloor(dice, bullet);
  std::string warning;
  bullet.system.onWarning([&](const std::string& text) { warning = text; });
  const SharedNetwork network = rolledNetwork(dice);
  SoftBodySettings s = rolledSettings(dice);
  placeAboveFloor(dice, *network, s);
  const Result<SoftBody*> made = bullet.system.createBody(network, s);
  if (!made) return;
  ++played;
  const bool gas = s.pressure > 0.0;
  if (dice.chance(0.1)) (*made)->pin(0);
  const double tick = dice.of({0.1, 1.0 / 60.0, 1.0 / 60.0, 1.0 / 240.0});
  for (double time = 0.0; time < 1.0 && allowance > 0; time += tick) {
    bullet.tick(tick);
    ASSERT_LE((*made)->substeps(), kMaxSubsteps) << "seed " << seed;
    allowance -= (*made)->substeps();
    for (std::uint32_t i = 0; i < (*made)->pointCount(); ++i)
      ASSERT_TRUE((*made)->position(i).allFinite()) << "seed " << seed << ", at " << time << " s";
    // without springs, gas in a vacuum swells beyond all bounds
    if (gas) continue;
    ASSERT_EQ((*made)->restorations(), 0u) << "seed " << seed << ", at " << time << " s: " << warning;
  }
}

void playSeeds(unsigned first, unsigned count, int allowance) {
  unsigned played = 0;
  for (unsigned seed = first; seed < first + count; ++seed) play(seed, allowance, played);
  EXPECT_GT(played, count / 2) << "the others are refused";
}

/// The environment variable LIMBER_SEEDS, "FIRST COUNT ALLOWANCE", plays other seeds.
TEST(AcceptedSettings, keepPositionsFinite) {
  unsigned first = 1, count = 50;
  int allowance = 20000;
  if (const char* seeds = std::getenv("LIMBER_SEEDS"))
    std::sscanf(seeds, "%u %u %d", &first, &count, &allowance);
  playSeeds(first, count, allowance);
}

TEST(AcceptedSettings, keepPositionsFiniteWithMoreSeeds) { playSeeds(51, 150, 20000); }

/// Dampers, friction and speed that no iteration converges with, on a body of 10 micrometres.
TEST(AcceptedSettings, ofAnImplicitStepperInContactTakeFewSubsteps) {
  for (const Stepper stepper : {Stepper::Auto, Stepper::ImplicitMidpoint, Stepper::Newton})
    for (const double damping : variants({0.0, 1e12}, {1.0, 1e6}))
      for (const double friction : {0.5, 1e6}) {
        SoftWorld bullet;
        bullet.addPlaneFloor();
        SoftBodySettings s = testedSettings();
        s.scale.setConstant(1e-5);
        s.position.y() = 6e-6;
        s.linearVelocity = {2.7e4, -2.7e4, 0};
        s.damping = damping;
        s.friction = friction;
        s.stepping.stepper = stepper;
        SoftBody* body = bullet.addSoft(closedCubeNetwork(), s);
        for (int i = 0; i < 10; ++i) {
          const bool touched = !body->contacts().empty();
          bullet.tick();
          ASSERT_TRUE(body->position(0).allFinite());
          ASSERT_LE(body->substeps(), touched && body->stepper() != Stepper::Verlet ? 1000 : kMaxSubsteps);
        }
        EXPECT_EQ(body->restorations(), 0u) << "damping " << damping << ", friction " << friction;
        EXPECT_GT(body->centerOfMass().y(), 0.0);
      }
}

}  // namespace
}  // namespace limber::test
