// SPDX-License-Identifier: Zlib
// World, bodies and system may be destroyed in any order. AddressSanitizer detects every invalid access.
#include "support/soft_world.h"

#include <cstdlib>
#include <utility>

namespace limber::test {
namespace {

SoftBody* addCube(SoftBodySystem& system, double x = 0.0) {
  return *system.createBody(cubeNetwork(), settingsAt({x, 1, 0}));
}

/// Returns an object that represents the body in the world: one of its points, or its surface.
btRigidBody* worldObjectOf(const SoftBody& body) { return kSurface ? body.surfaceObject() : body.point(2); }

/// The clean-up loop of Bullet's HelloWorld and of CommonRigidBodyBase. It deletes every collision object.
void deleteAllObjects(btDiscreteDynamicsWorld& world) {
  for (int i = world.getNumCollisionObjects() - 1; i >= 0; --i) {
    btCollisionObject* object = world.getCollisionObjectArray()[i];
    btRigidBody* body = btRigidBody::upcast(object);
    if (body && body->getMotionState()) delete body->getMotionState();
    world.removeCollisionObject(object);
    delete object;
  }
}

TEST(Teardown, systemFirst) {
  BulletWorld bullet;
  bullet.addBoxFloor();
  auto system = std::make_unique<SoftBodySystem>(*bullet.world);
  addCube(*system);
  bullet.tick();
  system.reset();
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 1);
  bullet.tick();
}

TEST(Teardown, worldFirstWithTheBodiesInIt) {
  SoftWorld bullet;
  SoftBody* body = addCube(bullet.system);
  bullet.tick();
  bullet.world.reset();
  EXPECT_FALSE(worldObjectOf(*body)->isInWorld());
}

TEST(Teardown, pointsMayBeAskedForWhenTheWorldHasGone) {
  auto bullet = std::make_unique<BulletWorld>();
  SoftBodySystem system(*bullet->world);
  SoftBody* accessed = addCube(system);
  SoftBody* pinned = addCube(system);
  bullet->tick();
  bullet.reset();
  ASSERT_NE(accessed->point(0), nullptr);
  EXPECT_NEAR(double(accessed->point(0)->getWorldTransform().getOrigin().y()), accessed->position(0).y(),
              1e-6);
  pinned->pin(1);
  system.removeAll();
}

TEST(Teardown, worldFirstThenRemoveAll) {
  SoftWorld bullet;
  addCube(bullet.system);
  bullet.tick();
  bullet.world.reset();
  bullet.system.removeAll();
  EXPECT_EQ(bullet.system.bodyCount(), 0u);
}

TEST(Teardown, worldFirstWithoutAnyBody) {
  SoftWorld bullet;
  bullet.system.destroyBody(addCube(bullet.system));
  bullet.tick();
  bullet.world.reset();
}

TEST(Teardown, helloWorldLoopThenWorldThenSystem) {
  SoftWorld bullet;
  SoftBody* body = addCube(bullet.system);
  bullet.tick();
  deleteAllObjects(*bullet.world);
  EXPECT_FALSE(body->alive());
  EXPECT_EQ(kSurface ? body->surfaceObject() : body->point(3), nullptr);
  bullet.tick();
  bullet.world.reset();
}

TEST(Teardown, helloWorldLoopThenSystemThenWorld) {
  BulletWorld bullet;
  auto system = std::make_unique<SoftBodySystem>(*bullet.world);
  addCube(*system);
  bullet.tick();
  deleteAllObjects(*bullet.world);
  system.reset();
  bullet.tick();
  bullet.tick();
}

TEST(Teardown, aNewWorldAtTheSamePlaceIsHookedAnew) {
  for (int round = 0; round < 3; ++round) {
    SoftWorld bullet;
    SoftBody* body = addCube(bullet.system);
    bullet.tick();
    EXPECT_GT(body->substeps(), 0);
    EXPECT_EQ(bullet.system.hookState(), HookState::Attached);
    bullet.world.reset();
  }
}

TEST(Teardown, aNewWorldAtTheSamePlaceMayHaveBodiesBeforeTheOldSystemGoes) {
  BulletWorld bullet;
  struct Settings {
    explicit Settings(BulletWorld& b) : dispatcher(b.world->getDispatcher()) {}
    btDispatcher* dispatcher;
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDefaultCollisionConfiguration configuration;
  } first(bullet), second(bullet);
  alignas(btDiscreteDynamicsWorld) unsigned char place[sizeof(btDiscreteDynamicsWorld)];
  const auto make = [&](Settings& s) {
    return new (place) btDiscreteDynamicsWorld(s.dispatcher, &s.broadphase, &s.solver, &s.configuration);
  };
  btDiscreteDynamicsWorld* world = make(first);
  auto old = std::make_unique<SoftBodySystem>(*world);
  addCube(*old);
  world->stepSimulation(btScalar(kTick), 0);
  world->~btDiscreteDynamicsWorld();
  world = make(second);
  auto system = std::make_unique<SoftBodySystem>(*world);
  SoftBody* cube = addCube(*system);
  for (int i = 0; i < 10; ++i) world->stepSimulation(btScalar(kTick), 0);
  old.reset();
  for (int i = 0; i < 20; ++i) world->stepSimulation(btScalar(kTick), 0);
  EXPECT_EQ(system->hookState(), HookState::Attached);
  EXPECT_GT(cube->substeps(), 0);
  EXPECT_LT(cube->centerOfMass().y(), 0.0) << "half a second of fall";
  system.reset();
  world->~btDiscreteDynamicsWorld();
}

TEST(Teardown, removingOnePointEndsTheBodyButNotTheWorld) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBody* first = addCube(bullet.system);
  SoftBody* second = addCube(bullet.system);
  bullet.tick();
  bullet.world->removeRigidBody(worldObjectOf(*first));
  bullet.simulate(0.2);
  EXPECT_FALSE(first->alive());
  EXPECT_TRUE(second->alive());
  EXPECT_GT(second->substeps(), 0);
  bullet.system.destroyBody(first);
  bullet.tick();
  EXPECT_EQ(bullet.system.bodyCount(), 1u);
}

TEST(Teardown, theOtherPointsRestOnTheFloorAsBulletsOwnBodies) {
  if (kSurface) GTEST_SKIP() << "no points in the world";
  SoftWorld bullet;
  bullet.addPlaneFloor();
  SoftBody* cube = bullet.addSoft(cubeNetwork(), settingsAt({0, 0.52, 0}));
  for (int i = 0; i < 60; ++i) bullet.tick();
  btRigidBody* removed = nullptr;
  for (std::uint32_t i = 0; i < cube->pointCount(); ++i)
    if (cube->position(i).y() > 0.5) removed = cube->point(i);
  bullet.world->removeRigidBody(removed);
  for (int i = 0; i < 60; ++i) bullet.tick();
  EXPECT_FALSE(cube->alive());
  for (std::uint32_t i = 0; i < cube->pointCount(); ++i)
    EXPECT_GT(double(cube->point(i)->getWorldTransform().getOrigin().y()), 0.0) << "point " << i;
  bullet.world->addRigidBody(removed);
  EXPECT_TRUE(cube->alive());
}

TEST(Teardown, bodiesComeAndGoWhileTheWorldRuns) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  for (int i = 0; i < 20; ++i) {
    addCube(bullet.system, 0.7 * i);  // partly in the last one
    bullet.tick();
    if (i % 3 == 2) bullet.system.destroyBody(bullet.system.body(0));
    bullet.tick();
  }
  EXPECT_EQ(bullet.system.bodyCount(), 14u);
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 1 + 14 * (kSurface ? 1 : 8));
  bullet.system.removeAll();
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 1);
}

TEST(Teardown, springsAndAnchorsGoWithTheirBodies) {
  SoftWorld bullet;
  SoftBody* a = addCube(bullet.system);
  SoftBody* b = addCube(bullet.system);
  btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 5, 0));
  ASSERT_TRUE(bullet.system.addSpring({a->point(0)}, {b->point(0)}));
  ASSERT_TRUE(bullet.system.addSpring({a->point(1)}, {box}));
  ASSERT_TRUE(bullet.system.attach(b, 3, *box));
  bullet.tick();
  bullet.system.destroyBody(a);
  EXPECT_EQ(bullet.system.springCount(), 0u);
  bullet.tick();
  bullet.system.forget(*box);
  EXPECT_FALSE(bullet.system.detach(b, 3)) << "it was already let go";
  bullet.world->removeRigidBody(box);
  bullet.tick();
  EXPECT_TRUE(b->alive());
}

TEST(Teardown, springsOfAnotherSystemGoWithTheSystemOfTheirPoints) {
  BulletWorld bullet;
  auto first = std::make_unique<SoftBodySystem>(*bullet.world);
  SoftBodySystem second(*bullet.world);
  SoftBody* gone = addCube(*first);
  SoftBody* stays = addCube(second);
  btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 5, 0));
  ASSERT_TRUE(second.addSpring({gone->point(0)}, {box}));
  ASSERT_TRUE(second.addSpring({stays->point(0)}, {gone->point(1)}));
  ASSERT_TRUE(second.addSpring({stays->point(1)}, {box}));
  bullet.tick();
  first.reset();
  EXPECT_EQ(second.springCount(), 1u);
  bullet.tick();
  EXPECT_TRUE(stays->alive());
}

TEST(Teardown, springsOnDeletedPointsGoWithThem) {
  SoftWorld bullet;
  SoftBody* a = addCube(bullet.system);
  SoftBody* b = addCube(bullet.system);
  ASSERT_TRUE(bullet.system.addSpring({a->point(0)}, {b->point(0)}));
  ASSERT_TRUE(bullet.system.addSpring({b->point(1)}, {nullptr}));
  bullet.tick();
  btRigidBody* point = a->point(0);
  bullet.world->removeRigidBody(point);
  bullet.tick();
  delete point;
  bullet.tick();
  EXPECT_EQ(bullet.system.springCount(), 1u);
  EXPECT_TRUE(b->alive());
}

TEST(Teardown, aRigidBodyMayLeaveTheWorldAndComeBack) {
  SoftWorld bullet(0.0);
  SoftBody* body = addCube(bullet.system);
  btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 9, 0));
  SpringSettings pull;
  pull.restLength = 1.0;
  ASSERT_TRUE(bullet.system.addSpring({body->point(0)}, {box}, pull));
  bullet.world->removeRigidBody(box);
  bullet.simulate(0.1);
  EXPECT_EQ(body->linearMomentum().norm(), 0.0) << "a spring to nowhere does not pull";
  bullet.world->addRigidBody(box);
  bullet.simulate(0.1);
  EXPECT_GT(body->linearMomentum().norm(), 0.1) << "now it does";
}

TEST(Teardown, removeAllBeforeTheBroadphaseGoes) {
  auto broadphase = std::make_unique<btDbvtBroadphase>();
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btSequentialImpulseConstraintSolver solver;
  auto world =
      std::make_unique<btDiscreteDynamicsWorld>(&dispatcher, broadphase.get(), &solver, &configuration);
  SoftBodySystem system(*world);
  addCube(system);
  world->stepSimulation(btScalar(1.0 / 60), 0);
  system.removeAll();
  broadphase.reset();
  world.reset();
}

// --- hooks -------------------------------------------------------------------------------------------------

struct CallbackPeek : btDynamicsWorld {
  static btInternalTickCallback of(const btDynamicsWorld& world) {
    return world.*(&CallbackPeek::m_internalPreTickCallback);
  }
};

TEST(Teardown, aSurfaceThatTheUserHasRemovedEndsWithItsSentinel) {
  BulletWorld bullet;
  for (const bool bySystem : {false, true}) {
    auto system = std::make_unique<SoftBodySystem>(*bullet.world);
    SoftBody* body = addCube(*system);
    body->point(0)->applyCentralImpulse(btVector3(1, 0, 0));
    bullet.tick();
    for (int i = bullet.world->getNumCollisionObjects() - 1; i >= 0; --i) {
      btCollisionObject* object = bullet.world->getCollisionObjectArray()[i];
      if (findPoint(object).body == body || findSurface(object).body == body)
        bullet.world->removeCollisionObject(object);
    }
    if (!bySystem) system->destroyBody(body);
    system.reset();
    EXPECT_EQ(bullet.world->getNumCollisionObjects(), 0);
    bullet.tick();
    EXPECT_EQ(CallbackPeek::of(*bullet.world), nullptr);
  }
}

/// Creates a static system, which is destroyed after all statics that its first body has created.
void leaveASystemBehind() {
  static BulletWorld bullet;
  static SoftBodySystem system(*bullet.world);
  addCube(system);
  bullet.tick();
  std::exit(0);
}

TEST(Teardown, aSystemMayOutliveTheProgram) {
  // in a separate process, in which Limber has not been used before
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(leaveASystemBehind(), testing::ExitedWithCode(0), "");
}

SoftBodySystem* callbacksSystem = nullptr;
SoftBodySystem* callbacksOwnSystem = nullptr;
void destroyAll(btDynamicsWorld*, btScalar) {
  delete std::exchange(callbacksOwnSystem, nullptr);
  if (!callbacksSystem) return;
  while (callbacksSystem->bodyCount() > 0) callbacksSystem->destroyBody(callbacksSystem->body(0));
}

TEST(Teardown, theLastBodyMayGoInTheUsersPreTick) {
  BulletWorld bullet;
  bullet.world->setInternalTickCallback(destroyAll, nullptr, true);
  SoftBodySystem system(*bullet.world);
  callbacksSystem = &system;
  for (int round = 0; round < 3; ++round) {
    addCube(system);
    EXPECT_EQ(system.hookState(), HookState::Attached);
    bullet.tick();
    EXPECT_EQ(system.hookState(), HookState::Idle);
    EXPECT_EQ(CallbackPeek::of(*bullet.world), &destroyAll);
    bullet.tick();
  }
  callbacksSystem = nullptr;
}

TEST(Teardown, theSystemMayGoInTheUsersPreTick) {
  BulletWorld bullet;
  bullet.world->setInternalTickCallback(destroyAll, nullptr, true);
  SoftBodySystem other(*bullet.world);
  callbacksOwnSystem = new SoftBodySystem(*bullet.world);
  addCube(*callbacksOwnSystem);
  SoftBody* body = addCube(other);
  bullet.tick();
  EXPECT_GT(body->substeps(), 0) << "the other system is stepped in this tick, too";
  other.removeAll();
  EXPECT_EQ(CallbackPeek::of(*bullet.world), &destroyAll);
}

/// An action of the application that creates a body.
struct BodyCreator final : btActionInterface {
  SoftBodySystem* system = nullptr;
  void updateAction(btCollisionWorld*, btScalar) override {
    if (system->bodyCount() == 0) addCube(*system);
  }
  void debugDraw(btIDebugDraw*) override {}
};

TEST(Teardown, aBodyMadeAfterTheBeginOfATickMissesNothing) {
  SoftWorld bullet;
  int warnings = 0;
  bullet.system.onWarning([&](const std::string&) { ++warnings; });
  BodyCreator creator;
  creator.system = &bullet.system;
  bullet.world->addAction(&creator);
  bullet.tick();
  bullet.tick();
  EXPECT_EQ(warnings, 0);
  EXPECT_EQ(bullet.system.hookState(), HookState::Attached);
  bullet.world->removeAction(&creator);
}

TEST(Teardown, systemsOfSpringsAloneLeaveTheWorldAsItWas) {
  for (int method = 0; method < 4; ++method) {
    BulletWorld bullet;
    btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 5, 0));
    auto system = std::make_unique<SoftBodySystem>(*bullet.world);
    SpringConstraint* spring = *system->addSpring({box}, {nullptr});
    bullet.tick();
    EXPECT_NE(CallbackPeek::of(*bullet.world), nullptr);
    if (method == 0) system->removeSpring(spring);
    if (method == 1) system->removeAll();
    if (method == 2) system.reset();
    if (method == 3) system->forget(*box);
    if (system) {
      EXPECT_EQ(system->hookState(), HookState::Idle);
    }
    // The plugin has no object in the world that could detect this. The next tick does.
    bullet.tick();
    EXPECT_EQ(CallbackPeek::of(*bullet.world), nullptr) << method;
  }
}

TEST(Teardown, ofASurfaceObjectThatTheUserHasAddedAgain) {
  SoftWorld bullet;
  SoftBody* body = bullet.addSoft(cubeNetwork(), SoftBodySettings());
  btRigidBody* object = body->surfaceObject();
  if (!object) GTEST_SKIP() << "points alone have none";
  bullet.tick();
  bullet.world->removeRigidBody(object);
  bullet.world->addRigidBody(object, 2, -1);
  bullet.tick();
  EXPECT_TRUE(bullet.system.destroyBody(body));
  bullet.simulate(0.1);  // Bullet must not have it any more
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 0);
}

}  // namespace
}  // namespace limber::test
