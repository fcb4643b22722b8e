// SPDX-License-Identifier: Zlib
// All points of a soft body fall asleep and wake together.
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <algorithm>
#include <functional>
#include <vector>

namespace limber::test {
namespace {

struct SleepTest : testing::Test {
  SleepTest() : system(*bullet.world) { bullet.addBoxFloor(); }
  ~SleepTest() override { gDeactivationTime = 2; }

  SoftBody* restingCube(double x = 0, double y = 0.52) {
    return *system.createBody(cubeNetwork(), settingsAt({x, y, 0}));
  }

  BulletWorld bullet;
  SoftBodySystem system;
};

int activePoints(const SoftBody& body) {
  int count = 0;
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) count += body.point(i)->isActive();
  return count;
}

TEST_F(SleepTest, allPointsFallAsleepInOneTick) {
  SoftBody* body = restingCube();
  for (int i = 0; i < 600 && !body->sleeping(); ++i) {
    bullet.tick();
    ASSERT_TRUE(activePoints(*body) == 8 || activePoints(*body) == 0) << "tick " << i;
  }
  EXPECT_TRUE(body->sleeping());
  EXPECT_EQ(activePoints(*body), 0);
  const std::uint64_t asleep = body->stateHash();
  bullet.simulate(1.0);
  EXPECT_EQ(body->stateHash(), asleep) << "asleep nothing moves, to the bit";
  EXPECT_EQ(body->substeps(), 0);
  EXPECT_EQ(system.profile().pointsStepped, 0u) << "and nothing is stepped";
}

TEST_F(SleepTest, oneWokenPointWakesAll) {
  SoftBody* body = restingCube();
  bullet.simulate(6.0);
  ASSERT_TRUE(body->sleeping());
  body->point(4)->activate();
  bullet.tick();
  EXPECT_EQ(activePoints(*body), 8);
  EXPECT_FALSE(body->sleeping());
  bullet.simulate(6.0);
  EXPECT_TRUE(body->sleeping()) << "and it settles again";
}

TEST_F(SleepTest, aFallingBoxWakesIt) {
  SoftBody* body = restingCube();
  bullet.simulate(6.0);
  ASSERT_TRUE(body->sleeping());
  bullet.addBox(vec(0.6, 0.1, 0.6), 0.2, vec(0, 2.0, 0));
  bool woken = false;
  for (int i = 0; i < 120; ++i) {
    bullet.tick();
    woken = woken || activePoints(*body) == 8;
  }
  EXPECT_TRUE(woken);
}

TEST_F(SleepTest, neverWhileSomethingOnItIsAwake) {
  SoftBody* body = restingCube();
  bullet.addAwakeBox(vec(0.6, 0.1, 0.6), 0.2, vec(0, 1.12, 0));
  bullet.simulate(10.0);
  EXPECT_FALSE(body->sleeping());
  EXPECT_EQ(activePoints(*body), 8);
}

TEST_F(SleepTest, aRigidBodyOnItSleepsToo) {
  SoftBody* body = restingCube();
  btRigidBody* plate = bullet.addBox(vec(0.6, 0.1, 0.6), 0.2, vec(0, 1.12, 0));
  bullet.simulate(15.0);
  EXPECT_TRUE(body->sleeping());
  EXPECT_FALSE(plate->isActive());
}

TEST_F(SleepTest, bulletsSwitchesAreHonoured) {
  SoftBody* body = restingCube();
  gDeactivationTime = 0;
  bullet.simulate(6.0);
  EXPECT_FALSE(body->sleeping()) << "gDeactivationTime 0 turns sleeping off";
  gDeactivationTime = btScalar(0.2);
  bullet.simulate(1.0);
  EXPECT_TRUE(body->sleeping());
  body->wake();
  body->point(1)->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(3.0);
  EXPECT_FALSE(body->sleeping());
}

TEST_F(SleepTest, bodiesThatComeAndGoDoNotWakeIt) {
  SoftBody* body = restingCube();
  bullet.simulate(6.0);
  ASSERT_TRUE(body->sleeping());
  SoftBody* other = restingCube(5.0);
  bullet.simulate(0.1);
  EXPECT_TRUE(body->sleeping());
  EXPECT_FALSE(other->sleeping());
  system.destroyBody(other);
  bullet.simulate(0.1);
  EXPECT_TRUE(body->sleeping());
}

TEST_F(SleepTest, aSlowSwingIsNotRest) {
  SoftBody* rope = *system.createBody(pairNetwork(), settingsAt({0, 4, 0}));
  rope->pin(0);
  for (int i = 0; i < 600; ++i) {
    bullet.tick();
    ASSERT_FALSE(rope->sleeping()) << "tick " << i;
  }
}

TEST_F(SleepTest, gravityReachesAllPointsOfAWokenBody) {
  SoftBody* body = restingCube();
  bullet.simulate(6.0);
  ASSERT_TRUE(body->sleeping());
  const Eigen::Vector3d before = body->centerOfMass();
  for (btRigidBody* rigid : {bullet.bodies[0].get()}) bullet.world->removeRigidBody(rigid);
  body->wake();
  bullet.tick();
  EXPECT_NEAR(body->linearMomentum().y(), -9.81 / 60, 1e-5);
  EXPECT_LT(body->centerOfMass().y(), before.y());
}

TEST_F(SleepTest, aMovedPinWakesIt) {
  SoftBodySettings s = settingsAt({0, 4, 0});
  s.damping = 50;
  SoftBody* rope = *system.createBody(chainNetwork(2), s);
  rope->pin(0);
  bullet.simulate(15.0);
  ASSERT_TRUE(rope->sleeping());
  rope->movePin(0, btVector3(btScalar(0.2), 4, 0));
  bullet.simulate(0.2);
  EXPECT_FALSE(rope->sleeping());
  EXPECT_NEAR(rope->position(0).x(), 0.2, 1e-6);
}

/// A force acts in the ticks of its own step only, also if the body falls asleep in that step.
TEST_F(SleepTest, aForceOfTheStepInWhichItFallsAsleepDoesNotActLater) {
  if (!kSurface) GTEST_SKIP() << "Bullet clears the forces of points of the world";
  SoftBody* body = restingCube();
  int ticks = 0;
  for (; ticks < 2000 && !body->sleeping(); ++ticks) bullet.tick();
  SoftBody* pushed = restingCube(5.0);
  for (int i = 0; i < 2000 && !pushed->sleeping(); ++i) {
    if (i + 1 == ticks) pushed->surfaceObject()->applyCentralForce(vec(0, 100, 0));
    bullet.tick();
    if (i + 1 == ticks) {
      ASSERT_TRUE(pushed->sleeping());
    }
  }
  pushed->wake();
  bullet.tick();
  EXPECT_LT(pushed->velocity(0).norm(), 0.01);
}

TEST(Sleep, aPointLetGoMovesHoweverLongTheBodyWasCalm) {
  for (const double calm : {1.0, 1.9, 1.99, 2.0, 2.02, 5.0}) {
    SoftWorld bullet(0.0);
    SoftBodySettings s = testedSettings();
    s.damping = 20.0;
    SoftBody* body = bullet.addSoft(chainNetwork(2), s);
    body->pin(0);
    body->pin(2);
    body->movePin(2, vec(0, -1.2, 0));
    bullet.tick();
    bullet.simulate(calm);
    body->unpin(2);
    bullet.simulate(1.0);
    EXPECT_NEAR(body->position(2).y(), -1.0, 0.01) << "calm for " << calm << " s";
  }
}

TEST_F(SleepTest, aLongTickPutsNoFallingBodyToSleep) {
  for (const double deactivationTime : {2.0, 0.016}) {
    gDeactivationTime = static_cast<btScalar>(deactivationTime);
    SoftBody* body = restingCube(0, 200);
    bullet.tick(std::max(1.05 * deactivationTime, 1.0 / 60.0));
    bullet.simulate(0.2);
    EXPECT_FALSE(body->sleeping()) << deactivationTime;
    EXPECT_LT(body->linearMomentum().y(), -1.0) << deactivationTime;
    system.destroyBody(body);
  }
}

/// A cube asleep, into which a newcomer moves.
struct SleeperAndNewcomer {
  using Newcomer = std::function<void(SleeperAndNewcomer&)>;

  /// The twin's cube is woken before the newcomer touches it.
  SleeperAndNewcomer(bool isTwin, const Newcomer& add) : system(*bullet.world) {
    bullet.addBoxFloor();
    sleeper = addCube({0, 0.52, 0});
    for (int i = 0; i < 600 && !sleeper->sleeping(); ++i) bullet.tick();
    EXPECT_TRUE(sleeper->sleeping());
    add(*this);
    if (isTwin) sleeper->wake();
  }

  SoftBody* addCube(const Eigen::Vector3d& position, const Eigen::Vector3d& velocity = {0, 0, 0}) {
    SoftBodySettings s = settingsAt(position);
    s.linearVelocity = velocity;
    return *system.createBody(closedCubeNetwork(), s);
  }

  btRigidBody* addBall(double mass, const btVector3& position, const btVector3& velocity) {
    btRigidBody* ball = bullet.add(std::make_unique<btSphereShape>(btScalar(0.2)), mass, position);
    ball->setLinearVelocity(velocity);
    return ball;
  }

  void tick() {
    if (mover) {
      btTransform pose = mover->getWorldTransform();
      pose.setOrigin(pose.getOrigin() + moverVelocity / btScalar(60));
      mover->setWorldTransform(pose);
    }
    bullet.tick();
  }

  BulletWorld bullet;
  SoftBodySystem system;
  SoftBody* sleeper;
  btRigidBody* mover = nullptr;  // kinematic
  btVector3 moverVelocity;
};

SleeperAndNewcomer::Newcomer kinematicBall(const btVector3& position, const btVector3& velocity) {
  return [=](SleeperAndNewcomer& scene) {
    scene.mover = scene.addBall(0, position, vec(0, 0, 0));
    scene.mover->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    scene.moverVelocity = velocity;
  };
}

SleeperAndNewcomer::Newcomer fallingBall(const btVector3& position, const btVector3& velocity) {
  return [=](SleeperAndNewcomer& scene) { scene.addBall(1, position, velocity); };
}

TEST(Sleep, newcomersMeetASleeperAsTheyMeetABodyAwake) {
  std::vector<SleeperAndNewcomer::Newcomer> newcomers = {kinematicBall(vec(-0.8, 0.9, 0.45), vec(3, 0, 0)),
                                                         kinematicBall(vec(-0.8, 0.9, 0.45), vec(0.5, 0, 0))};
  if (kSurface) {
    newcomers.push_back(fallingBall(vec(0, 1.25, 0), vec(0, -9, 0)));
    newcomers.push_back(fallingBall(vec(0, 1.25, 0), vec(0, -0.1, 0)));
    newcomers.emplace_back([](SleeperAndNewcomer& scene) { scene.addCube({0.2, 1.56, 0.1}, {0, -6, 0}); });
  }
  for (std::size_t i = 0; i < newcomers.size(); ++i) {
    SleeperAndNewcomer scene(false, newcomers[i]), twin(true, newcomers[i]);
    const Eigen::Vector3d before = scene.sleeper->centerOfMass();
    for (int tick = 0; tick < 30; ++tick) {
      scene.tick(), twin.tick();
      for (std::uint32_t p = 0; p < 8; ++p) {
        const double apart = (scene.sleeper->position(p) - twin.sleeper->position(p)).norm();
        ASSERT_LT(apart, 1e-3) << "newcomer " << i << ", tick " << tick;
      }
    }
    EXPECT_GT((scene.sleeper->centerOfMass() - before).norm(), 1e-4) << "newcomer " << i;
  }
}

/// A box on a soft cube on another soft cube, all asleep.
struct SleepingStack {
  SleepingStack() : system(*bullet.world) {
    bullet.addBoxFloor();
    SoftBodySettings s = settingsAt({0, 0.6, 0});
    s.damping = 5;
    lower = *system.createBody(closedCubeNetwork(), s);
    s.position = {0, 1.7, 0};
    upper = *system.createBody(closedCubeNetwork(), s);
    box = bullet.addBox(vec(0.6, 0.2, 0.6), 0.2, vec(0, 2.6, 0));
    for (int i = 0; i < 1200 && !isAsleep(); ++i) bullet.tick();
    EXPECT_TRUE(isAsleep());
  }
  bool isAsleep() const { return lower->sleeping() && upper->sleeping() && !box->isActive(); }
  double heightOfBox() const { return heightOf(*box); }

  BulletWorld bullet;
  SoftBodySystem system;
  SoftBody *lower, *upper;
  btRigidBody* box;
};

/// In free fall without gravity nothing moves at all: 0 m/s is not below 0 m/s.
TEST(Sleep, neverWithASleepingSpeedOfZero) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.sleepingSpeed = 0.0;
  const SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  bullet.simulate(5.0);
  EXPECT_FALSE(body->sleeping());
}

/// Returns whether two points on a spring, which swing with a period of 4 s and pass each other at most at
/// this speed (m/s), fall asleep.
bool sleepsWhileItSwings(double speed) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.totalMass = 1.0;
  setSprings(s, 0.617, 0.0);
  s.flow.drag = s.flow.linearDrag = 0.0;
  SoftBody* body = bullet.addSoft(pairNetwork(), s);
  const double impulse = 0.5 * speed;  // N s
  body->point(0)->applyCentralImpulse(vec(impulse, 0, 0));
  body->point(1)->applyCentralImpulse(vec(-impulse, 0, 0));
  for (int i = 0; i < 1200 && !body->sleeping(); ++i) bullet.tick();
  return body->sleeping();
}

/// A pile may sleep although a point slips now and then: a tick above the sleeping speed subtracts six ticks.
/// The swing is above that speed 6 % of the time, and 54 %.
TEST(Sleep, comesInSpiteOfFewFastTicks) {
  EXPECT_TRUE(sleepsWhileItSwings(0.1005));
  EXPECT_FALSE(sleepsWhileItSwings(0.15));
}

/// By sleep(), and by Bullet's idiom for levels that start asleep: it hangs in the air until something hits
/// it.
TEST(Sleep, onRequestUntilTouched) {
  for (const bool byBullet : {false, true}) {
    SoftWorld bullet;
    SoftBody* body = bullet.addSoft(cubeNetwork(), settingsAt({0, 3, 0}));
    if (byBullet && body->surfaceObject())
      body->surfaceObject()->setActivationState(ISLAND_SLEEPING);
    else
      body->sleep();
    bullet.simulate(1.0);
    EXPECT_TRUE(body->sleeping()) << byBullet;
    EXPECT_NEAR(body->centerOfMass().y(), 3.0, 1e-6) << byBullet;
    bullet.addBox(vec(0.6, 0.1, 0.6), 0.5, vec(0, 4.5, 0));
    bullet.simulate(1.0);
    EXPECT_FALSE(body->sleeping()) << byBullet;
    EXPECT_LT(body->centerOfMass().y(), 2.9) << byBullet;
  }
}

TEST_F(SleepTest, whatLiesOnABodyFallsWhenThatShrinksOrIsRestoredElsewhere) {
  if (!kSurface) GTEST_SKIP() << "points of cubes of different sizes do not meet";
  SoftBody *lower = restingCube(), *upper = restingCube(0, 1.55);
  const std::vector<std::uint8_t> elsewhere = [&] {
    EXPECT_TRUE(lower->setTransform(btTransform(btQuaternion::getIdentity(), vec(5, 0.52, 0))));
    std::vector<std::uint8_t> state = lower->saveState();
    EXPECT_TRUE(lower->setTransform(btTransform(btQuaternion::getIdentity(), vec(0, 0.52, 0))));
    return state;
  }();
  bullet.simulate(8.0);
  ASSERT_TRUE(upper->sleeping());
  SoftBodySettings s = lower->settings();
  s.scale *= 0.8;
  ASSERT_TRUE(lower->change(s));
  bullet.simulate(8.0);
  EXPECT_NEAR(upper->centerOfMass().y(), 1.3, 0.05) << "it stands on 0.8 m";
  ASSERT_TRUE(upper->sleeping());
  ASSERT_TRUE(lower->restoreState(elsewhere));
  bullet.simulate(3.0);
  EXPECT_NEAR(upper->centerOfMass().y(), 0.5, 0.05);
}

/// A world that is restored or loaded sleeps as it did, whatever the settings of its bodies were in between.
TEST_F(SleepTest, staysWhenAWorldIsRestoredOrLoaded) {
  SoftBody *lower = restingCube(), *upper = restingCube(0, 1.55);
  bullet.simulate(8.0);
  ASSERT_TRUE(lower->sleeping() && upper->sleeping());
  const std::vector<std::uint8_t> state = system.saveState(), bodies = system.saveBodies();
  SoftBodySettings s = upper->settings();
  s.scale *= 0.9;
  ASSERT_TRUE(upper->change(s));
  bullet.simulate(1.0);
  ASSERT_TRUE(system.restoreState(state));
  EXPECT_TRUE(lower->sleeping() && upper->sleeping());
  bullet.tick();
  EXPECT_TRUE(lower->sleeping() && upper->sleeping());
  BulletWorld other;
  other.addBoxFloor();
  SoftBodySystem loaded(*other.world);
  ASSERT_TRUE(loaded.loadBodies(bodies));
  other.tick();
  for (std::size_t i = 0; i < loaded.bodyCount(); ++i) EXPECT_TRUE(loaded.body(i)->sleeping()) << i;
}

/// A cube hangs from a kinematic body that it cannot touch. When that moves, the cube follows.
TEST(Sleep, aMovedKinematicHolderWakesIt) {
  for (const bool bySpring : {false, true}) {
    SoftWorld bullet;
    btRigidBody* holder = bullet.addBox(vec(0.1, 0.1, 0.1), 0, vec(0.5, 2.0, 0.5));
    holder->setCollisionFlags(holder->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT |
                              btCollisionObject::CF_NO_CONTACT_RESPONSE);
    SoftBodySettings s = testedSettings();
    s.damping = 20.0;
    s.flow.drag = 1.0;
    SoftBody* body = bullet.addSoft(cubeNetwork(), s);
    if (bySpring)
      ASSERT_TRUE(
          bullet.system.addSpring({holder, btVector3(0, 0, 0)}, {body->point(0), btVector3(0, 0, 0)}));
    else
      ASSERT_TRUE(bullet.system.attach(body, 0, *holder));
    body->sleep();
    bullet.simulate(0.5);
    ASSERT_TRUE(body->sleeping()) << bySpring;
    btTransform there = holder->getWorldTransform();
    there.setOrigin(there.getOrigin() + vec(0.2, 0, 0));
    holder->setWorldTransform(there);
    bullet.simulate(0.2);
    EXPECT_FALSE(body->sleeping()) << bySpring;
  }
}

/// A tick's displacements are compared with the sleeping speed over the same tick, not over the next one.
TEST_F(SleepTest, soonWithVaryingTicks) {
  SoftBody *lower = restingCube(), *upper = restingCube(0, 1.55);
  double time = 0.0;
  for (int i = 0; time < 8.0 && !(lower->sleeping() && upper->sleeping()); ++i) {
    const double tick = i % 3 == 0 ? 1.0 / 20 : 1.0 / 200;
    bullet.tick(tick);
    time += tick;
  }
  EXPECT_LT(time, 8.0);
}

/// A soft ball in the groove of two rigid balls that stand between walls. Its faces roll on them.
TEST(Sleep, ofASoftBallOnRigidBalls) {
  if (!kSurface) GTEST_SKIP() << "only surfaces have faces";
  for (const double gap : {0.27, 0.29, 0.33}) {
    SoftWorld bullet;
    bullet.addBoxFloor();
    const double radius = 0.235;
    const double x = radius + 0.5 * gap;
    for (const int side : {-1, 1}) {
      bullet.addBox(vec(0.5, 1, 2), 0, vec(side * (x + radius + 0.5), 1, 0));
      bullet.addBox(vec(2, 1, 0.5), 0, vec(0, 1, side * (radius + 0.5)));
      bullet.add(std::make_unique<btSphereShape>(btScalar(radius)), 0.6, vec(side * x, radius, 0));
    }
    SoftBodySettings s = settingsAt({0.01, 0.75, 0.02});
    s.scale.setConstant(0.461 / 2);
    s.totalMass = s.damping = 0.2;
    s.extensionStiffness = s.compressionStiffness = 200.0;
    const SoftBody* body = bullet.addSoft(bracedNetwork(small_meshes::icosphere(1)), s);
    bullet.simulate(10.0);
    EXPECT_TRUE(body->sleeping()) << gap;
    for (const SoftContact& c : body->contacts()) EXPECT_GT(c.distance, -1e-3) << gap;
  }
}

TEST(Sleep, whatRestedOnADestroyedBodyFalls) {
  SleepingStack stack;
  stack.system.destroyBody(stack.lower);
  stack.bullet.simulate(2.0);
  EXPECT_LT(stack.upper->centerOfMass().y(), 0.7);
  EXPECT_LT(stack.heightOfBox(), 1.6);
  stack.bullet.simulate(6.0);
  stack.system.destroyBody(stack.upper);
  stack.bullet.simulate(2.0);
  EXPECT_LT(stack.heightOfBox(), 0.5);
}

TEST(Sleep, whatRestedOnABodyFallsWhenItIsTakenAway) {
  const btTransform away(btQuaternion::getIdentity(), vec(5, 0.52, 0));
  std::vector<std::function<void(SoftBody&)>> ways = {
      [&](SoftBody& body) { EXPECT_TRUE(body.setTransform(away)); },
      [&](SoftBody& body) { EXPECT_TRUE(body.reset(away)); }};
  if (kSurface) ways.emplace_back([&](SoftBody& body) { body.surfaceObject()->setWorldTransform(away); });
  for (const auto& takeAway : ways) {
    SleepingStack stack;
    takeAway(*stack.upper);
    stack.bullet.simulate(2.0);
    EXPECT_NEAR(stack.upper->centerOfMass().x(), 5.0, 0.1);
    EXPECT_LT(stack.heightOfBox(), 1.6) << "way " << &takeAway - ways.data();
  }
}

/// However long an awake hand has kept it awake.
TEST(Sleep, whatAnAwakeHandHoldsFallsWhenTheHandGoes) {
  for (const bool attached : {false, true})
    for (const double tick : {1.0 / 60, 1.0 / 240}) {
      SoftWorld bullet;
      btRigidBody* palm = bullet.addBox(vec(1, 0.1, 1), 0, vec(0, 0.9, 0));
      palm->setCollisionFlags(palm->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
      palm->setActivationState(DISABLE_DEACTIVATION);
      SoftBody* body = bullet.addSoft(cubeNetwork(), settingsAt({0, 1.52, 0}));
      if (attached) {
        ASSERT_TRUE(bullet.system.attach(body, 0, *palm));
      }
      bullet.simulate(5.0, tick);
      ASSERT_FALSE(body->sleeping());
      const double before = body->centerOfMass().y();
      bullet.world->removeRigidBody(palm);
      bullet.simulate(0.5, tick);
      EXPECT_LT(body->centerOfMass().y(), before - 1.0) << attached << ", " << tick;
    }
}

/// A corner of one cloth that lies on the edge of the other swung for ever: contacts had the lever arms and
/// the normals of the start of each tick.
TEST(Sleep, ofTwoClothsThatLieOnEachOther) {
  SoftWorld bullet(-10.0);
  btStaticPlaneShape plane(vec(0, 1, 0), 0);
  btRigidBody floor(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane));
  bullet.world->addRigidBody(&floor);
  const SharedNetwork network = squareCloth(5, 0.3);
  SoftBodySettings s = settingsAt({-0.091140307819536109, 0.1, 0.11562918801355604});
  s.flow = SoftBodySettings().flow;
  s.totalMass = 0.1;
  setSprings(s, 200.0, 0.2);
  s.pointRadius = 0.008;
  s.rotation = Eigen::Quaterniond(-0.74870586244885362, -0.5279451425161007, -0.12342563614144571,
                                  0.38141784223008185);
  const SoftBody* lower = bullet.addSoft(network, s);
  s.position = {0.036289154394198747, 0.3, -0.063150047877873317};
  s.rotation = Eigen::Quaterniond(-0.95230473583818198, 0.017405946971924213, 0.28349181649449923,
                                  -0.11155766710912444);
  const SoftBody* upper = bullet.addSoft(network, s);
  bullet.simulate(12.0);
  EXPECT_TRUE(lower->sleeping() && upper->sleeping());
  bullet.world->removeRigidBody(&floor);
}

}  // namespace
}  // namespace limber::test
