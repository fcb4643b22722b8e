// SPDX-License-Identifier: Zlib
// Stepper, tolerance, maxSubsteps and elastic limit in a Bullet world.
#include "support/allocation_counter.h"
#include "support/soft_world.h"

#include <cmath>

namespace limber::test {
namespace {

SoftBodySettings stiffCube(double stiffness, Stepper stepper) {
  SoftBodySettings s = testedSettings();
  setSprings(s, stiffness, 0.05 * 2.0 * std::sqrt(stiffness * 0.125));
  s.stepping.stepper = stepper;
  s.friction = 0.0;
  return s;
}

class SteppedBy : public testing::TestWithParam<Stepper> {};

TEST_P(SteppedBy, aCubeRestsRightOnAPlane) {
  for (const double stiffness : {1e3, 1e5}) {
    SoftWorld bullet(-kGravity);
    bullet.addPlaneFloor();
    SoftBodySettings s = stiffCube(stiffness, Stepper::Verlet);
    s.position.y() = 0.53;
    const auto restHeight = [&](Stepper stepper) {
      s.stepping.stepper = stepper;
      SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
      bullet.simulate(10.0);
      EXPECT_EQ(body->stepper(), stepper);
      const double height = body->centerOfMass().y();
      bullet.system.destroyBody(body);
      return height;
    };
    EXPECT_NEAR(restHeight(GetParam()), restHeight(Stepper::Verlet), 1e-6) << stiffness;
  }
}

TEST_P(SteppedBy, aFreeBodyFallsExactlyAndKeepsItsMomentum) {
  SoftWorld bullet(-kGravity);
  SoftBodySettings s = stiffCube(1e4, GetParam());
  s.linearVelocity = {1.0, 2.0, 3.0};
  s.angularVelocity = {0.0, 3.0, 0.0};
  SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
  bullet.simulate(1.0);
  EXPECT_EQ(body->stepper(), GetParam());
  const Eigen::Vector3d exact = Eigen::Vector3d(1.0, 2.0, 3.0) - 0.5 * kGravity * Eigen::Vector3d::UnitY();
#ifdef BT_USE_DOUBLE_PRECISION
  EXPECT_LT((body->centerOfMass() - exact).norm(), 1e-11);
#else
  EXPECT_LT((body->centerOfMass() - exact).norm(), 1e-6) << "gravity itself is a float";
#endif
}

TEST_P(SteppedBy, howeverStiffAFreeBodyTurnsAsFastAsItSpins) {
  for (const double stiffness : {1e4, 1e6, 1e7, 1e8}) {
    SCOPED_TRACE(stiffness);
    SoftWorld bullet(0);
    SoftBodySettings s = stiffCube(stiffness, GetParam());
    s.damping = 0.0;
    s.angularVelocity = {0.0, 0.0, 1.0};
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    const Eigen::Vector3d before = body->position(7) - body->position(0);
    bullet.simulate(1.0);
    const Eigen::Vector3d after = body->position(7) - body->position(0);
    const Eigen::Vector3d expected = Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()) * before;
    // rotation extends it by m w^2 / k at 1e4 N/m, which slows the rotation by twice that: some 1e-5
    EXPECT_LT((after - expected).norm(), 1e-3);
    EXPECT_NEAR(body->kineticEnergy() + body->elasticEnergy(), 0.25, 1e-3);
  }
}

TEST(Stepping, howeverStiffAPinnedBodySwingsAsItFalls) {
  for (const double rate : {15.0, 60.0})
    for (const double stiffness : {1e6, 1e7}) {
      SCOPED_TRACE(stiffness);
      SoftWorld bullet(-kGravity);
      SoftBodySettings s = stiffCube(stiffness, Stepper::Auto);
      s.damping = 0.0;
      SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
      body->pin(0);
      const double height = body->centerOfMass().y();
      double highest = height - 10.0;
      for (int i = 0; i < 3 * rate; ++i) {
        bullet.tick(1.0 / rate);
        if (i > rate) highest = std::max(highest, body->centerOfMass().y());
      }
      // the tolerance is its motion during a tick of 1/15 s around the turning point
      EXPECT_NEAR(highest, height, 0.03);
    }
}

TEST_P(SteppedBy, twoRunsAgreeBitForBit) {
  const auto hash = [](Stepper stepper) {
    SoftWorld bullet(-kGravity);
    bullet.addBoxFloor();
    SoftBodySettings s = stiffCube(1e5, stepper);
    s.position.y() = 1.0;
    s.angularVelocity = {1.0, 0.5, 0.2};
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    bullet.simulate(2.0);
    return body->stateHash();
  };
  EXPECT_EQ(hash(GetParam()), hash(GetParam()));
}

TEST_P(SteppedBy, aTickAllocatesNothingAfterWarmUp) {
  SoftWorld bullet(-kGravity);
  bullet.addBoxFloor();
  SoftBodySettings s = stiffCube(1e5, GetParam());
  s.position.y() = 1.0;
  SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
  body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(3.0);
  EXPECT_EQ(allocationsIn([&] { bullet.simulate(1.0); }), 0u);
}

INSTANTIATE_TEST_SUITE_P(Steppers, SteppedBy,
                         testing::Values(Stepper::Verlet, Stepper::ImplicitMidpoint, Stepper::Newton),
                         [](const auto& i) {
                           return i.param == Stepper::Verlet   ? "Verlet"
                                  : i.param == Stepper::Newton ? "Newton"
                                                               : "ImplicitMidpoint";
                         });

/// Returns the points of a body after a second without gravity: a rotating, vibrating cube, or a chain that
/// is pinned at its top and was pushed sideways.
Eigen::Matrix3Xd pointsAfterASecond(bool chain, const Stepping& stepping) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  setSprings(s, 1e5, 0.0);
  s.stepping = stepping;
  if (!chain) s.angularVelocity = {6.0, 7.5, 3.0};
  SoftBody* body = bullet.addSoft(chain ? chainNetwork(8) : fullCubeNetwork(), s);
  if (chain) body->pin(0);
  for (std::uint32_t i = 0; i < body->pointCount(); ++i) {
    const Eigen::Vector3d x = body->position(i);
    if (chain) body->point(i)->setLinearVelocity(vec(-x.y(), 0, 0.5 * x.y() * x.y()));
    if (!chain) body->point(i)->getWorldTransform().setOrigin(vec(1.02 * x.x(), x.y(), x.z()));
  }
  bullet.simulate(1.0);
  return placesOf(*body);
}

TEST(PeriodTolerance, askedToBeFinerAutoIsNeverFartherOff) {
  for (const bool chain : {false, true}) {
    Stepping fine;
    fine.stepper = Stepper::Verlet;
    fine.minSubsteps = 6000;
    const Eigen::Matrix3Xd exact = pointsAfterASecond(chain, fine);
    double before = HUGE_VAL;
    for (const double tolerance : {0.04, 1e-2, 1e-3, 1e-4}) {
      Stepping s;
      s.periodTolerance = tolerance;
      const double error = (pointsAfterASecond(chain, s) - exact).cwiseAbs().maxCoeff();
      // After hundreds of periods the phase of the cube's fast modes is wrong except at the finest tolerance.
      // Both errors are then as large as the amplitude, and one may be twice the other.
      EXPECT_LT(error, 2.0 * before) << (chain ? "chain, " : "cube, ") << tolerance;
      before = error;
    }
    // 1e-4 of some 300 periods of 2 pi is 0.2 rad of the amplitudes, 1 cm or less
    EXPECT_LT(before, 2e-3) << (chain ? "chain" : "cube");
  }
}

/// Result of the free flight of a vibrating, rotating cube. `error` is its distance (m, root mean square)
/// from the converged motion after a second.
struct FlightEnd {
  double error = 0.0, estimate = 0.0;
  int substeps = 0;
};

FlightEnd fly(const Stepping& stepping) {
  const auto positionsAfter = [](const Stepping& choice, FlightEnd& flight) {
    SoftWorld bullet(0.0);
    SoftBodySettings s = testedSettings();
    s.damping = 0.0;
    s.angularVelocity = {2.0, 2.5, 1.0};
    s.stepping = choice;
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    for (std::uint32_t i = 0; i < 8; ++i) {
      btTransform pose = body->point(i)->getWorldTransform();
      pose.getOrigin() *= btScalar(1.02);
      body->point(i)->setWorldTransform(pose);
    }
    for (int i = 0; i < 60; ++i) {
      bullet.tick();
      flight.estimate = std::max(flight.estimate, body->errorPerSecond());
    }
    flight.substeps = body->substeps();
    return placesOf(*body);
  };
  FlightEnd flight, unused;
  Stepping fine;
  fine.minSubsteps = 2000;
  const Eigen::Matrix3Xd exact = positionsAfter(fine, unused);
  flight.error = std::sqrt((positionsAfter(stepping, flight) - exact).squaredNorm() / 8.0);
  return flight;
}

TEST(Tolerance, isMetByTheTrueError) {
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    Stepping s;
    s.tolerance = tolerance;
    const FlightEnd flight = fly(s);
    EXPECT_LT(flight.error, tolerance) << "m after one second at " << flight.substeps << " substeps";
    EXPECT_GT(flight.error, 0.02 * tolerance) << "the estimate is not wasteful either";
  }
}

TEST(Tolerance, asAShareOfTheBodysSizeIsTheSame) {
  Stepping absolute, relative;
  absolute.tolerance = 1e-3 * std::sqrt(3.0);  // the cube's diagonal
  relative.relativeTolerance = 1e-3;
  EXPECT_EQ(fly(absolute).substeps, fly(relative).substeps);
}

TEST(Budget, capsTheSubstepsAndReportsTheErrorThatFollows) {
  Stepping accurate, capped;
  accurate.tolerance = capped.tolerance = 1e-4;
  capped.maxSubsteps = 16;
  const FlightEnd free = fly(accurate), limited = fly(capped);
  EXPECT_GT(free.substeps, 16);
  EXPECT_EQ(limited.substeps, 16);
  EXPECT_GT(limited.estimate, 1e-4) << "the tolerance is missed, and says so";
  EXPECT_GT(limited.estimate, 0.5 * limited.error);
}

TEST(ErrorEstimate, fallsWithTheSquareOfTheSubstep) {
  Stepping coarse, fine;
  coarse.minSubsteps = 20;
  fine.minSubsteps = 40;
  EXPECT_NEAR(fly(coarse).estimate / fly(fine).estimate, 4.0, 0.4);
}

TEST(ElasticLimit, aRopeBreaksWhereTheLoadIsTooMuch) {
  const auto brokenUnder = [](double loadMass) {
    SoftWorld bullet(-kGravity);
    SoftBodySettings s = testedSettings();
    setSprings(s, 1000.0, 20.0);
    s.totalMass = 0.1;
    s.elasticLimit.breakStrain = 0.2;
    SoftBody* rope = bullet.addSoft(chainNetwork(4), s);
    rope->pin(0);
    btRigidBody* load = bullet.addBox(vec(0.05, 0.05, 0.05), loadMass, vec(0, -1, 0));
    EXPECT_TRUE(bullet.system.attach(rope, 4, *load));
    bullet.simulate(2.0);
    return load->getCenterOfMassPosition().y() < -3.0;
  };
  // a released load extends a spring of 1/4 m by twice m g / k: 0.2 of it is 50 mm, or 2.5 kg
  EXPECT_FALSE(brokenUnder(1.0));
  EXPECT_TRUE(brokenUnder(10.0));
}

TEST(ElasticLimit, aRopeThatYieldedStaysLonger) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.damping = 5.0;
  s.elasticLimit.yieldStrain = 0.05;
  SoftBody* rope = bullet.addSoft(chainNetwork(4), s);
  rope->pin(0);
  rope->pin(4);
  for (int i = 1; i <= 120; ++i) {
    rope->movePin(4, vec(0, -1.0 - 0.3 * i / 120.0, 0));
    bullet.tick();
  }
  bullet.simulate(2.0);
  rope->unpin(4);
  bullet.simulate(5.0);
  // pulled to 1.3 it carries a strain of 0.05 of its first length elastically; the rest is permanent
  EXPECT_NEAR((rope->position(4) - rope->position(0)).norm(), 1.25, 0.01);
}

}  // namespace
}  // namespace limber::test
