// SPDX-License-Identifier: Zlib
// Bodies that are one object in the world move, rest and sleep like those whose points are in the world.
#include "support/allocation_counter.h"
#include "support/soft_world.h"

#include <cmath>
#include <functional>

namespace limber::test {
namespace {

// --- comparison with points --------------------------------------------------------------------------------

using AddFloor = void (*)(BulletWorld&);

double restHeightWith(AddFloor addFloor, Collision collision) {
  SoftWorld bullet;
  addFloor(bullet);
  SoftBodySettings s;
  s.collision = collision;
  s.position = {0.1, 0.52, 0.05};
  s.friction = 0;
  s.damping = 0.2 * std::sqrt(1000 * 0.125);
  s.sleepingSpeed = 0;
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  bullet.simulate(8.0);
  return body->centerOfMass().y();
}

TEST(SurfaceLife, restsAtTheHeightOfPoints) {
  // equal contacts on equal planes; Bullet's rounding of the box's and the hull's planes varies between ticks
  const std::pair<AddFloor, double> floors[] = {{[](BulletWorld& b) { b.addPlaneFloor(); }, 1e-9},
                                                {[](BulletWorld& b) { b.addBoxFloor(); }, 1e-7},
                                                {[](BulletWorld& b) { b.addHullFloor(); }, 1e-7},
                                                {[](BulletWorld& b) { b.addTriangleFloor(); }, 1e-7}};
  for (const auto& [addFloor, tolerance] : floors)
    EXPECT_NEAR(restHeightWith(addFloor, Collision::Surface), restHeightWith(addFloor, Collision::Points),
                tolerance);
}

TEST(SurfaceLife, aTumbleIsTheSameWhetherTheUserHoldsThePointsOrNot) {
  const auto hash = [](bool exposed) {
    SoftWorld bullet;
    bullet.addPlaneFloor();
    SoftBodySettings s = settingsAt({0, 1.5, 0});
    s.angularVelocity = {1, 2, 3};
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    if (exposed) (void)body->point(0);
    bullet.simulate(3.0);
    return body->stateHash();
  };
  // with masses of 1/8 kg, gravity in Bullet's float forces has no rounding error
  EXPECT_EQ(hash(false), hash(true));
}

// --- forces ------------------------------------------------------------------------------------------------

struct Pushed {
  explicit Pushed(Collision collision) : system(*bullet.world) {
    SoftBodySettings s;
    s.collision = collision;
    body = *system.createBody(cubeNetwork(), s);
  }
  void push(double newtons) {
    for (std::uint32_t i = 0; i < 8; ++i) body->point(i)->applyCentralForce(vec(newtons / 8, 0, 0));
  }
  double momentum() const { return body->linearMomentum().x(); }

  BulletWorld bullet{0.0};
  SoftBodySystem system;
  SoftBody* body;
};

TEST(SurfaceForces, actAsLongAsThoseOnBodiesOfTheWorld) {
  // steps of none, one and several ticks, with and without a push before each
  const int ticks[] = {1, 3, 0, 2, 0, 0, 1, 4, 1};
  Pushed points(Collision::Points), surface(Collision::Surface);
  for (std::size_t i = 0; i < std::size(ticks); ++i) {
    for (Pushed* pushed : {&points, &surface}) {
      if (i % 3 != 1) pushed->push(1.0 + static_cast<double>(i));
      // 0.4 ticks more or less than a whole number; the next step uses the remainder
      const double length = (ticks[i] + (i % 2 ? -0.4 : 0.4)) * kTick;
      if (ticks[i] > 0)
        pushed->bullet.world->stepSimulation(static_cast<btScalar>(length), 10, btScalar(kTick));
      else
        pushed->bullet.world->stepSimulation(btScalar(0), 10, btScalar(kTick));
    }
    // in one of the two, the forces pass through Bullet's floats
    EXPECT_NEAR(surface.momentum(), points.momentum(), 1e-6) << "step " << i;
  }
  EXPECT_GT(surface.momentum(), 0.1);
}

TEST(SurfaceForces, oneForceForAllTicksOfAStep) {
  for (const int ticks : {1, 2, 5}) {
    Pushed pushed(Collision::Surface);
    pushed.push(2.0);
    pushed.bullet.world->stepSimulation(static_cast<btScalar>((ticks + 0.2) * kTick), 10, btScalar(kTick));
    EXPECT_NEAR(pushed.momentum(), 2.0 * ticks * kTick, 1e-6);
    pushed.bullet.world->stepSimulation(btScalar(kTick), 10, btScalar(kTick));
    EXPECT_NEAR(pushed.momentum(), 2.0 * ticks * kTick, 1e-6) << "and gone in the next";
  }
}

TEST(SurfaceForces, nothingIsInTheWorldBesidesTheSurfaceUntilSomebodyHasAPoint) {
  SoftWorld bullet;
  SoftBody* body = bullet.addSoft(cubeNetwork());
  bullet.tick();
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 1);
  (void)body->point(0);
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 2);
  bullet.system.destroyBody(body);
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 0);
}

// --- sleep -------------------------------------------------------------------------------------------------

struct SurfaceSleep : testing::Test {
  SurfaceSleep() : system(*bullet.world) {
    floor = bullet.addBoxFloor();
    body = *system.createBody(cubeNetwork(), settingsAt({0, 0.52, 0}));
  }
  void sleep() {
    for (int i = 0; i < 1200 && !body->sleeping(); ++i) bullet.tick();
    ASSERT_TRUE(body->sleeping());
    bullet.tick();
    ASSERT_EQ(body->surfaceObject()->getActivationState(), ISLAND_SLEEPING);
  }
  BulletWorld bullet;
  SoftBodySystem system;
  btRigidBody* floor;
  SoftBody* body;
};

TEST_F(SurfaceSleep, wakesByTheObjectByACallAndByAChangedPoint) {
  const std::function<void()> wakers[] = {[&] { body->surfaceObject()->activate(); }, [&] { body->wake(); },
                                          [&] { body->point(2)->activate(); },
                                          [&] { body->point(2)->applyCentralImpulse(vec(0, 0.1, 0)); },
                                          [&] { body->point(2)->translate(vec(0.05, 0, 0)); }};
  for (std::size_t i = 0; i < std::size(wakers); ++i) {
    sleep();
    wakers[i]();
    bullet.tick();
    EXPECT_FALSE(body->sleeping()) << i;
    EXPECT_EQ(body->surfaceObject()->getActivationState(), ACTIVE_TAG) << i;
  }
}

TEST_F(SurfaceSleep, wokenItStandsOnItsFloorFromTheFirstTick) {
  const std::function<void()> wakers[] = {[&] { body->surfaceObject()->activate(); }, [&] { body->wake(); }};
  for (const auto& waker : wakers) {
    sleep();
    const double before = body->position(0).y();
    waker();
    bullet.tick();
    ASSERT_FALSE(body->sleeping());
    // without the floor it falls g h^2 / 2 = 1.4 mm
    EXPECT_NEAR(body->position(0).y(), before, 1e-5);
  }
}

TEST_F(SurfaceSleep, theUsersDisableDeactivationKeepsItAwake) {
  body->surfaceObject()->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(8.0);
  EXPECT_FALSE(body->sleeping());
  EXPECT_EQ(body->surfaceObject()->getActivationState(), DISABLE_DEACTIVATION);
  body->surfaceObject()->forceActivationState(ACTIVE_TAG);
  sleep();
}

TEST_F(SurfaceSleep, anIslandWithARigidBodyNeverSleepsByHalves) {
  btRigidBody* neighbour = bullet.addBox(vec(0.2, 0.2, 0.2), 1, vec(0.74, 0.2, 0));
  int asleepTogether = 0;
  for (int i = 0; i < 900; ++i) {
    if (i == 500) neighbour->activate(true);
    if (i == 700) body->wake();
    bullet.tick();
    const bool soft = body->surfaceObject()->getActivationState() == ISLAND_SLEEPING;
    const bool rigid = neighbour->getActivationState() == ISLAND_SLEEPING;
    ASSERT_EQ(soft, rigid) << "tick " << i;
    if (i == 500 || i == 700) {
      EXPECT_FALSE(soft) << "woken together";
    }
    asleepTogether += soft;
  }
  EXPECT_GT(asleepTogether, 200);
}

TEST_F(SurfaceSleep, aMovingPlatformWakesWhatSleepsOnIt) {
  sleep();
  floor->setCollisionFlags(floor->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  floor->forceActivationState(DISABLE_DEACTIVATION);
  for (int i = 1; i <= 60; ++i) {
    floor->setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(0, -1 + 0.005 * i, 0)));
    bullet.tick();
  }
  EXPECT_FALSE(body->sleeping());
  EXPECT_NEAR(body->centerOfMass().y(), 0.52 + 0.3, 0.02);
}

TEST_F(SurfaceSleep, outOfTheSimulationItStaysWhereItIs) {
  const Eigen::Vector3d before = body->centerOfMass();
  bullet.world->removeRigidBody(floor);
  body->surfaceObject()->forceActivationState(DISABLE_SIMULATION);
  bullet.simulate(1.0);
  // the positions of points that do not move are rounded to Bullet's floats
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_LT(body->velocity(i).norm(), 1e-6);
  EXPECT_NEAR(body->position(0).y(), before.y() - 0.5, 1e-6);
  body->surfaceObject()->forceActivationState(ACTIVE_TAG);
  bullet.simulate(1.0);
  EXPECT_NEAR(body->centerOfMass().y(), before.y() - 4.905, 1e-4);
}

// --- other -------------------------------------------------------------------------------------------------

TEST(SurfaceLife, aTickAllocatesNothingAlthoughBodiesFlyAndRest) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  for (int i = 0; i < 12; ++i) {
    SoftBodySettings s = settingsAt({1.5 * i, i % 2 ? 0.52 : 300.0, 0});
    s.sleepingSpeed = 0;
    (void)bullet.addSoft(cubeNetwork(), s);
  }
  bullet.simulate(2.0);
  EXPECT_EQ(allocationsIn([&] { bullet.simulate(1.0); }), 0u);
}

TEST(SurfaceLife, aFloorThatComesLaterIsFound) {
  SoftWorld bullet;
  SoftBody* body = bullet.addSoft(cubeNetwork(), settingsAt({0, 2, 0}));
  bullet.simulate(0.3);
  bullet.addBoxFloor();
  bullet.simulate(3.0);
  EXPECT_GT(body->centerOfMass().y(), 0.5);
}

TEST(SurfaceLife, pairsTheUserHasExcludedDoNotTouch) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addBoxFloor();
  SoftBody* body = bullet.addSoft(cubeNetwork(), settingsAt({0, 0.6, 0}));
  body->surfaceObject()->setIgnoreCollisionCheck(floor, true);
  bullet.simulate(1.0);
  EXPECT_LT(body->centerOfMass().y(), -3.0);
}

TEST(SurfaceLife, softBodiesThatTheUserHasExcludedDoNotTouch) {
  for (const bool both : {false, true}) {
    SoftWorld bullet;
    bullet.addBoxFloor();
    SoftBodySettings s = settingsAt({0, 0.6, 0});
    SoftBody* lower = bullet.addSoft(cubeNetwork(), s);
    s.position = {0.1, 2, 0};
    SoftBody* upper = bullet.addSoft(cubeNetwork(), s);
    upper->surfaceObject()->setIgnoreCollisionCheck(lower->surfaceObject(), true);
    if (both) lower->surfaceObject()->setIgnoreCollisionCheck(upper->surfaceObject(), true);
    bullet.simulate(2.0);
    EXPECT_LT(upper->centerOfMass().y(), 0.6) << both;
  }
}

TEST(SurfaceLife, pairsInOrderOfTheirIdsAreFineToo) {
  SoftWorld bullet;
  bullet.world->getDispatchInfo().m_deterministicOverlappingPairs = true;
  bullet.addBoxFloor();
  bullet.addBox(vec(0.3, 0.3, 0.3), 1, vec(0.2, 0.3, 0));
  SoftBody* body = bullet.addSoft(cubeNetwork(), settingsAt({1.2, 1, 0}));
  bullet.simulate(2.0);
  EXPECT_NEAR(body->centerOfMass().y(), 0.52, 0.01);
}

TEST(SurfaceLife, userPointerIndexAndFiltersAreTheUsers) {
  SoftWorld bullet;
  SoftBodySettings s = testedSettings();
  s.collisionGroup = 64;
  s.collisionMask = 1 | 2;
  btRigidBody* object = bullet.addSoft(cubeNetwork(), s)->surfaceObject();
  EXPECT_EQ(object->getUserPointer(), nullptr);
  EXPECT_EQ(object->getUserIndex(), -1);
  int mine = 0;
  object->setUserPointer(&mine);
  object->setUserIndex(7);
  bullet.simulate(0.2);
  EXPECT_EQ(object->getUserPointer(), &mine);
  EXPECT_EQ(object->getUserIndex(), 7);
  EXPECT_EQ(object->getBroadphaseHandle()->m_collisionFilterGroup, 64);
  EXPECT_EQ(object->getBroadphaseHandle()->m_collisionFilterMask, 3);
}

TEST(SurfaceLife, theApplicationMayDeleteTheSentinelToo) {
  // HelloWorld's clean-up loop, including motion states, after the application has accessed a point
  SoftWorld bullet;
  SoftBody* body = bullet.addSoft(cubeNetwork());
  body->point(0)->applyCentralForce(vec(1, 0, 0));
  bullet.tick();
  for (int i = bullet.world->getNumCollisionObjects() - 1; i >= 0; --i) {
    btRigidBody* object = btRigidBody::upcast(bullet.world->getCollisionObjectArray()[i]);
    EXPECT_TRUE(isSystemObject(object));
    delete object->getMotionState();
    bullet.world->removeCollisionObject(object);
    delete object;
  }
  bullet.tick();
  EXPECT_FALSE(body->alive());
  EXPECT_EQ(body->surfaceObject(), nullptr);
  (void)bullet.addSoft(cubeNetwork());
  bullet.tick();
}

TEST(SurfaceLife, aBodyWhoseObjectTheApplicationHasRemovedIsNotAlive) {
  SoftWorld bullet;
  SoftBodySettings s;
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  EXPECT_TRUE(body->alive());
  bullet.world->removeRigidBody(body->surfaceObject());
  EXPECT_FALSE(body->alive()) << "before the next tick";
  EXPECT_FALSE(bullet.system.clone(body, btTransform::getIdentity()));
  EXPECT_EQ(bullet.system.bodyCount(), 1u);
  bullet.tick();
  EXPECT_FALSE(body->alive());
  ASSERT_TRUE(bullet.system.destroyBody(body));
}

/// A pool of bodies. `out`: ticks without the body; then it is added again, as any other or as Bullet's own.
double heightOfPooled(int out, bool asRigid) {
  SoftWorld bullet;
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), settingsAt({0, 20, 0}));
  for (int i = 0; i < 20; ++i) bullet.tick();
  btRigidBody* object = body->surfaceObject();
  if (out >= 0) {
    const btBroadphaseProxy proxy = *object->getBroadphaseHandle();
    bullet.world->removeRigidBody(object);
    EXPECT_FALSE(body->alive());
    for (int i = 0; i < out; ++i) bullet.tick();
    if (asRigid)
      bullet.world->addRigidBody(object, proxy.m_collisionFilterGroup, proxy.m_collisionFilterMask);
    else
      bullet.world->addCollisionObject(object, proxy.m_collisionFilterGroup, proxy.m_collisionFilterMask);
  }
  for (int i = 0; i < 20; ++i) bullet.tick();
  EXPECT_TRUE(body->alive());
  return body->centerOfMass().y();
}

TEST(SurfaceLife, aBodyThatTheApplicationAddsAgainFallsOn) {
  const double height = heightOfPooled(-1, false);
  for (const int out : {0, 30})
    for (const bool asRigid : {false, true})
      EXPECT_EQ(heightOfPooled(out, asRigid), height) << out << asRigid;
}

TEST(SurfaceLife, aBodyWhoseObjectIsInAnotherWorldIsNotAlive) {
  BulletWorld other(0.0);
  btRigidBody* object = nullptr;
  {
    SoftWorld bullet;
    SoftBody* body = bullet.addSoft(cubeNetwork(), {});
    btRigidBody* rigid = bullet.addBox(vec(0.1, 0.1, 0.1), 1, vec(3, 0, 0));
    ASSERT_TRUE(bullet.system.addSpring({rigid, vec(0, 0, 0)}, {nullptr, vec(3, 1, 0)}));
    bullet.simulate(0.1);
    const Eigen::Vector3d place = body->centerOfMass();
    object = body->surfaceObject();
    for (btRigidBody* moved : {object, rigid}) {
      bullet.world->removeRigidBody(moved);
      other.world->addRigidBody(moved);
    }
    rigid->setLinearVelocity(vec(0, 0, 0));
    EXPECT_FALSE(body->alive());
    bullet.simulate(0.5);
    EXPECT_EQ(body->centerOfMass(), place);
    EXPECT_EQ(rigid->getLinearVelocity(), vec(0, 0, 0)) << "by the spring of its former world";
    EXPECT_TRUE(bullet.system.destroyBody(body));
    other.world->removeRigidBody(rigid);
    bullet.world->addRigidBody(rigid);
  }
  // it is left to whoever has moved it
  other.simulate(0.1);
  other.world->removeRigidBody(object);
  delete object;
}

}  // namespace
}  // namespace limber::test
