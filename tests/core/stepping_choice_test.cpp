// SPDX-License-Identifier: Zlib
// The choice of a body's stepper and number of substeps.
#include "solver/stepping_choice.h"
#include "support/networks.h"
#include "support/stepped_body.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

SteppingProblem freeBody(double frequency) {
  SteppingProblem p;
  p.frequencies = {frequency * frequency, frequency * frequency};
  p.tick = 1.0 / 60;
  p.size = 1.0;
  p.implicitPossible = true;
  return p;
}

TEST(SubstepCount, followsStabilityToleranceAndTheUser) {
  Stepping choice;
  EXPECT_EQ(substepCount({}, 1.0 / 60, choice), 5) << "the default";
  choice.minSubsteps = 1;
  choice.periodTolerance = 1.0;
  EXPECT_EQ(substepCount({}, 1.0 / 60, choice), 1);
  const Frequencies fast{1e6, 0.25e6};  // largest 1000 rad/s, 500 near the rest shape
  EXPECT_EQ(substepCount(fast, 1.0 / 60, choice), static_cast<int>(std::ceil(1000.0 / 60 / 1.8)));
  choice.periodTolerance = 1e-4;
  EXPECT_EQ(substepCount(fast, 1.0 / 60, choice), static_cast<int>(std::ceil(500.0 / 60 / std::sqrt(24e-4))));
  choice.minSubsteps = 1000;
  EXPECT_EQ(substepCount(fast, 1.0 / 60, choice), 1000);
}

TEST(SteppingChoice, isVerletWhileThatIsCheap) {
  const SteppingChoice soft = chooseStepping(freeBody(100.0), Stepping());
  EXPECT_EQ(soft.stepper, Stepper::Verlet);
  EXPECT_EQ(soft.substeps, substepCount({1e4, 1e4}, 1.0 / 60, Stepping()));
}

TEST(SteppingChoice, goesImplicitForStiffBodiesInFreeMotion) {
  SteppingProblem stiff = freeBody(1e5);
  EXPECT_EQ(chooseStepping(stiff, Stepping()).stepper, Stepper::ImplicitMidpoint);
  EXPECT_LE(chooseStepping(stiff, Stepping()).substeps, 10);
  stiff.narrow = true;
  EXPECT_EQ(chooseStepping(stiff, Stepping()).stepper, Stepper::Newton);
  stiff.touching = true;
  EXPECT_EQ(chooseStepping(stiff, Stepping()).stepper, Stepper::Verlet) << "impacts want fine substeps";
}

TEST(SteppingChoice, pinnedBodiesAreNotSteppedImplicitly) {
  SteppingProblem stiff = freeBody(1e5);
  stiff.held = true;
  EXPECT_EQ(chooseStepping(stiff, Stepping()).stepper, Stepper::Verlet);
}

TEST(SteppingChoice, goesImplicitOnlyWhereThatIsCheaper) {
  SteppingProblem stiff = freeBody(1e5);
  Stepping s;
  s.tolerance = 1.0;
  EXPECT_EQ(chooseStepping(stiff, s).stepper, Stepper::ImplicitMidpoint);
  stiff.errorCoefficient = 0.7 * std::pow(60 * 200, 2);  // the tolerance requires 200 substeps, stability 926
  EXPECT_EQ(chooseStepping(stiff, s).stepper, Stepper::Verlet);
  stiff.errorCoefficient = 0.0;
  stiff.turnRate = 60.0 * 50;  // 0.25 rad in each of 200 substeps
  EXPECT_EQ(chooseStepping(stiff, s).stepper, Stepper::Verlet);
}

TEST(SteppingChoice, neverGetsCoarserWhenMoreIsAskedFor) {
  for (const double frequency : {1e2, 1e3, 1e4, 3e4, 1e5, 1e6})
    for (const double damping : {0.0, 1e4, 1e8})
      for (const int kind : {0, 1, 2}) {  // a large mesh, a few points, a rope
        SteppingProblem p = freeBody(frequency);
        p.dampingRate = damping;
        p.cheapNewton = kind > 0;
        p.narrow = kind > 1;
        Stepping s;
        s.periodTolerance = 1.0;
        SteppingChoice before = chooseStepping(p, s);
        while (s.periodTolerance > 1e-6) {
          s.periodTolerance *= 0.8;
          const SteppingChoice now = chooseStepping(p, s);
          EXPECT_TRUE(now.stepper == before.stepper || now.stepper == Stepper::Verlet) << s.periodTolerance;
          EXPECT_GE(now.substeps, before.substeps) << s.periodTolerance;
          before = now;
        }
      }
}

TEST(SteppingChoice, solvesStrongDampersWithTheSprings) {
  SteppingProblem damped = freeBody(100.0);
  damped.dampingRate = 1e4;
  EXPECT_EQ(chooseStepping(damped, Stepping()).stepper, Stepper::Verlet) << "a large mesh";
  damped.cheapNewton = true;
  EXPECT_EQ(chooseStepping(damped, Stepping()).stepper, Stepper::Newton);
  damped.touching = true;
  damped.dampingRate = 1e3;
  EXPECT_EQ(chooseStepping(damped, Stepping()).stepper, Stepper::Verlet) << "sweeps of dampers follow";
  damped.dampingRate = 1e4;
  EXPECT_EQ(chooseStepping(damped, Stepping()).stepper, Stepper::Newton);
  damped.implicitPossible = false;
  EXPECT_EQ(chooseStepping(damped, Stepping()).stepper, Stepper::Verlet);
}

TEST(SteppingChoice, canBeForcedButNotWhereItCannotWork) {
  Stepping forced;
  forced.stepper = Stepper::ImplicitMidpoint;
  SteppingProblem p = freeBody(100.0);
  EXPECT_EQ(chooseStepping(p, forced).stepper, Stepper::ImplicitMidpoint);
  p.implicitPossible = false;
  EXPECT_EQ(chooseStepping(p, forced).stepper, Stepper::Verlet);
  forced.stepper = Stepper::Verlet;
  EXPECT_EQ(chooseStepping(freeBody(1e5), forced).stepper, Stepper::Verlet);
}

TEST(SteppingChoice, toleranceRaisesTheSubstepsByTheSquareRoot) {
  SteppingProblem p = freeBody(10.0);
  p.errorCoefficient =
      0.7 * 60.0 * 60.0;  // error of 1 m/s with one substep; the target is 0.7 of the tolerance
  Stepping s;
  s.tolerance = 0.01;
  EXPECT_EQ(chooseStepping(p, s).substeps, 10);
  s.tolerance = 0.0;
  s.relativeTolerance = 0.0025;
  EXPECT_EQ(chooseStepping(p, s).substeps, 20);
  p.size = 4.0;
  EXPECT_EQ(chooseStepping(p, s).substeps, 10);
}

TEST(SteppingChoice, budgetCapsTheSubsteps) {
  SteppingProblem p = freeBody(1000.0);
  p.errorCoefficient = 1e12;
  Stepping s;
  s.tolerance = 1e-6;
  s.maxSubsteps = 100;
  EXPECT_EQ(chooseStepping(p, s).stepper, Stepper::Verlet);
  EXPECT_EQ(chooseStepping(p, s).substeps, 100);
  s.maxSubsteps = 3;
  EXPECT_EQ(chooseStepping(p, s).stepper, Stepper::Verlet);
  EXPECT_EQ(chooseStepping(p, s).substeps, 3);
  EXPECT_TRUE(chooseStepping(p, s).cut);
}

TEST(SteppingChoice, resolvesFastTurning) {
  SteppingProblem p = freeBody(10.0);
  p.turnRate = 600.0;  // 10 rad a tick
  EXPECT_GE(chooseStepping(p, Stepping()).substeps, 40);
}

TEST(FastestTurn, isTheSpinOfARigidlyTurningBodyAndNotItsBreathing) {
  test::SteppedTestBody body(test::cubeNetwork(), 100.0, 0.0);
  body.spin({0.0, 50.0, 0.0});
  EXPECT_NEAR(fastestTurn(body.springs, body.state, 1e3, 1.0), 50.0, 1e-9);
  EXPECT_EQ(fastestTurn(body.springs, body.state, 1e3, 1e4), 0.0) << "surely below what is asked for";
  body.state.velocity = 30.0 * body.state.position;
  EXPECT_NEAR(fastestTurn(body.springs, body.state, 1e3, 1.0), 0.0, 1e-9);
}

TEST(DampingRate, isTheFastestDampers) {
  test::SteppedTestBody body(test::pairNetwork(), 100.0, 3.0);
  EXPECT_DOUBLE_EQ(dampingRateBound(body.springs, body.state.inverseMass), 3.0 * (2.0 + 2.0));
}

}  // namespace
}  // namespace limber
