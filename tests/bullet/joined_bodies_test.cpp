// SPDX-License-Identifier: Zlib
// Springs that break, welds, skeletons, and ropes with heavy loads.
#include "support/bullet_world.h"
#include "support/constants.h"
#include "support/networks.h"
#include "support/tested_way.h"

#include <limber/limber.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace limber {
namespace {

using test::BulletWorld;
using test::vec;

// --- springs that break ------------------------------------------------------------------------------------

/// A box that hangs by a spring which holds `force`, in N.
double heightAfterASecond(double force, bool& broken) {
  BulletWorld bullet(-10.0);
  SoftBodySystem system(*bullet.world);
  btRigidBody* box = bullet.addBox(vec(0.1, 0.1, 0.1), 2.0, vec(0, 0, 0));
  SpringSettings spring;
  spring.stiffness = 1e4;
  spring.damping = 200.0;
  spring.breakForce = force;
  SpringConstraint* held = *system.addSpring({nullptr, vec(0, 1, 0)}, {box}, spring);
  bullet.simulate(1.0);
  broken = held->broken();
  if (broken) {
    EXPECT_EQ(held->force(), 0.0);
    EXPECT_TRUE(system.changeSpring(held, held->settings()));
    EXPECT_FALSE(held->broken());
  }
  return double(box->getCenterOfMassPosition().y());
}

TEST(BreakForce, aSpringBreaksUnderMoreThanItHolds) {
  bool broken = false;
  // it carries 20 N, and up to twice that while the box swings in
  EXPECT_NEAR(heightAfterASecond(41.0, broken), -20.0 / 1e4, 1e-4);
  EXPECT_FALSE(broken);
  EXPECT_LT(heightAfterASecond(15.0, broken), -4.0);
  EXPECT_TRUE(broken);
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world);
  SpringSettings bad;
  bad.breakForce = -1.0;
  EXPECT_EQ(system.addSpring({nullptr}, {bullet.addBox(vec(1, 1, 1), 1.0, vec(0, 0, 0))}, bad).error(),
            "breakForce is -1, must be from 0 to 1e18");
}

// --- welds -------------------------------------------------------------------------------------------------

/// Two cubes one above the other whose faces are welded, the upper one pinned.
struct WeldedCubes {
  explicit WeldedCubes(double breakForce) : bullet(-10.0), system(*bullet.world) {
    SoftBodySettings s = test::testedSettings();
    s.extensionStiffness = s.compressionStiffness = 2000.0;
    s.damping = 10.0;
    upper = *system.createBody(test::closedCubeNetwork(), s);
    s.position = {0, -1.05, 0};
    lower = *system.createBody(test::closedCubeNetwork(), s);
    SpringSettings seam;
    seam.stiffness = 2000.0;
    seam.damping = 10.0;
    seam.breakForce = breakForce;
    const auto made = system.weld(upper, lower, 0.06, seam);
    EXPECT_TRUE(made) << made.error();
    if (made) springs = *made;
    for (std::uint32_t i = 0; i < 8; ++i)
      if (upper->position(i).y() > 0.0) upper->pin(i);
  }
  BulletWorld bullet;
  SoftBodySystem system;
  SoftBody *upper, *lower;
  std::vector<SpringConstraint*> springs;
};

TEST(Weld, holdsWhatItCan) {
  WeldedCubes strong(0.0), weak(1.5);
  ASSERT_EQ(strong.springs.size(), 4u) << "one at each corner of the faces that meet";
  strong.bullet.simulate(4.0);
  weak.bullet.simulate(4.0);
  double sum = 0.0;
  for (const SpringConstraint* spring : strong.springs) sum += spring->force();
  EXPECT_NEAR(sum, 10.0, 0.05) << "the seam carries the weight of 1 kg";
  EXPECT_GT(strong.lower->centerOfMass().y(), -1.2);
  for (const SpringConstraint* spring : weak.springs) EXPECT_TRUE(spring->broken());
  EXPECT_LT(weak.lower->centerOfMass().y(), -20.0);
}

TEST(Weld, impossibleOnesAreRefused) {
  WeldedCubes cubes(0.0);
  EXPECT_EQ(cubes.system.weld(cubes.upper, cubes.upper, 1.0).error(),
            "a soft body cannot be welded to itself");
  EXPECT_EQ(cubes.system.weld(cubes.upper, cubes.lower, 0.0).error(),
            "the distance of a weld must be above 0");
  EXPECT_EQ(cubes.system.weld(cubes.upper, cubes.lower, 0.01).error(),
            "no points of the two bodies are within the distance");
  EXPECT_EQ(cubes.system.springCount(), 4u);
}

// --- skeletons ---------------------------------------------------------------------------------------------

btTransform bone(double x, double angle) {
  return btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(angle)), vec(x, 0, 0));
}

TEST(BoundSkeleton, pointsFollowTheirBonesByWeights) {
  BulletWorld bullet(0.0);
  SoftBodySystem system(*bullet.world);
  SoftBody* body = *system.createBody(test::closedCubeNetwork(), test::testedSettings());
  const Eigen::Vector3d start[] = {body->position(0), body->position(1), body->position(2)};
  std::vector<btTransform> bones = {bone(0, 0), bone(1, 0)};
  auto skeleton = Skeleton::bind(*body, {{0, {{0, 1.0}}}, {1, {{1, 1.0}}}, {2, {{0, 0.5}, {1, 0.5}}}}, bones);
  ASSERT_TRUE(skeleton) << skeleton.error();
  for (int i = 0; i <= 30; ++i) {
    bones[1] = bone(1, 0.01 * i);
    ASSERT_TRUE(skeleton->moveTo(bones));
    bullet.tick();
  }
  const Eigen::AngleAxisd turn(0.3, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d pivot = Eigen::Vector3d::UnitX();
  const auto turned = [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(pivot + turn * (x - pivot)); };
  EXPECT_LT((body->position(0) - start[0]).norm(), 1e-6);
  EXPECT_LT((body->position(1) - turned(start[1])).norm(), 1e-5);
  EXPECT_LT((body->position(2) - 0.5 * (start[2] + turned(start[2]))).norm(), 1e-5);
  bones = {bone(50, 0), bone(51, 0)};
  ASSERT_TRUE(skeleton->moveTo(bones, true));
  EXPECT_LT((body->position(0) - start[0] - Eigen::Vector3d(50, 0, 0)).norm(), 1e-5);
  EXPECT_LT(body->velocity(0).norm(), 1e-9);
  skeleton->release();
  EXPECT_FALSE(body->pinned(0));
  ASSERT_TRUE(system.destroyBody(body));
  EXPECT_EQ(skeleton->moveTo(bones).error(), "the soft body of the skeleton has been destroyed");
}

TEST(BoundSkeleton, badBindingsAreNamedAndPinNothing) {
  BulletWorld bullet(0.0);
  SoftBodySystem system(*bullet.world);
  SoftBody* body = *system.createBody(test::closedCubeNetwork(), test::testedSettings());
  const std::vector<btTransform> bones = {bone(0, 0)};
  EXPECT_EQ(Skeleton::bind(*body, {{0, {{0, 1.0}}}, {99, {{0, 1.0}}}}, bones).error(),
            "bound point 1: there is no point 99");
  EXPECT_EQ(Skeleton::bind(*body, {{0, {{3, 1.0}}}}, bones).error(), "bound point 0: there is no bone 3");
  EXPECT_EQ(Skeleton::bind(*body, {{0, {{0, 0.7}}}}, bones).error(),
            "bound point 0: the weights do not sum to 1");
  EXPECT_FALSE(body->pinned(0));
  auto skeleton = Skeleton::bind(*body, {{0, {{0, 1.0}}}}, bones);
  EXPECT_EQ(skeleton->moveTo({}).error(), "0 bones, bound were 1");
}

// --- heavy loads -------------------------------------------------------------------------------------------

TEST(HeavyLoad, aBoxOfATonHangsFromARopeOfAHundredGrams) {
  BulletWorld bullet(-10.0);
  SoftBodySystem system(*bullet.world);
  RopeSettings shape;
  shape.length = 2.0;
  shape.segments = 20;
  shape.bendingScale = 0.0;
  SoftBodySettings s = test::testedSettings();
  s.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(-M_PI / 2.0, Eigen::Vector3d::UnitZ()));
  s.totalMass = 0.1;
  s.extensionStiffness = s.compressionStiffness = 2e7;
  s.damping = 2e3;
  SoftBody* rope = *system.createBody(*buildRope(shape), s);
  ASSERT_TRUE(rope->pin(0));
  btRigidBody* box = bullet.addBox(vec(0.3, 0.3, 0.3), 1000.0, vec(0, -2.3, 0));
  ASSERT_TRUE(system.attach(rope, 20, *box, vec(0, 0.3, 0)));
  double lowest = 0.0, sum = 0.0;
  for (int i = 0; i < 240; ++i) {
    bullet.tick();
    const double y = double(box->getCenterOfMassPosition().y());
    lowest = std::min(lowest, y);
    sum += y / 240.0;
  }
  // 1e4 N stretch each of 20 springs of 2e7 N/m by 0.5 mm: 10 mm; dropped at rest, it swings at most twice as
  // far
  EXPECT_GT(lowest, -2.3 - 0.0202);
  // about that place, over twenty swings
  EXPECT_NEAR(sum, -2.31, 0.001);
}

TEST(HeavyLoad, aWinchLiftsItsLoad) {
  BulletWorld bullet(-10.0);
  SoftBodySystem system(*bullet.world);
  btRigidBody* box = bullet.addBox(vec(0.1, 0.1, 0.1), 50.0, vec(0, -3, 0));
  SpringSettings cable;
  cable.stiffness = 1e5;
  cable.damping = 2e3;
  cable.action = SpringAction::ExtensionOnly;
  cable.restLength = 3.0;
  SpringConstraint* winch = *system.addSpring({nullptr}, {box}, cable);
  double before = 0.0;
  for (int i = 0; i < 240; ++i) {
    cable.restLength = 3.0 - 0.5 * i / 60.0;
    ASSERT_TRUE(system.changeSpring(winch, cable));
    bullet.tick();
    if (i == 179) before = double(box->getCenterOfMassPosition().y());
  }
  const double height = double(box->getCenterOfMassPosition().y());
  // at 0.5 m/s for 4 s; 500 N stretch the cable by 5 mm, and a tick's pull is 8 mm
  EXPECT_NEAR(height, -3.0 + 0.5 * 239 / 60.0 - 0.005, 0.01);
  EXPECT_NEAR(height - before, 0.5, 1e-3);
}

}  // namespace
}  // namespace limber
