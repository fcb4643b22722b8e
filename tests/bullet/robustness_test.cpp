// SPDX-License-Identifier: Zlib
// Unusual scenes: networks without springs, values that are not finite, invalid links, state between ticks,
// and pins of two bodies in one place.
#include "support/soft_world.h"
#include "support/variants.h"

#include <cmath>
#include <limits>

namespace limber::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// --- networks ----------------------------------------------------------------------------------------------

/// Returns points in a row along x, without springs.
SharedNetwork loosePoints(int count) {
  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Rope;
  for (int i = 0; i < count; ++i) network->restPoints.emplace_back(0.3 * i, 0.0, 0.0);
  network->massFractions.assign(static_cast<std::size_t>(count), 1.0 / count);
  return network;
}

TEST(WithoutSprings, pointsFlyAndComeToRest) {
  for (const int count : {1, 3})
    for (const Stepper stepper : {Stepper::Auto, Stepper::ImplicitMidpoint, Stepper::Newton}) {
      SoftWorld bullet;
      bullet.addBoxFloor();
      SoftBodySettings s = settingsAt({0, 0.5, 0});
      s.pointRadius = 0.05;
      s.stepping.stepper = stepper;
      const Result<SoftBody*> made = bullet.system.createBody(loosePoints(count), s);
      ASSERT_TRUE(made) << made.error();
      bullet.simulate(0.25);
      // free fall, within Bullet's rounding
      EXPECT_NEAR((*made)->centerOfMass().y(), 0.5 - 0.5 * 9.81 * 0.25 * 0.25, 0.03) << count;
      bullet.simulate(1.5);
      // contacts may be as deep as this fraction of the radius
      EXPECT_NEAR((*made)->centerOfMass().y(), 0.05, 0.005) << count;
    }
}

TEST(WithoutSprings, pointsCarryARigidBody) {
  if (!kSurface) GTEST_SKIP() << "the box meets points in Bullet's solver";
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBodySettings s = settingsAt({0, 0.1, 0});
  s.pointRadius = 0.1;
  ASSERT_TRUE(bullet.system.createBody(loosePoints(3), s));
  btRigidBody* box = bullet.addBox(vec(0.5, 0.1, 0.02), 1.0, vec(0.3, 0.35, 0.0));
  box->setAngularFactor(vec(0, 0, 1));
  bullet.simulate(0.5);
  EXPECT_GT(heightOf(*box), 0.25) << "it would lie at 0.1 on the floor";
}

TEST(RestLengthZero, asksForNoMoreThanItsSpringConstantDoes) {
  // two springs of length 0; the points of one are pulled apart and released, and pass each other
  auto network = std::make_shared<SpringNetwork>();
  network->restPoints = {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  network->massFractions.assign(4, 0.25);
  network->springs = {{0, 1}, {0, 2}, {2, 3}};
  SoftWorld bullet(0.0);
  const Result<SoftBody*> made = bullet.system.createBody(network, testedSettings());
  ASSERT_TRUE(made) << made.error();
  (*made)->point(1)->applyCentralImpulse(vec(1e-3, 1, 0));
  int largest = 0;
  for (int i = 0; i < 60; ++i) {
    bullet.tick();
    largest = std::max(largest, (*made)->substeps());
  }
  EXPECT_LE(largest, 1000);
  EXPECT_TRUE(std::isfinite((*made)->kineticEnergy()));
}

// --- values that are not finite ----------------------------------------------------------------------------

struct NotFinite : testing::Test {
  NotFinite() {
    bullet.addBoxFloor();
    system.onWarning([this](const std::string& text) { warnings.push_back(text); });
    body = *system.createBody(closedCubeNetwork(), settingsAt({0, 2.0, 0}));
    other = *system.createBody(closedCubeNetwork(), settingsAt({0, 5.0, 0}));
    bullet.simulate(0.1);
  }
  /// Expects a full recovery: one warning, no effect on the other body, and a body that comes to rest as
  /// usual.
  void expectRecovery() {
    const double height = body->centerOfMass().y();
    ASSERT_TRUE(std::isfinite(height));
    bullet.tick();
    EXPECT_EQ(warnings.size(), 1u);
    EXPECT_EQ(body->restorations(), 1u);
    EXPECT_EQ(other->restorations(), 0u);
    bullet.simulate(3.0);
    EXPECT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(body->alive());
    EXPECT_TRUE(std::isfinite(body->kineticEnergy()));
    EXPECT_NEAR(body->centerOfMass().y(), 0.5, 0.1);
    EXPECT_GT(body->substeps() + body->sleeping(), 0);
  }
  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};
  std::vector<std::string> warnings;
  SoftBody *body, *other;
};

TEST_F(NotFinite, anImpulse) {
  body->point(3)->applyCentralImpulse(vec(kNan, 0, 0));
  bullet.tick();
  expectRecovery();
}

TEST_F(NotFinite, aVelocityBeyondFloats) {
  body->point(3)->setLinearVelocity(vec(0, 1e30, 0));
  bullet.tick();
  expectRecovery();
}

TEST_F(NotFinite, aPosition) {
  body->point(3)->getWorldTransform().setOrigin(vec(0, HUGE_VAL, kNan));
  bullet.tick();
  expectRecovery();
}

TEST_F(NotFinite, aForce) {
  body->point(3)->applyCentralForce(vec(0, kNan, 0));
  bullet.tick();
  expectRecovery();
}

TEST_F(NotFinite, readBeforeTheTick) {
  body->point(3)->setLinearVelocity(vec(0, kNan, 0));
  EXPECT_TRUE(std::isfinite(body->kineticEnergy()));
  bullet.tick();
  expectRecovery();
}

/// An action that runs before the end of the tick, when the step has been checked already.
TEST(NotFiniteAction, isRepairedAtTheEndOfTheTick) {
  BulletWorld bullet;
  ActionOnce action;
  bullet.world->addAction(&action);
  {
    SoftBodySystem system(*bullet.world);
    system.onWarning([](const std::string&) {});
    SoftBody* body = *system.createBody(cubeNetwork(), settingsAt({0, 5, 0}));
    bullet.tick();
    action.act = [&] { body->point(0)->setLinearVelocity(vec(kNan, 0, 0)); };
    bullet.tick();
    const double height = body->position(1).y();
    for (int i = 0; i < 10; ++i) bullet.tick();
    EXPECT_EQ(body->restorations(), 1u);
    EXPECT_LT(body->position(1).y(), height) << "falls on";
  }
  bullet.world->removeAction(&action);
}

TEST(NotFiniteSleeper, isReportedWhileItSleeps) {
  if (!kSurface) GTEST_SKIP() << "point masses of the world have no common object";
  SoftWorld bullet;
  bullet.addBoxFloor();
  int warnings = 0;
  bullet.system.onWarning([&](const std::string&) { ++warnings; });
  SoftBodySettings s = settingsAt({0, 0.6, 0});
  s.damping = 5.0;
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), s);
  for (int i = 0; i < 2000 && !body->sleeping(); ++i) bullet.tick();
  ASSERT_TRUE(body->sleeping());
  body->surfaceObject()->setLinearVelocity(vec(kNan, 0, 0));
  EXPECT_TRUE(body->position(0).allFinite());
  bullet.tick();
  bullet.tick();
  EXPECT_EQ(body->restorations(), 1u);
  EXPECT_EQ(warnings, 1);
}

TEST(TooLarge, isRefused) {
  SoftWorld bullet;
  const auto refusal = [&](auto change) {
    SoftBodySettings s = testedSettings();
    change(s);
    const Result<SoftBody*> made = bullet.system.createBody(cubeNetwork(), s);
    return made ? std::string() : made.error();
  };
  EXPECT_EQ(refusal([](auto& s) { s.scale.setConstant(1e100); }),
            "settings: scale.x is 1e+100, must be from -1e9 to 1e9");
  EXPECT_EQ(refusal([](auto& s) { s.scale.y() = 1e-100; }),
            "settings: scale.y is 1e-100, must be 1e-9 or more, or -1e-9 or less");
  EXPECT_EQ(refusal([](auto& s) { s.position.z() = -1e30; }),
            "settings: position.z is -1e+30, must be from -1e6 to 1e6");
  EXPECT_EQ(refusal([](auto& s) { s.scale.setConstant(1e7); }),
            "point 0 would have a coordinate of 5e+06 m, must be at most 2e6");
  EXPECT_EQ(refusal([](auto& s) { s.angularVelocity.z() = 1e5, s.scale.setConstant(100.0); }),
            "point 0 would move at 7.07107e+06 m/s, must be at most 1e6");
  EXPECT_EQ(refusal([](auto& s) { s.scale.setConstant(1e-8); }),
            "the body would be 1.73205e-08 m across, must be at least 1e-6");
  EXPECT_EQ(bullet.system.bodyCount(), 0u);
}

TEST(TooLarge, aSpringOfTheNetworkIsRefused) {
  SoftWorld bullet;
  SpringNetwork network = *cubeNetwork();
  network.springs[3].stiffnessScale = 1e38;
  EXPECT_EQ(
      bullet.system.createBody(std::make_shared<const SpringNetwork>(network), testedSettings()).error(),
      "spring 3 would have a stiffness or damping of 1e+41, must be at most 1e12");
}

// --- links -------------------------------------------------------------------------------------------------

TEST(WrongLinks, thatAreNoneAreRefused) {
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world), other(*bullet.world);
  btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 5, 0));
  SpringConstraint* gone = *system.addSpring({box}, {nullptr});
  SpringConstraint* foreign = *other.addSpring({box}, {nullptr});
  system.removeSpring(gone);
  for (SpringConstraint* spring : {gone, foreign, static_cast<SpringConstraint*>(nullptr)})
    EXPECT_FALSE(system.changeSpring(spring, SpringSettings()));
  EXPECT_TRUE(other.changeSpring(foreign, SpringSettings()));
  EXPECT_FALSE(system.attach(nullptr, 0, *box));
  EXPECT_FALSE(system.attach(nullptr, 0, *box, btVector3(0, 0, 0)));
  EXPECT_FALSE(system.detach(nullptr, 0));
}

TEST(WrongLinks, areRefused) {
  BulletWorld bullet, elsewhere;
  btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 5, 0));
  SoftBodySystem system(*bullet.world), far(*elsewhere.world);
  SoftBody* body = *system.createBody(cubeNetwork(), settingsAt({0, 1, 0}));
  SoftBody* theirs = *far.createBody(cubeNetwork(), settingsAt({0, 1, 0}));
  const std::string world = "the point mass belongs to a soft body in another world";
  EXPECT_EQ(system.addSpring({body->point(0)}, {theirs->point(0)}).error(), world);
  EXPECT_EQ(far.addSpring({body->point(0)}, {nullptr}).error(), world);
  EXPECT_EQ(far.attach(body, 0, *box).error(), "the soft body is not, or no longer, in this world");
  EXPECT_EQ(system.addSpring({body->point(0)}, {body->point(0)}).error(),
            "both ends of the spring are the same place of one body");
  EXPECT_EQ(system.addSpring({body->point(0), vec(0.5, 0, 0)}, {box}).error(),
            "the pivot of a spring on a point mass must be 0");
  EXPECT_EQ(system.addSpring({body->point(0), vec(kNan, 0, 0)}, {box}).error(),
            "a pivot of the spring is not finite, or farther than 1e6");
  EXPECT_EQ(system.addSpring({box, vec(kNan, 0, 0)}, {nullptr}).error(),
            "a pivot of the spring is not finite, or farther than 1e6");
  EXPECT_FALSE(system.addSpring({box, vec(1e30, 0, 0)}, {nullptr}));
  EXPECT_FALSE(system.attach(body, 0, *box, vec(0, 1e30, 0)));
  if (kSurface) {
    EXPECT_FALSE(system.addSpring({body->surfaceObject()}, {box}));
    EXPECT_FALSE(system.addSpring({box}, {body->surfaceObject()}));
    EXPECT_FALSE(system.attach(body, 0, *theirs->surfaceObject()));
  }
  EXPECT_EQ(system.springCount() + far.springCount(), 0u);
  bullet.tick();
  elsewhere.tick();
}

// --- state between ticks -----------------------------------------------------------------------------------

TEST(BetweenTicks, synchronizingMotionStatesLosesNoForce) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(cubeNetwork());
  for (int i = 0; i < 3; ++i) {
    const double before = body->linearMomentum().x();
    body->point(0)->applyCentralForce(btVector3(3, 0, 0));
    bullet.world->synchronizeMotionStates();
    body->point(1)->applyCentralForce(btVector3(2, 0, 0));
    bullet.world->synchronizeMotionStates();
    bullet.tick();
    EXPECT_NEAR(body->linearMomentum().x() - before, 5 * kTick, 1e-6) << i;
    // Forces that a step without a tick has cleared are lost, as with Bullet's own bodies.
    body->point(0)->applyCentralForce(btVector3(100, 0, 0));
    bullet.world->stepSimulation(0, 1);
  }
}

TEST(NotFiniteGravity, doesNotHoldTheBodyForGood) {
  for (const bool world : {true, false}) {
    SoftWorld bullet;
    bullet.system.onWarning([](const std::string&) {});
    SoftBody* body = bullet.addSoft(cubeNetwork());
    bullet.tick();
    btRigidBody* point = world ? nullptr : body->point(0);
    const auto setGravity = [&](btScalar y) {
      if (world) return bullet.world->setGravity(btVector3(0, y, 0));
      point->setGravity(btVector3(0, y, 0));
    };
    // Bullet takes points of infinite acceleration out of the simulation; a NaN it does not notice
    setGravity(static_cast<btScalar>(std::nan("")));
    bullet.tick();
    setGravity(btScalar(-10));
    const double height = body->centerOfMass().y();
    bullet.simulate(0.5);
    EXPECT_LT(body->centerOfMass().y(), height - 0.5);
    EXPECT_GT(body->restorations(), 0u);
    EXPECT_GT(body->totalMass(), 0.9);
  }
}

TEST(BetweenTicks, massesAreThoseOfNow) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.totalMass = 8.0;
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  body->point(0)->setMassProps(5, btVector3(0, 0, 0));
  EXPECT_NEAR(body->totalMass(), 12.0, 1e-5);
  body->pin(0);
  EXPECT_NEAR(body->totalMass(), 7.0, 1e-5);
  bullet.tick();
  EXPECT_NEAR(body->totalMass(), 7.0, 1e-5);
  body->unpin(0);
  EXPECT_NEAR(body->totalMass(), 12.0, 1e-5) << "with the mass that it had before";
}

TEST(BetweenTicks, whatIsReadDoesNotDependOnWhatWasReadBefore) {
  SoftWorld bullet;
  SoftBodySettings s = settingsAt({0, 3, 0});
  s.collisionMask = 0;  // two bodies at the same position
  SoftBody* a = bullet.addSoft(cubeNetwork(), s);
  SoftBody* b = bullet.addSoft(cubeNetwork(), s);
  for (SoftBody* body : {a, b}) body->point(0)->setLinearVelocity(vec(0.5, 0, 0));
  bullet.simulate(0.2);
  for (SoftBody* body : {a, b})
    for (std::uint32_t i = 0; i < 8; ++i) body->point(i)->translate(vec(4, 0, 0));
  EXPECT_GT(b->centerOfMass().x(), 3.9);
  std::array<float, 24> first, second;
  a->writePositions(first.data(), 0.5);
  b->writePositions(second.data(), 0.5);
  for (std::size_t i = 0; i < 24; ++i) EXPECT_NEAR(first[i], second[i], 1e-6) << i;
  bullet.tick();
  EXPECT_EQ(a->stateHash(), b->stateHash());
}

TEST(BetweenTicks, aSleeperWhosePointWasMovedWakesThoughItWasRead) {
  if (!kSurface) GTEST_SKIP() << "the user wakes bodies of the world, as Bullet has it";
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(cubeNetwork());
  for (int i = 0; i < 600 && !body->sleeping(); ++i) bullet.tick();
  ASSERT_TRUE(body->sleeping());
  body->point(0)->translate(vec(0.2, 0, 0));
  EXPECT_GT(body->centerOfMass().x(), 0.01);
  bullet.tick();
  EXPECT_FALSE(body->sleeping());
}

// --- pins of two bodies in one place -----------------------------------------------------------------------

/// Two cloths of 1 kg whose edges are held next to each other, and the largest energies while they fall.
struct HeldNearby {
  double kinetic = 0.0, total = 0.0;  ///< J, above the start
  unsigned restorations = 0;

  explicit HeldNearby(double apart, bool attached) {
    SoftWorld bullet(-10.0);
    btRigidBody* rail = bullet.addBox(vec(0.01, 0.01, 0.01), 0.0, vec(0, 5, 0));
    for (int k = 0; k < 2; ++k) {
      SoftBodySettings s = settingsAt({0, apart * k, 0});
      s.pointRadius = 0.01;
      SoftBody* cloth = bullet.addSoft(squareCloth(6), s);
      for (std::uint32_t i = 0; i < 7; ++i)
        EXPECT_TRUE(attached ? bullet.system.attach(cloth, i, *rail) : cloth->pin(i));
    }
    const double start = energyOf(bullet.system);
    for (int i = 0; i < 60; ++i) {
      bullet.tick();
      total = std::max(total, energyOf(bullet.system) - start);
      for (std::size_t b = 0; b < 2; ++b) {
        kinetic = std::max(kinetic, bullet.system.body(b)->kineticEnergy());
        restorations += bullet.system.body(b)->restorations();
      }
    }
  }

  static double energyOf(const SoftBodySystem& system) {
    double sum = 0.0;
    for (std::size_t b = 0; b < system.bodyCount(); ++b) sum += test::energyOf(*system.body(b), 10.0);
    return sum;
  }
};

TEST(PinsNearby, contactsBetweenHeldPointsPushNothing) {
  for (const bool attached : {false, true})
    for (const double apart : test::variants({0.0, 1e-4, 0.015}, {1e-6, 1e-3})) {
      const HeldNearby cloths(apart, attached);
      // a cloth that swings down by 1 m falls by about half a metre: 5 J
      EXPECT_LT(cloths.kinetic, 6.0) << apart << (attached ? " attached" : " pinned");
      // overlaps of up to two radii are pushed apart, which strains the cloths
      EXPECT_LT(cloths.total, 1.5) << apart << (attached ? " attached" : " pinned");
      EXPECT_EQ(cloths.restorations, 0u);
    }
}

/// The free points of a rope with one spring have no extent: its inertia is 0, and must not be its rounding.
TEST(PinsNearby, aRopeOfOneSpringHangs) {
  for (const double degrees : {0.0, 0.1, 20.0}) {
    SoftWorld bullet;
    SoftBodySettings s = testedSettings();
    s.totalMass = 0.2;
    s.damping = 1.0;
    s.rotation = Eigen::AngleAxisd(degrees * M_PI / 180.0 - M_PI / 2.0, Eigen::Vector3d::UnitZ());
    SoftBody* rope = bullet.addSoft(*buildRope({1, 1, 0}), s);
    ASSERT_TRUE(rope->pin(0));
    bullet.simulate(5.0);
    EXPECT_EQ(rope->restorations(), 0u) << degrees;
    EXPECT_NEAR(rope->position(1).norm(), 1.0 + 0.1 * 9.81 / 1000.0, 1e-4) << degrees;
  }
}

TEST(PinsNearby, pinsOfTwoCubesMoveToOnePlace) {
  for (const double apart : {0.0, 1e-6, 1e-4, 1e-3, 0.015}) {
    SoftWorld bullet(-10.0);
    SoftBodySettings s = testedSettings();
    SoftBody* a = bullet.addSoft(closedCubeNetwork(), s);
    s.position = {0, 1.5, 0};
    s.rotation = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY());
    SoftBody* b = bullet.addSoft(closedCubeNetwork(), s);
    ASSERT_TRUE(a->pin(0));
    ASSERT_TRUE(b->pin(0));
    const Eigen::Vector3d target = a->position(0) + Eigen::Vector3d(apart, 0, 0);
    ASSERT_TRUE(b->movePin(0, vec(target.x(), target.y(), target.z())));
    double fastest = 0.0;
    for (int i = 0; i < 60; ++i) {
      bullet.tick();
      for (std::uint32_t k = 1; k < 8; ++k) fastest = std::max(fastest, b->velocity(k).norm());
    }
    // the pin moves by 2 m in a tick: 120 m/s
    EXPECT_LT(fastest, 240.0) << apart;
    EXPECT_EQ(a->restorations() + b->restorations(), 0u);
  }
}

}  // namespace
}  // namespace limber::test
