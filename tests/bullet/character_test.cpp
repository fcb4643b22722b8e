// SPDX-License-Identifier: Zlib
// Bullet's characters stand, walk and jump on soft bodies, push them, and walk through curtains.
#include "support/soft_world.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace limber::test {
namespace {

/// Bullet's character on a floor, set up as in Bullet's demos.
struct Character {
  Character(BulletWorld& bulletWorld, const btVector3& position, int mask = btBroadphaseProxy::AllFilter)
      : bullet(bulletWorld) {
    bullet.world->getPairCache()->setInternalGhostPairCallback(&pairs);
    ghost.setCollisionShape(&capsule);
    ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
    ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), position));
    bullet.world->addCollisionObject(&ghost, btBroadphaseProxy::CharacterFilter, mask);
    bullet.world->addAction(&controller);
    controller.setGravity(vec(0, -9.81, 0));
  }
  ~Character() {
    bullet.world->removeAction(&controller);
    bullet.world->removeCollisionObject(&ghost);
    bullet.world->getPairCache()->setInternalGhostPairCallback(nullptr);
  }
  btVector3 position() const { return ghost.getWorldTransform().getOrigin(); }

  BulletWorld& bullet;
  btGhostPairCallback pairs;
  btCapsuleShape capsule{btScalar(0.3), btScalar(1)};
  btPairCachingGhostObject ghost;
  btKinematicCharacterController controller{&ghost, &capsule, btScalar(0.2), vec(0, 1, 0)};
};

TEST(Characters, walkAgainstACubeAndPushIt) {
  if (!kSurface) GTEST_SKIP() << "the corners of the face let a capsule pass between them";
  SoftWorld bullet;
  bullet.addPlaneFloor();
  SoftBodySettings s = testedSettings();
  s.position.y() = 0.5 + kRadius;
  setSprings(s, 2000, 5);
  s.totalMass = 2;
  s.pointRadius = kRadius;
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
  Character character(bullet, vec(-2, 0.8, 0));
  character.controller.setWalkDirection(vec(2 * kTick, 0, 0));
  bullet.simulate(3);
  EXPECT_GT(cube->centerOfMass().x(), 0.2);
  EXPECT_LT(double(character.position().x()), cube->centerOfMass().x() - 0.5) << "it does not walk through";
  EXPECT_NEAR(cube->centerOfMass().y(), 0.5 + kRadius, 0.05);
}

TEST(Characters, thatAreWarpedPushNothingOnTheirWay) {
  for (const double distance : {3.0, 6.0, 40.0}) {
    SoftWorld bullet;
    bullet.addPlaneFloor();
    SoftBodySettings s = testedSettings();
    s.position.y() = 0.5 + kRadius;
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
    Character character(bullet, vec(-1.5, 0.8, 0));
    bullet.simulate(1);
    const double before = cube->centerOfMass().x();
    character.controller.warp(vec(distance - 1.5, 0.8, 0));
    bullet.simulate(0.5);
    EXPECT_NEAR(cube->centerOfMass().x(), before, 1e-3) << distance;
  }
}

/// The height (m) of the centre of a Character above its feet.
constexpr double kCharacterHeight = 0.8;

/// A controller stands as deep (m) in the floor as Bullet's sweeps allow.
constexpr double kSunk = 0.04;

/// A cushion of 6 m x 1 m x 3 m.
SoftBody* addCushion(SoftBodySystem& system, double mass) {
  SoftBodySettings s = settingsAt({0, 0.5 + kRadius, 0});
  s.scale = {6, 1, 3};
  s.totalMass = mass;
  s.pointRadius = kRadius;
  setSprings(s, 300 * mass, 0.3 * mass);
  return *system.createBody(closedCubeNetwork(), s);
}

/// A cloth of 6 m x 3 m at a height of 1 m, pinned all around.
SoftBody* addPinnedCloth(SoftBodySystem& system, double mass) {
  SoftBodySettings s = settingsAt({0, 1, 0});
  s.totalMass = mass;
  s.pointRadius = 0.03;
  setSprings(s, 200 * mass, 3 * mass);
  SoftBody* cloth = *system.createBody(clothNetwork(24, 12, 6, 3), s);
  for (std::uint32_t i = 0; i < cloth->pointCount(); ++i)
    if (std::abs(cloth->position(i).x()) > 2.99 || std::abs(cloth->position(i).z()) > 1.49) cloth->pin(i);
  return cloth;
}

/// Returns the largest distance (m) of the feet from `depth` (m) below the top of the body.
double characterError(BulletWorld& bullet, const SoftBody& body, const Character& character, double depth) {
  double largest = 0.0;
  for (int i = 0; i < 180; ++i) {
    bullet.tick();
    const double feet = double(character.position().y()) - kCharacterHeight;
    largest = std::max(largest, std::abs(feet - (body.centerOfMass().y() + 0.5 + kRadius - depth)));
  }
  return largest;
}

TEST(Characters, standAndWalkOnACushionOfAnyMass) {
  if (!kSurface) GTEST_SKIP() << "a character falls through the face between the corners";
  for (const double mass : {300.0, 3.0})
    for (const double walk : {0.0, 1.2}) {
      SoftWorld bullet;
      bullet.addPlaneFloor();
      SoftBody* cushion = addCushion(bullet.system, mass);
      bullet.simulate(1.0);
      const Eigen::Vector3d start = cushion->centerOfMass();
      Character character(bullet, vec(-2, 2, 0.2));
      bullet.simulate(1.0);
      character.controller.setWalkDirection(vec(walk * kTick, 0, 0));
      EXPECT_LT(characterError(bullet, *cushion, character, kSunk), 0.01) << mass;
      EXPECT_NEAR(double(character.position().x()), -2 + 3 * walk, 0.1);
      EXPECT_LT((cushion->centerOfMass() - start).norm(), 0.01) << mass;
    }
}

TEST(Characters, thatStartInACushionDoNotThrowIt) {
  if (!kSurface) GTEST_SKIP() << "a capsule passes between the corners";
  for (const double mass : {300.0, 3.0}) {
    SoftWorld bullet;
    bullet.addPlaneFloor();
    SoftBody* cushion = addCushion(bullet.system, mass);
    bullet.simulate(1.0);
    Character character(bullet, vec(-2, 1, 0.2));
    for (int i = 0; i < 300; ++i) {
      bullet.tick();
      ASSERT_LT(cushion->centerOfMass().y(), 0.6) << "tick " << i;
    }
    EXPECT_LT(cushion->linearMomentum().norm() / mass, 0.05);
  }
}

TEST(Characters, jumpOnACushionWithoutThrowingIt) {
  if (!kSurface) GTEST_SKIP() << "a character falls through the face between the corners";
  SoftWorld bullet;
  bullet.addPlaneFloor();
  SoftBody* cushion = addCushion(bullet.system, 30);
  bullet.simulate(1.0);
  Character character(bullet, vec(-2, 2, 0.2));
  double highest = 0.0;
  for (int i = 0; i < 600; ++i) {
    if (i % 60 == 59 && character.controller.canJump()) character.controller.jump(vec(0, 6, 0));
    bullet.tick();
    highest = std::max(highest, double(character.position().y()));
    ASSERT_NEAR(cushion->centerOfMass().y(), 0.5 + kRadius, 0.05) << "tick " << i;
  }
  EXPECT_GT(highest, 2.5) << "it has jumped";
}

TEST(Characters, sinkInAClothAsFarAsItGivesWay) {
  for (const double mass : {100.0, 1.0}) {
    SoftWorld bullet;
    bullet.addPlaneFloor();
    SoftBody* cloth = addPinnedCloth(bullet.system, mass);
    bullet.simulate(1.0);
    Character character(bullet, vec(-2, 2, 0.2));
    bullet.simulate(5.0);
    const double feet = double(character.position().y()) - kCharacterHeight;
    EXPECT_GT(feet, 0.7) << mass;
    EXPECT_LT(feet, 1.0) << mass;
    bullet.simulate(5.0);
    EXPECT_NEAR(double(character.position().y()) - kCharacterHeight, feet, 0.02) << "at rest";
    EXPECT_LT(cloth->kineticEnergy(), 0.01 * mass);
  }
}

/// A filter group for what characters walk through.
constexpr int kCurtains = 64;

/// A curtain of 1 m x 2 m at x = 0, pinned along its top.
SoftBody* addCurtain(SoftBodySystem& system) {
  SoftBodySettings s = settingsAt({0, 1.2, 0});
  s.totalMass = 0.2;
  s.pointRadius = kRadius;
  s.rotation = Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitY()) *
               Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitX());
  s.collisionGroup = kCurtains;
  SoftBody* curtain = *system.createBody(clothNetwork(10, 20, 1, 2), s);
  for (std::uint32_t i = 0; i < curtain->pointCount(); ++i)
    if (curtain->position(i).y() > 2.19) curtain->pin(i);
  return curtain;
}

/// The sweep of the controller does not see the curtain, which a kinematic capsule pushes aside instead.
TEST(Characters, walkThroughACurtainOfAnotherGroup) {
  if (!kSurface) GTEST_SKIP() << "a capsule passes between the points";
  SoftWorld bullet;
  bullet.addPlaneFloor();
  SoftBody* curtain = addCurtain(bullet.system);
  Character character(bullet, vec(-2, 0.8, 0), btBroadphaseProxy::AllFilter & ~kCurtains);
  btRigidBody* body =
      bullet.add(std::make_unique<btCapsuleShape>(btScalar(0.3), btScalar(1)), 0.0, character.position());
  bullet.world->removeRigidBody(body);
  makeKinematic(*body);
  bullet.world->addRigidBody(body, btBroadphaseProxy::CharacterFilter, kCurtains);
  character.controller.setWalkDirection(vec(2 * kTick, 0, 0));
  double farthest = 0.0;
  for (int i = 0; i < 240; ++i) {
    body->setWorldTransform(character.ghost.getWorldTransform());
    bullet.tick();
    farthest = std::max(farthest, curtain->centerOfMass().x());
  }
  EXPECT_NEAR(double(character.position().x()), -2 + 4 * 2, 0.1) << "nothing stops it";
  EXPECT_GT(farthest, 0.3) << "it pushes the curtain aside";
}

}  // namespace
}  // namespace limber::test
