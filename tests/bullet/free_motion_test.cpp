// SPDX-License-Identifier: Zlib
// Compares motion without contact in a Bullet world with closed forms.
#include "support/small_meshes.h"
#include "support/soft_world.h"
#include "support/variants.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace limber::test {
namespace {

// Bullet stores positions as btScalar, but the state is double: the errors below are those of the scheme.

struct Oscillation {
  double period = 0.0;
  double lastPeak = 0.0;  // largest elongation in the last period
};

/// Simulates a pair: point 0 is pinned, point 1 is released 0.1 m beyond its rest distance. The elongation is
/// read after every tick, and its zero crossings are interpolated linearly.
Oscillation oscillate(SoftBodySettings settings, int periods, double expectedPeriod, double dt) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(pairNetwork(), settings);
  body->pin(0);
  body->point(1)->getWorldTransform().setOrigin(vec(1.1, 0, 0));
  std::vector<double> crossings;
  double before = 0.1, peak = 0.0;
  const int ticks = static_cast<int>(std::ceil((periods + 0.5) * expectedPeriod / dt));
  for (int i = 1; i <= ticks; ++i) {
    bullet.tick(dt);
    const double now = body->position(1).x() - 1.0;
    if (before > 0 && now <= 0) crossings.push_back((i - 1 + before / (before - now)) * dt);
    if (i * dt > (periods - 0.6) * expectedPeriod) peak = std::max(peak, std::abs(now));
    before = now;
  }
  const auto last = crossings.size() - 1;
  return {(crossings[last] - crossings[0]) / static_cast<double>(last), peak};
}

/// Settings of two points of 0.1 kg on an undamped spring of 16 N/m.
SoftBodySettings finelySteppedPair() {
  SoftBodySettings s = testedSettings();
  s.totalMass = 0.2;
  setSprings(s, 16.0, 0.0);
  s.stepping.periodTolerance = 1e-5;
  return s;
}

TEST(Oscillator, periodAndAmplitudeAt30TicksAPeriod) {
  const SoftBodySettings s = finelySteppedPair();
  const double exact = 2 * M_PI * std::sqrt(0.1 / 16.0);
  const Oscillation o = oscillate(s, 10, exact, 1.0 / 60.0);
  // (omega dt)^2/24 must be at most 1e-5; the number of substeps is rounded up
  EXPECT_NEAR(o.period, exact, 1.5e-5 * exact);
  // the largest sample may differ from the peak by 1 - cos(pi / 30) = 0.55 %
  EXPECT_NEAR(o.lastPeak, 0.1, 0.006 * 0.1);
}

TEST(Oscillator, periodDoesNotDependOnTheTick) {
  const SoftBodySettings s = finelySteppedPair();
  const double exact = 2 * M_PI * std::sqrt(0.1 / 16.0);
  for (double dt : {1.0 / 30, 1.0 / 60, 1.0 / 120, 1.0 / 240})
    // At 1/30 s a period has 15 ticks. The linear interpolation of zero crossings has an error of a few 1e-4
    // of a period at both ends of ten periods.
    EXPECT_NEAR(oscillate(s, 10, exact, dt).period, exact, 1e-4 * exact) << "dt " << dt;
}

TEST(Oscillator, defaultToleranceHoldsItsPromise) {
  SoftBodySettings s = testedSettings();
  s.totalMass = 0.2;
  setSprings(s, 1000.0, 0.0);
  const double exact = 2 * M_PI * std::sqrt(0.1 / 1000.0);
  const Oscillation o = oscillate(s, 40, exact, 1.0 / 240.0);
  EXPECT_NEAR(o.period, exact, s.stepping.periodTolerance * exact);
  EXPECT_NEAR(o.lastPeak, 0.1, 0.02) << "the amplitude neither grows nor decays";
}

TEST(Oscillator, dampedAmplitudeFollowsTheLogarithmicDecrement) {
  SoftBodySettings s = finelySteppedPair();
  const double zeta = 0.02;
  s.damping = 2 * zeta * std::sqrt(16.0 * 0.1);
  const double omega = std::sqrt(16.0 / 0.1);
  const double period = 2 * M_PI / (omega * std::sqrt(1 - zeta * zeta));
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(pairNetwork(), s);
  body->pin(0);
  body->point(1)->getWorldTransform().setOrigin(vec(1.1, 0, 0));
  // the exact solution for a start from rest at 0.1 m, compared after every tick of five periods
  const double damped = omega * std::sqrt(1 - zeta * zeta);
  for (int i = 1; i * (1.0 / 60) < 5 * period; ++i) {
    bullet.tick();
    const double t = i / 60.0;
    const double exact = 0.1 * std::exp(-zeta * omega * t) *
                         (std::cos(damped * t) + zeta * omega / damped * std::sin(damped * t));
    // a phase error of 1e-5 over five periods is 3e-4 rad of 0.1 m
    EXPECT_NEAR(body->position(1).x() - 1.0, exact, 5e-5) << "t " << t;
  }
}

/// Lets a chain that is held at one end oscillate in one of its modes for some 100 rad. Returns the relative
/// error of its frequency. With N free points of mass m, mode j moves point n by sin(n theta), with
///     theta = (2 j - 1) pi / (2 N + 1),   omega = 2 sqrt(k / m) sin(theta / 2).
double frequencyErrorOfMode(int mode, const SoftBodySettings& s, int links) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(chainNetwork(links), s);
  body->pin(0);
  const double theta = (2 * mode - 1) * M_PI / (2 * links + 1), amplitude = 1e-3;
  const double omega =
      2.0 * std::sqrt(s.extensionStiffness / (s.totalMass / (links + 1))) * std::sin(0.5 * theta);
  for (int n = 1; n <= links; ++n)
    body->point(std::uint32_t(n))
        ->getWorldTransform()
        .setOrigin(vec(0, -double(n) / links - amplitude * std::sin(n * theta), 0));
  const int ticks = static_cast<int>(100.0 / omega * 60.0);
  for (int i = 0; i < ticks; ++i) bullet.tick();
  double x = 0.0, v = 0.0;
  for (int n = 1; n <= links; ++n) {
    const auto point = static_cast<std::uint32_t>(n);
    x -= std::sin(n * theta) * (body->position(point).y() + double(n) / links);
    v -= std::sin(n * theta) * body->velocity(point).y();
  }
  const double phase = omega * ticks / 60.0;
  return std::remainder(std::atan2(-v / omega, x) - phase, 2.0 * M_PI) / phase;
}

TEST(FastStepping, slowOscillationsAreRightWithinTwoPercent) {
  SoftBodySettings s = testedSettings();
  s.totalMass = 1.0;
  s.extensionStiffness = s.compressionStiffness = 1e4;  // the fastest mode: 623 rad/s, in 8 substeps
  s.damping = 0.0;
  s.stepping = Stepping::fast();
  // Verlet's error of a frequency is (omega dt)^2 / 24:  5e-4, 0.5 %, 1.2 % for the first modes
  for (const int mode : {1, 2, 3}) EXPECT_LT(std::abs(frequencyErrorOfMode(mode, s, 9)), 0.02) << mode;
}

TEST(FastStepping, takesTenSubstepsAtAnyStiffness) {
  SoftBodySettings s = testedSettings();
  s.stepping = Stepping::fast();
  for (const double stiffness : {1.0, 1e4, 1e8}) {
    s.extensionStiffness = s.compressionStiffness = stiffness;
    SoftWorld bullet(0.0);
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    bullet.tick();
    EXPECT_LE(body->substeps(), 10) << stiffness;
    EXPECT_GE(body->substeps(), 2) << stiffness;
  }
}

TEST(HangingChain, sagIsExactAtAnyTick) {
  const int links = 16;
  const double mass = 0.1, g = 9.81;
  for (double k : {1e3, 1e5})
    for (double dt : {1.0 / 30, 1.0 / 60, 1.0 / 120, 1.0 / 240}) {
      SoftWorld bullet(-g);
      SoftBodySettings s = testedSettings();
      s.totalMass = mass * (links + 1);
      s.extensionStiffness = s.compressionStiffness = k;
      s.damping = std::sqrt(k * mass);  // the slowest oscillation then has a damping ratio of about 0.05
      SoftBody* body = bullet.addSoft(chainNetwork(links), s);
      for (std::uint32_t i = 0; i <= static_cast<std::uint32_t>(links); ++i)
        body->point(i)->setActivationState(DISABLE_DEACTIVATION);
      body->pin(0);
      bullet.simulate(k < 1e4 ? 30.0 : 3.0, dt);
      // link i carries the masses below it: sag = m g / k * (1 + 2 + ... + links)
      const double sag = mass * g / k * links * (links + 1) / 2;
      EXPECT_NEAR(-body->position(links).y() - 1.0, sag, 1e-4 * sag) << "k " << k << " dt " << dt;
    }
}

TEST(FreeFlight, centreOfMassFollowsTheExactParabola) {
  for (double dt : {1.0 / 30, 1.0 / 60, 1.0 / 240}) {
    SoftWorld bullet(-9.81);
    SoftBodySettings s = testedSettings();
    s.linearVelocity = {1.5, 4.0, -0.5};
    s.angularVelocity = {1.0, 2.0, 3.0};
    SoftBody* body = bullet.addSoft(cubeNetwork(), s);
    bullet.simulate(2.0, dt);
    const Eigen::Vector3d exact =
        2.0 * s.linearVelocity + Eigen::Vector3d(0, -0.5 * double(btScalar(9.81)) * 4.0, 0);
    // Bullet rounds the force m g to btScalar once per point and step: a relative error of 1e-7 of 20 m
    EXPECT_LT((body->centerOfMass() - exact).norm(), 1e-5) << "dt " << dt;
  }
}

TEST(FreeFlight, linearAndAngularMomentumAreKept) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.linearVelocity = {0.3, -0.2, 0.1};
  s.angularVelocity = {3.0, 1.0, -2.0};
  s.scale = {1.0, 1.3, 0.7};
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  body->point(0)->applyCentralImpulse(vec(0.2, 0.1, 0.3));
  const Eigen::Vector3d p = body->linearMomentum(), l = body->angularMomentum();
  bullet.simulate(10.0);
  // the state is double and Bullet does not change it: the rounding of 1e5 substeps
  EXPECT_LT((body->linearMomentum() - p).norm(), 1e-12 * p.norm());
  EXPECT_LT((body->angularMomentum() - l).norm(), 1e-10 * l.norm());
}

TEST(FreeFlight, undampedEnergyNeitherGrowsNorFalls) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.damping = 0.0;
  s.angularVelocity = {3.0, 1.0, -2.0};
  SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
  const auto energy = [&] { return energyOf(*body); };
  const double start = energy();
  double lowest = start, highest = start;
  for (int i = 0; i < 3600; ++i) {
    bullet.tick();
    lowest = std::min(lowest, energy());
    highest = std::max(highest, energy());
  }
  // the scheme is symplectic: its energy swings by (omega dt)^2/8 of the stiff oscillations', without drift
  EXPECT_LT(highest, 1.02 * start);
  EXPECT_GT(lowest, 0.98 * start);
}

/// Bodies of tetrahedra so stiff that Verlet is slow and the midpoint rule, with few substeps, is thrown by
/// the rotation: with its usual number it loses 10 % to all of the energy here. Momentum is kept to rounding;
/// the energy may swing by 1e-4 of itself.
TEST(FreeFlight, stiffSpinningBodiesKeepSpinAndEnergy) {
  const SharedNetwork network = solidNetwork(small_meshes::cube(), 60);
  struct Case {
    double stiffness, turn, hertz;
  };
  for (const auto [stiffness, turn, hertz] :
       variants<Case>({{1e6, 1.0, 30.0}, {1e6, 10.0, 15.0}}, {{1e6, 10.0, 60.0}, {1e7, 3.0, 60.0}})) {
    SCOPED_TRACE(testing::Message() << stiffness << " N/m, " << turn << " rad/s, " << hertz << " Hz");
    SoftWorld bullet(0.0);
    SoftBodySettings s = testedSettings();
    s.damping = s.sleepingSpeed = 0.0;
    s.extensionStiffness = s.compressionStiffness = stiffness;
    s.angularVelocity = turn * Eigen::Vector3d(1, 2, 0.5);
    const SoftBody* body = bullet.addSoft(network, s);
    const Eigen::Vector3d spin = body->angularMomentum();
    const double energy = body->kineticEnergy();
    bullet.simulate(0.8, 1.0 / hertz);
    EXPECT_LT((body->angularMomentum() - spin).norm(), 1e-9 * spin.norm());
    EXPECT_NEAR(energyOf(*body) / energy, 1.0, 5e-4);
  }
}

double hangingEnergyOf(const SoftBody& body, double gravity) {
  return body.kineticEnergy() + body.elasticEnergy() +
         body.settings().totalMass * gravity * body.centerOfMass().y();
}

/// A swinging cloth without dampers or drag. Verlet conserves a quantity that is another one for each length
/// of the substep: random ticks would add 3 J in half a minute, a third of the kinetic energy.
TEST(UndampedCloth, gainsNoEnergyWithTicksOfAnyLength) {
  constexpr double kGravity = 9.81;
  SoftWorld bullet(-kGravity);
  SoftBodySettings s = testedSettings();
  setSprings(s, 200.0, 0.0);
  SoftBody* cloth = bullet.addSoft(squareCloth(8), s);
  cloth->pin(0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> lengths(0.005, 0.05);
  const double start = hangingEnergyOf(*cloth, kGravity);
  double most = start, least = start, fastest = 0.0;
  for (double t = 0.0; t < 30.0;) {
    const double tick = lengths(random);
    bullet.tick(tick);
    t += tick;
    most = std::max(most, hangingEnergyOf(*cloth, kGravity));
    least = std::min(least, hangingEnergyOf(*cloth, kGravity));
    fastest = std::max(fastest, cloth->kineticEnergy());
  }
  EXPECT_LT(most - start, 0.01 * fastest);
  EXPECT_GT(least - start, -0.1 * fastest);
}

/// Verlet's error at each passage of the rest length would heat the rope by 2 to 20 J in 20 s, at omega dt
/// = 1. What is lost instead is of fourth order: a hundredth with the tolerance of a tenth. The energy
/// wanders up by 0.07 of 5 J at most.
TEST(UndampedRope, thatBearsLittleCompressionGainsNoEnergy) {
  constexpr double kGravity = 9.81;
  for (const double compression : {0.0, 100.0})
    for (const double tolerance : {0.04, 0.004}) {
      SoftWorld bullet(-kGravity);
      SoftBodySettings s = testedSettings();
      s.extensionStiffness = 1000.0;
      s.compressionStiffness = compression;
      s.damping = 0.0;
      s.stepping.periodTolerance = tolerance;
      SoftBody* rope = bullet.addSoft(*buildRope(), s);
      rope->pin(0);
      const double start = hangingEnergyOf(*rope, kGravity);
      for (int i = 0; i < 1200; ++i) {
        bullet.tick();
        ASSERT_LT(hangingEnergyOf(*rope, kGravity) - start, 0.15) << i;
      }
      EXPECT_GT(hangingEnergyOf(*rope, kGravity) - start, tolerance > 0.01 ? -4.0 : -0.2);
    }
}

/// The same for a spring between a body and a place in the world.
TEST(UndampedSpring, thatBearsNoCompressionGainsNoEnergy) {
  SoftWorld bullet(0.0);
  btRigidBody* box = bullet.addBox(vec(0.1, 0.1, 0.1), 2.0, vec(0, 0, 0));
  box->setLinearVelocity(vec(0.5, 1, 0.2));
  SpringSettings s;
  s.restLength = 0.5;
  s.stiffness = 1000.0;
  s.action = SpringAction::ExtensionOnly;
  const SpringEnd onBox{box, vec(0.05, 0.1, 0.03)}, inWorld{nullptr, vec(0, 0.5, 0)};
  ASSERT_TRUE(bullet.system.addSpring(onBox, inWorld, s));
  const auto energy = [&] {
    const double stretch = double((box->getWorldTransform() * onBox.pivot - inWorld.pivot).length()) - 0.5;
    return kineticEnergyOf(*box) + 500.0 * std::pow(std::max(0.0, stretch), 2);
  };
  const double start = energy();
  for (int i = 0; i < 1800; ++i) {
    bullet.tick(1.0 / 30.0);
    ASSERT_NEAR(energy() / start, 1.0, 0.05) << i;
  }
}

TEST(StiffCube, movesLikeARigidCubeOfTheSameMass) {
  // flight and rotation under a force at the centre, compared with a rigid body of Bullet
  SoftWorld bullet(-9.81);
  btRigidBody* rigid = bullet.addBox(btVector3(0.5, 0.5, 0.5), 1.0, btVector3(5, 0, 0));
  // eight corner masses of 1/8 kg at +-0.5 m have the inertia m (0.25 + 0.25)
  rigid->setMassProps(1.0, btVector3(0.5, 0.5, 0.5));
  rigid->setAngularVelocity(btVector3(0, 2, 0));
  SoftBodySettings s = testedSettings();
  setSprings(s, 1e5, 50.0);
  s.angularVelocity = {0, 2, 0};
  SoftBody* soft = bullet.addSoft(fullCubeNetwork(), s);
  const double dt = 1.0 / 240.0;
  for (int i = 0; i < 240; ++i) {
    rigid->applyCentralForce(btVector3(3, 0, 1));
    for (std::uint32_t k = 0; k < 8; ++k) soft->point(k)->applyCentralForce(btVector3(3, 0, 1) / 8);
    bullet.tick(dt);
  }
  // Bullet's rigid body falls by symplectic Euler, g h t / 2 too far. The tolerance is this error.
  const double euler = 9.81 * dt * 1.0 / 2;
  const btVector3 r = rigid->getWorldTransform().getOrigin();
  EXPECT_NEAR(soft->centerOfMass().y(), double(r.y()), 1.05 * euler);
  EXPECT_NEAR(soft->centerOfMass().x(), double(r.x()) - 5.0, 1.05 * 3.0 * dt / 2);
  const Eigen::Vector3d edge = soft->position(1) - soft->position(0);
  const btVector3 axis = rigid->getWorldTransform().getBasis().getColumn(0);
  EXPECT_NEAR(std::atan2(edge.z(), edge.x()), std::atan2(double(axis.z()), double(axis.x())), 5e-3);
}

}  // namespace
}  // namespace limber::test
