// SPDX-License-Identifier: Zlib
// Changes of bodies and world by the application between ticks take effect. The world's substeps and time
// steps do not change the results.
#include "support/soft_world.h"

namespace limber::test {
namespace {

struct Sim : SoftWorld {
  explicit Sim(double gravity = -9.81, const SoftBodySettings& s = testedSettings())
      : SoftWorld(gravity), body(addSoft(cubeNetwork(), s)) {}
  SoftBody* body;
};

TEST(WorldSubsteps, oneStepOfTwoSubstepsEqualsTwoStepsOfOne) {
  Sim one, two;
  one.body->point(0)->applyCentralImpulse(btVector3(1, 0, 0));
  two.body->point(0)->applyCentralImpulse(btVector3(1, 0, 0));
  const btScalar tick = btScalar(kTick);
  for (int i = 0; i < 30; ++i) {
    one.world->stepSimulation(2 * tick, 2, tick);
    two.world->stepSimulation(tick, 1, tick);
    two.world->stepSimulation(tick, 1, tick);
    ASSERT_EQ(one.body->stateHash(), two.body->stateHash()) << "frame " << i;
  }
}

TEST(WorldSubsteps, aForceActsOverTheWholeStepWhateverItsSubsteps) {
  for (int substeps : {1, 2, 4}) {
    Sim sim(0.0);
    const btScalar tick = btScalar(kTick / substeps);
    for (std::uint32_t i = 0; i < 8; ++i)
      sim.body->point(i)->applyCentralForce(btVector3(btScalar(0.3), 0, 0));
    sim.world->stepSimulation(btScalar(kTick) * btScalar(1.0001), substeps, tick);
    EXPECT_NEAR(sim.body->linearMomentum().x(), 8 * 0.3 * kTick, 1e-6) << substeps;
  }
}

TEST(WorldSubsteps, variableTimeStepsFallTheSame) {
  Sim sim;
  double time = 0;
  for (int i = 0; i < 120; ++i) {
    const double dt = 0.004 + 0.00021 * (i % 37);
    sim.tick(dt);
    time += double(btScalar(dt));
  }
  const double exact = -0.5 * double(btScalar(9.81)) * time * time;
  EXPECT_NEAR(sim.body->centerOfMass().y(), exact, 1e-6 * std::abs(exact));
}

TEST(WorldSubsteps, aStepWithoutATickLosesNothing) {
  Sim sim;
  const auto before = sim.body->stateHash();
  sim.world->stepSimulation(btScalar(0.001), 1, btScalar(kTick));
  EXPECT_EQ(sim.body->stateHash(), before);
  sim.world->stepSimulation(btScalar(0), 0);
  EXPECT_EQ(sim.body->stateHash(), before);
}

TEST(UserChanges, impulseOnOnePoint) {
  Sim sim(0.0);
  sim.body->point(5)->applyCentralImpulse(btVector3(0, btScalar(0.5), 0));
  EXPECT_NEAR(sim.body->velocity(5).y(), 0.5 / 0.125, 1e-6) << "seen at once";
  sim.simulate(0.5);
  EXPECT_NEAR(sim.body->linearMomentum().y(), 0.5, 1e-6);
}

TEST(UserChanges, velocityIsSet) {
  Sim sim(0.0);
  sim.tick();
  for (std::uint32_t i = 0; i < 8; ++i) sim.body->point(i)->setLinearVelocity(btVector3(2, 0, 0));
  sim.simulate(1.0);
  EXPECT_NEAR(sim.body->linearMomentum().x(), 2.0, 1e-6);
  EXPECT_NEAR(sim.body->centerOfMass().x(), 2.0, 1e-5);
}

TEST(UserChanges, teleportMovesTheBodyWithoutAKick) {
  Sim sim(0.0);
  sim.simulate(0.1);
  for (std::uint32_t i = 0; i < 8; ++i) sim.body->point(i)->translate(btVector3(100, -3, 7));
  sim.simulate(0.5);
  EXPECT_LT((sim.body->centerOfMass() - Eigen::Vector3d(100, -3, 7)).norm(), 1e-5);
  EXPECT_LT(sim.body->linearMomentum().norm(), 1e-4) << "floats at 100 m are 8e-6 m apart: springs feel that";
}

TEST(UserChanges, onePointIsPulledAwayAndComesBack) {
  Sim sim(0.0);
  sim.body->point(7)->translate(vec(0.2, 0.1, 0));
  EXPECT_GT(sim.body->elasticEnergy(), 1.0);
  sim.simulate(20.0);
  EXPECT_LT(sim.body->elasticEnergy(), 1e-6);
}

TEST(UserChanges, gravityIsChangedWhileRunning) {
  Sim sim;
  sim.simulate(0.5);
  const Eigen::Vector3d v = sim.body->linearMomentum();
  sim.world->setGravity(btVector3(3, 0, 0));
  sim.simulate(1.0);
  EXPECT_NEAR(sim.body->linearMomentum().x() - v.x(), 3.0, 1e-5);
  EXPECT_NEAR(sim.body->linearMomentum().y(), v.y(), 1e-5);
}

TEST(UserChanges, gravityOfOnePointIsItsOwn) {
  Sim sim;
  for (std::uint32_t i = 0; i < 8; ++i) {
    sim.body->point(i)->setFlags(sim.body->point(i)->getFlags() | BT_DISABLE_WORLD_GRAVITY);
    sim.body->point(i)->setGravity(btVector3(0, 0, 0));
  }
  sim.simulate(1.0);
  EXPECT_LT(sim.body->centerOfMass().norm(), 1e-6);
}

TEST(UserChanges, linearFactorKeepsAPointInItsPlane) {
  Sim sim;
  for (std::uint32_t i = 0; i < 8; ++i) sim.body->point(i)->setLinearFactor(btVector3(1, 1, 0));
  sim.body->point(0)->applyCentralImpulse(vec(0.3, 0, 0));
  const double z = sim.body->position(0).z();
  sim.simulate(1.0);
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_NEAR(std::abs(sim.body->position(i).z()), std::abs(z), 1e-12);
}

TEST(UserChanges, massOfAPointIsChanged) {
  Sim sim(0.0);
  sim.body->point(0)->setMassProps(btScalar(1.0), btVector3(0, 0, 0));
  sim.tick();
  EXPECT_NEAR(sim.body->totalMass(), 7 * 0.125 + 1.0, 1e-6);
}

TEST(UserChanges, bulletsLinearDampingActs) {
  Sim sim(0.0);
  for (std::uint32_t i = 0; i < 8; ++i) {
    sim.body->point(i)->setDamping(btScalar(0.5), 0);
    sim.body->point(i)->setLinearVelocity(btVector3(1, 0, 0));
  }
  sim.simulate(1.0);
  EXPECT_NEAR(sim.body->linearMomentum().x(), 0.5, 1e-3) << "v(t) = v (1 - d)^t";
}

TEST(UserChanges, userPointersAndIndicesAreTheUsers) {
  Sim sim;
  for (std::uint32_t i = 0; i < 8; ++i) {
    EXPECT_EQ(sim.body->point(i)->getUserPointer(), nullptr);
    EXPECT_EQ(sim.body->point(i)->getUserIndex(), -1);
  }
  int mine = 0;
  sim.body->point(3)->setUserPointer(&mine);
  sim.body->point(3)->setUserIndex(42);
  sim.simulate(0.1);
  EXPECT_EQ(sim.body->point(3)->getUserPointer(), &mine);
  EXPECT_EQ(sim.body->point(3)->getUserIndex(), 42);
}

TEST(UserChanges, aRayFindsThePointAndThePointItsBody) {
  if (kSurface) GTEST_SKIP() << "a ray finds the surface, see surface_query_test";
  SoftBodySettings s = testedSettings();
  s.pointRadius = 0.05;
  Sim sim(0.0, s);
  sim.tick();
  const btVector3 target = sim.body->point(6)->getWorldTransform().getOrigin();
  btCollisionWorld::ClosestRayResultCallback ray(target + btVector3(0, 5, 0), target);
  sim.world->rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
  ASSERT_TRUE(ray.hasHit());
  const PointReference found = findPoint(ray.m_collisionObject);
  EXPECT_EQ(found.body, sim.body);
  EXPECT_EQ(found.index, 6u);
  EXPECT_EQ(findPoint(nullptr).body, nullptr);
  btRigidBody* box = sim.addBox(btVector3(1, 1, 1), 1, btVector3(9, 9, 9));
  EXPECT_EQ(findPoint(box).body, nullptr);
}

TEST(UserChanges, pointsDoNotSpin) {
  Sim sim;
  sim.addBoxFloor();
  sim.body->point(0)->applyTorqueImpulse(btVector3(5, 5, 5));
  sim.simulate(2.0);
  for (std::uint32_t i = 0; i < 8; ++i) {
    EXPECT_EQ(sim.body->point(i)->getAngularVelocity(), btVector3(0, 0, 0));
    EXPECT_EQ(sim.body->point(i)->getWorldTransform().getBasis(), btMatrix3x3::getIdentity());
  }
}

TEST(UserChanges, aMousePickersConstraintComesAndGoes) {
  if (kSurface) GTEST_SKIP() << "Bullet's constraints hold bodies of the world only";
  // The picker adds a point-to-point constraint, which disables collisions with its anchor and keeps the
  // point awake. It later removes both. Afterwards points of one body must still not collide.
  SoftBodySettings s = testedSettings();
  s.pointRadius = 0.4;
  Sim sim(0.0, s);
  btRigidBody* point = sim.body->point(0);
  btRigidBody* anchor = sim.addBox(btVector3(1, 1, 1), 0, btVector3(5, 0, 0));
  btPoint2PointConstraint pick(*point, *anchor, btVector3(0, 0, 0), btVector3(-6, 0, 0));
  sim.world->addConstraint(&pick, true);
  point->setActivationState(DISABLE_DEACTIVATION);
  sim.simulate(1.0);
  sim.world->removeConstraint(&pick);
  point->forceActivationState(ACTIVE_TAG);
  sim.simulate(15.0);
  EXPECT_LT(sim.body->elasticEnergy(), 1e-6) << "overlapping points of one body would push each other apart";
}

/// Actions that were added before the soft bodies run before the end of their tick.
TEST(UserChanges, anActionsImpulseOnAPointCounts) {
  for (const bool early : {true, false}) {
    BulletWorld bullet(0);
    ActionOnce push;
    if (early) bullet.world->addAction(&push);
    {
      SoftBodySystem system(*bullet.world);
      SoftBody* body = *system.createBody(cubeNetwork(), testedSettings());
      if (!early) bullet.world->addAction(&push);
      push.act = [&] { body->point(0)->applyCentralImpulse(vec(1, 0, 0)); };
      bullet.tick();
      bullet.tick();
      EXPECT_NEAR(body->linearMomentum().x(), 1.0, 1e-6) << early;
    }
    bullet.world->removeAction(&push);
  }
}

/// A cube that flies at 0.3 m/s, and that an early action changes once.
struct ChangedCube {
  BulletWorld bullet{0};
  ActionOnce action;
  SoftBodySystem system{(bullet.world->addAction(&action), *bullet.world)};
  SoftBody* body;

  explicit ChangedCube(SoftBodySettings s = testedSettings()) {
    s.linearVelocity = {0.3, 0, 0};
    body = *system.createBody(closedCubeNetwork(), s);
    bullet.tick();
  }
  ~ChangedCube() { bullet.world->removeAction(&action); }

  template <class Change>
  void change(Change change) {
    action.act = [=] { ASSERT_TRUE(change(*body)); };
    bullet.tick();
    bullet.tick();
  }
};

TEST(UserChanges, earlyActionsPushABodyOnce) {
  ChangedCube pushed, thrown, turned;
  const Eigen::Vector3d start = pushed.body->linearMomentum();
  pushed.change([](SoftBody& body) { return body.applyImpulse(vec(0, 1, 0)); });
  EXPECT_NEAR((pushed.body->linearMomentum() - start - Eigen::Vector3d(0, 1, 0)).norm(), 0.0, 1e-5);

  thrown.change([](SoftBody& body) { return body.setVelocity(vec(0, 1, 0)); });
  const Eigen::Vector3d velocity = thrown.body->linearMomentum() * (0.3 / start.x());
  EXPECT_NEAR((velocity - Eigen::Vector3d(0, 1, 0)).norm(), 0.0, 1e-5);

  turned.change([](SoftBody& body) { return body.applyTorqueImpulse(vec(0, 0.1, 0)); });
  const Eigen::Vector3d spin =
      turned.body->angularMomentum() - turned.body->centerOfMass().cross(turned.body->linearMomentum());
  EXPECT_NEAR((spin - Eigen::Vector3d(0, 0.1, 0)).norm(), 0.0, 1e-5);
}

TEST(UserChanges, earlyActionsPlaceABodyAtRest) {
  ChangedCube cube;
  cube.change(
      [](SoftBody& body) { return body.reset(btTransform(btQuaternion::getIdentity(), vec(0, 5, 0))); });
  EXPECT_NEAR((cube.body->centerOfMass() - Eigen::Vector3d(0, 5, 0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR(cube.body->kineticEnergy(), 0.0, 1e-10);
}

/// A body that grows into the floor is pushed out no faster than its settings let it recover.
TEST(UserChanges, earlyActionsEnlargeABodyOnTheFloorWithoutThrowingIt) {
  ChangedCube cube;
  cube.bullet.world->setGravity(vec(0, -9.81, 0));
  cube.bullet.addBoxFloor();
  ASSERT_TRUE(cube.body->reset(btTransform(btQuaternion::getIdentity(), vec(0, 0.55, 0))));
  for (int i = 0; i < 60; ++i) cube.bullet.tick();
  cube.change([](SoftBody& body) {
    SoftBodySettings larger = body.settings();
    larger.scale *= 1.3;
    return body.change(larger);
  });
  for (int i = 0; i < 60; ++i) {
    cube.bullet.tick();
    // 0.65 m at rest; from the 0.15 m that it is deep, an elastic bounce would reach as far above that
    ASSERT_LT(cube.body->centerOfMass().y(), 0.85) << i;
  }
}

/// Reading must not change what a rotation of the whole body does to its motion: the body keeps its momentum.
TEST(UserChanges, readingARotatedBodyChangesNothing) {
  if (!kSurface) GTEST_SKIP() << "point masses of the world have no common object";
  for (const bool look : {false, true}) {
    SoftWorld bullet(0);
    SoftBody* body = bullet.addSoft(closedCubeNetwork());
    body->point(0);
    bullet.tick();
    for (std::uint32_t i = 0; i < body->pointCount(); ++i) body->point(i)->setLinearVelocity(vec(5, 0, 0));
    btRigidBody& object = *body->surfaceObject();
    btTransform pose = object.getWorldTransform();
    pose.setRotation(btQuaternion(vec(0, 1, 0), SIMD_HALF_PI));
    object.setWorldTransform(pose);
    if (look) body->position(0);
    bullet.tick();
    const Eigen::Vector3d momentum = body->linearMomentum();
    EXPECT_NEAR((momentum - Eigen::Vector3d(5, 0, 0)).norm(), 0.0, 1e-5) << look;
  }
}

TEST(UserChanges, theBodiesDrawFlagAndMotionStatesStayOut) {
  Sim sim;
  for (std::uint32_t i = 0; i < 8; ++i) {
    EXPECT_EQ(sim.body->point(i)->getMotionState(), nullptr);
    EXPECT_TRUE(sim.body->point(i)->getCollisionFlags() & btCollisionObject::CF_DISABLE_VISUALIZE_OBJECT);
  }
}

}  // namespace
}  // namespace limber::test
