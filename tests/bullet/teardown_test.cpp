// SPDX-License-Identifier: Zlib
// World, bodies and system may go in any order. Run under AddressSanitizer these tests see every wrong
// access.
#include "support/bullet_world.h"
#include "support/networks.h"
#include "support/tested_way.h"

#include <limber/soft_body_system.h>

#include <gtest/gtest.h>

namespace limber {
namespace {

using test::BulletWorld;

SoftBody* addCube(SoftBodySystem& system) {
  SoftBodySettings s = test::testedSettings();
  s.position = {0, 1, 0};
  return *system.createBody(test::cubeNetwork(), s);
}

/// What of a body is in the world: one of its points, or its surface.
btRigidBody* inWorld(const SoftBody& body) { return test::kSurface ? body.surfaceObject() : body.point(2); }

/// The clean-up loop of Bullet's HelloWorld and of CommonRigidBodyBase: every collision object goes.
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
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world);
  SoftBody* body = addCube(system);
  bullet.tick();
  bullet.world.reset();
  EXPECT_FALSE(inWorld(*body)->isInWorld());
}

TEST(Teardown, worldFirstThenRemoveAll) {
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world);
  addCube(system);
  bullet.tick();
  bullet.world.reset();
  system.removeAll();
  EXPECT_EQ(system.bodyCount(), 0u);
}

TEST(Teardown, worldFirstWithoutAnyBody) {
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world);
  system.destroyBody(addCube(system));
  bullet.tick();
  bullet.world.reset();
}

TEST(Teardown, helloWorldLoopThenWorldThenSystem) {
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world);
  SoftBody* body = addCube(system);
  bullet.tick();
  deleteAllObjects(*bullet.world);
  EXPECT_FALSE(body->alive());
  EXPECT_EQ(test::kSurface ? body->surfaceObject() : body->point(3), nullptr);
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
    BulletWorld bullet;
    SoftBodySystem system(*bullet.world);
    SoftBody* body = addCube(system);
    bullet.tick();
    EXPECT_GT(body->substeps(), 0);
    EXPECT_EQ(system.hookState(), HookState::Attached);
    bullet.world.reset();
  }
}

TEST(Teardown, removingOnePointEndsTheBodyButNotTheWorld) {
  BulletWorld bullet;
  bullet.addBoxFloor();
  SoftBodySystem system(*bullet.world);
  SoftBody* first = addCube(system);
  SoftBody* second = addCube(system);
  bullet.tick();
  bullet.world->removeRigidBody(inWorld(*first));
  bullet.simulate(0.2);
  EXPECT_FALSE(first->alive());
  EXPECT_TRUE(second->alive());
  EXPECT_GT(second->substeps(), 0);
  system.destroyBody(first);
  bullet.tick();
  EXPECT_EQ(system.bodyCount(), 1u);
}

TEST(Teardown, bodiesComeAndGoWhileTheWorldRuns) {
  BulletWorld bullet;
  bullet.addBoxFloor();
  SoftBodySystem system(*bullet.world);
  for (int i = 0; i < 20; ++i) {
    addCube(system);
    bullet.tick();
    if (i % 3 == 2) system.destroyBody(system.body(0));
    bullet.tick();
  }
  EXPECT_EQ(system.bodyCount(), 14u);
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 1 + 14 * (test::kSurface ? 1 : 8));
  system.removeAll();
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 1);
}

TEST(Teardown, springsAndAnchorsGoWithTheirBodies) {
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world);
  SoftBody* a = addCube(system);
  SoftBody* b = addCube(system);
  btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 5, 0));
  ASSERT_TRUE(system.addSpring({a->point(0)}, {b->point(0)}));
  ASSERT_TRUE(system.addSpring({a->point(1)}, {box}));
  ASSERT_TRUE(system.attach(b, 3, *box));
  bullet.tick();
  system.destroyBody(a);
  EXPECT_EQ(system.springCount(), 0u);
  bullet.tick();
  system.forget(*box);
  EXPECT_FALSE(system.detach(b, 3)) << "it was already let go";
  bullet.world->removeRigidBody(box);
  bullet.tick();
  EXPECT_TRUE(b->alive());
}

TEST(Teardown, springsOnDeletedPointsGoWithThem) {
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world);
  SoftBody* a = addCube(system);
  SoftBody* b = addCube(system);
  ASSERT_TRUE(system.addSpring({a->point(0)}, {b->point(0)}));
  ASSERT_TRUE(system.addSpring({b->point(1)}, {nullptr}));
  bullet.tick();
  btRigidBody* point = a->point(0);
  bullet.world->removeRigidBody(point);
  bullet.tick();
  delete point;
  bullet.tick();
  EXPECT_EQ(system.springCount(), 1u);
  EXPECT_TRUE(b->alive());
}

TEST(Teardown, aRigidBodyMayLeaveTheWorldAndComeBack) {
  BulletWorld bullet(0.0);
  SoftBodySystem system(*bullet.world);
  SoftBody* body = addCube(system);
  btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 9, 0));
  SpringSettings pull;
  pull.restLength = 1.0;
  ASSERT_TRUE(system.addSpring({body->point(0)}, {box}, pull));
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

}  // namespace
}  // namespace limber
