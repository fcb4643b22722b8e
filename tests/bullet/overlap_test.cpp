// SPDX-License-Identifier: Zlib
// Bodies that are placed, or grow, into others get out of them.
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <algorithm>

namespace limber::test {
namespace {

using Eigen::Vector3d;

/// The size of a cube with its radii, 0.51 m, less what its weight takes and what is left of the overlap: up
/// to 3 cm of cubes exactly on top of each other, whose corners are neither inside nor outside.
constexpr double kLeast = 0.465;

struct OverlapTest : testing::Test {
  void SetUp() override {
    if (!kSurface) GTEST_SKIP() << "needs Collision::Surface";
    bullet.addPlaneFloor();
  }

  SoftBody* addCube(double x, double y, double z = 0.0) {
    SoftBodySettings s;
    s.position = {x, y, z};
    s.scale *= 0.5;
    setSprings(s, 2000.0, 2.0);
    return *system.createBody(bracedNetwork(small_meshes::cube(2)), s);
  }

  /// Lets the bodies separate. They are pushed apart slowly.
  void separate(double seconds, double tick) {
    for (int i = 0; i < static_cast<int>(seconds / tick); ++i) {
      bullet.tick(tick);
      for (std::size_t b = 0; b < system.bodyCount(); ++b)
        for (std::uint32_t p = 0; p < system.body(b)->pointCount(); ++p)
          ASSERT_LT(system.body(b)->velocity(p).norm(), 1.5) << i;
    }
  }

  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};
};

double between(const SoftBody& a, const SoftBody& b, int axis) {
  return b.centerOfMass()[axis] - a.centerOfMass()[axis];
}

TEST_F(OverlapTest, onTopOfAnotherItRises) {
  for (const double depth : {0.02, 0.1, 0.2})
    for (const double aside : {0.0, 0.03})
      for (const double tick : {1.0 / 120.0, 1.0 / 30.0}) {
        if (tick < 1.0 / 30.0 && depth != 0.1) continue;  // it takes four times as long
        SoftBody *below = addCube(0, 0.26), *above = addCube(aside, 0.76 - depth, aside);
        separate(2.5, tick);
        EXPECT_GT(between(*below, *above, 1), kLeast) << tick << ' ' << depth << ' ' << aside;
        ASSERT_TRUE(system.destroyBody(below) && system.destroyBody(above));
      }
}

TEST_F(OverlapTest, besideAnotherItGetsAside) {
  for (const double tick : {1.0 / 120.0, 1.0 / 30.0})
    for (const double depth : {0.05, 0.2}) {
      SoftBody *left = addCube(0, 0.26), *right = addCube(0.5 - depth, 0.26, 0.03);
      separate(2.0, tick);
      EXPECT_GT(between(*left, *right, 0), kLeast) << tick << ' ' << depth;
      ASSERT_TRUE(system.destroyBody(left) && system.destroyBody(right));
    }
}

/// Two cubes side by side that overlapped by 3 cm: the points of their lower rims, which are a little inside
/// the other, must not get out through the bottoms that bulge there.
TEST_F(OverlapTest, besideAnotherAlikeItGainsNoEnergy) {
  Material material;
  material.youngsModulus = 5e4;
  material.poissonRatio = 0.4;
  material.density = 300.0;
  material.dampingTime = 0.03;
  const SharedNetwork cube = solidNetwork(small_meshes::cube(), 125);
  SoftBodySettings s = *withMaterial(*cube, material);
  std::vector<const SoftBody*> bodies;
  for (const double x : {0.0, 0.97}) {
    s.position = {x, 0.52, 0};
    bodies.push_back(*system.createBody(cube, s));
  }
  const auto energy = [&] {
    double sum = 0.0;
    for (const SoftBody* body : bodies) sum += energyOf(*body, kGravity);
    return sum;
  };
  constexpr double kFine = 1.0 / 240.0;
  bullet.simulate(2.0, kFine);
  double before = energy();
  for (int i = 0; i < 360; ++i) {
    bullet.tick(kFine);
    const double now = energy();
    ASSERT_LT(now - before, 0.2) << i;  // J, of 2900
    before = now;
  }
}

/// No point of a copy at the same place is inside or outside the other, and no direction leads out.
TEST_F(OverlapTest, aCopyAtTheSamePlaceGetsOut) {
  for (const double tick : {1.0 / 60.0, 1.0 / 30.0}) {
    SoftBody* body = addCube(0, 0.26);
    SoftBody* copy = *system.clone(body, btTransform::getIdentity());
    separate(2.5, tick);
    EXPECT_GT((copy->centerOfMass() - body->centerOfMass()).cwiseAbs().maxCoeff(), kLeast) << tick;
    ASSERT_TRUE(system.destroyBody(body) && system.destroyBody(copy));
  }
}

TEST_F(OverlapTest, ofADynamicBoxItGetsOut) {
  for (const double tick : {1.0 / 120.0, 1.0 / 30.0}) {
    btRigidBody* box = bullet.addBox(vec(0.25, 0.25, 0.25), 1.0, vec(0, 0.25, 0));
    SoftBody* cube = addCube(0.3, 0.26, 0.03);
    separate(2.0, tick);
    EXPECT_GT(cube->centerOfMass().x() - double(box->getWorldTransform().getOrigin().x()), kLeast) << tick;
    ASSERT_TRUE(system.destroyBody(cube));
    bullet.world->removeRigidBody(box);
  }
}

TEST_F(OverlapTest, ofAStaticSolidItGetsOut) {
  const auto shapes = [] {
    std::vector<std::unique_ptr<btCollisionShape>> made;
    made.push_back(std::make_unique<btBoxShape>(vec(0.25, 0.25, 0.25)));
    made.push_back(std::make_unique<btCylinderShape>(vec(0.25, 0.25, 0.25)));
    made.push_back(std::make_unique<btCapsuleShape>(btScalar(0.25), btScalar(0.5)));
    return made;
  };
  for (const double tick : {1.0 / 120.0, 1.0 / 30.0})
    for (std::unique_ptr<btCollisionShape>& shape : shapes()) {
      const char* name = shape->getName();
      btRigidBody* solid = bullet.add(std::move(shape), 0, vec(0, 0.25, 0));
      SoftBody* cube = addCube(0.35, 0.26, 0.03);
      separate(2.0, tick);
      EXPECT_GT(cube->centerOfMass().x(), kLeast) << name << ' ' << tick;
      ASSERT_TRUE(system.destroyBody(cube));
      bullet.world->removeRigidBody(solid);
    }
}

/// The solid passes right through the body, which has points on both sides of it, or is inside, where the
/// body has no points.
TEST_F(OverlapTest, ofAStaticSolidThatPassesThroughItItGetsOut) {
  const auto expectOut = [&](std::unique_ptr<btCollisionShape> shape, const Vector3d& half,
                             const Vector3d& at) {
    btRigidBody* solid = bullet.add(std::move(shape), 0.0, vec(0, 2, 0));
    SoftBody* body = addCube(at.x(), 2.0 + at.y());
    bullet.simulate(2.0);
    const Eigen::AlignedBox3d inside(Vector3d(0, 2, 0) - 0.9 * half, Vector3d(0, 2, 0) + 0.9 * half);
    double least = HUGE_VAL, largest = -HUGE_VAL;
    for (std::uint32_t i = 0; i < body->pointCount(); ++i) {
      EXPECT_FALSE(inside.contains(body->position(i)));
      least = std::min(least, body->position(i).y()), largest = std::max(largest, body->position(i).y());
    }
    EXPECT_TRUE(least > 2.0 + 0.9 * half.y() || largest < 2.0 - 0.9 * half.y()) << least << ' ' << largest;
    ASSERT_TRUE(system.destroyBody(body));
    bullet.world->removeRigidBody(solid);
  };
  for (const double thick : {0.02, 0.06, 0.2})
    for (const double y : {-0.15, 0.0, 0.13}) {
      SCOPED_TRACE(testing::Message() << "shelf " << thick << " at " << y);
      const Vector3d half(1.0, 0.5 * thick, 1.0);
      expectOut(std::make_unique<btBoxShape>(vec(half.x(), half.y(), half.z())), half, {0.3, y, 0.0});
    }
  const Vector3d half = Vector3d::Constant(0.08);
  for (const double y : {0.03, -0.03})
    expectOut(std::make_unique<btSphereShape>(btScalar(0.1)), half, {0.02, y, 0.0});
}

/// The nearest ways out of the cube's points lead to all sides of the box.
TEST_F(OverlapTest, ofAStaticBoxThatIsPutOverItItGetsOut) {
  enum class Way { Added, Moved, Scaled, Kinematic };
  for (const Way way : {Way::Added, Way::Moved, Way::Scaled, Way::Kinematic}) {
    SoftBody* cube = addCube(0, 0.26);
    separate(0.5, 1.0 / 60.0);
    auto shape = std::make_unique<btBoxShape>(vec(1, 1, 1));
    btBoxShape& size = *shape;
    if (way != Way::Scaled) size.setLocalScaling(vec(1, 0.65, 1));
    const btVector3 over = vec(0, 0.05, 0), below = vec(0, -5, 0);  // its top is at 0.7 m
    btRigidBody* box =
        bullet.add(std::move(shape), 0, way == Way::Added || way == Way::Kinematic ? over : below);
    if (way == Way::Kinematic) box->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    if (way == Way::Scaled) size.setLocalScaling(vec(1, 0.65, 1));
    if (way == Way::Moved || way == Way::Scaled) {
      box->setWorldTransform(btTransform(btQuaternion::getIdentity(), over));
      bullet.world->updateSingleAabb(box);
    }
    separate(4.0, 1.0 / 60.0);
    EXPECT_NEAR(cube->centerOfMass().y(), 0.7 + 0.255, 0.02) << static_cast<int>(way);
    ASSERT_TRUE(system.destroyBody(cube));
    bullet.world->removeRigidBody(box);
  }
}

/// Without gravity it is pushed out by a tenth of its radius per tick, slower than what may sleep.
TEST_F(OverlapTest, weightlessItDoesNotSleepInside) {
  bullet.world->setGravity(vec(0, 0, 0));
  bullet.addBox(vec(0.5, 0.5, 0.5), 0.0, vec(0, 2, 0));
  SoftBody* cube = addCube(0, 2.65, 0.03);
  bullet.simulate(5.0);
  EXPECT_GT(lowest(*cube), 2.495);
}

TEST_F(OverlapTest, placedOrGrownItGetsOut) {
  SoftBody *below = addCube(0, 0.26), *above = addCube(0, 0.78);
  separate(2.0, 1.0 / 60.0);
  btTransform lower = above->transform();
  lower.getOrigin() -= vec(0, 0.15, 0);
  ASSERT_TRUE(above->setTransform(lower));
  separate(2.0, 1.0 / 60.0);
  EXPECT_GT(between(*below, *above, 1), kLeast) << "placed";
  SoftBodySettings s = below->settings();
  s.scale *= 1.4;
  ASSERT_TRUE(below->change(s));
  separate(2.0, 1.0 / 60.0);
  EXPECT_GT(between(*below, *above, 1), 1.2 * kLeast) << "grown";
}

/// A body that is attached is where it is meant to be: a part of it is inside what holds it.
TEST_F(OverlapTest, attachedItStays) {
  bullet.world->setGravity(vec(0, 0, 0));
  for (const double mass : {0.0, 1.0}) {
    btRigidBody* box = bullet.addBox(vec(0.25, 0.25, 0.25), mass, vec(0, 2, 0));
    SoftBody* cube = addCube(0.35, 2, 0.03);
    int attached = 0;
    for (std::uint32_t i = 0; i < cube->pointCount(); ++i)
      if (cube->position(i).x() < 0.2) attached += system.attach(cube, i, *box) ? 1 : 0;
    ASSERT_EQ(attached, 9);
    separate(2.0, 1.0 / 60.0);
    EXPECT_NEAR(cube->centerOfMass().x() - double(box->getWorldTransform().getOrigin().x()), 0.35, 0.01)
        << mass;
    ASSERT_TRUE(system.destroyBody(cube));
    bullet.world->removeRigidBody(box);
  }
}

/// What is inside another as a whole stays there.
TEST_F(OverlapTest, insideAsAWholeIsNoOverlap) {
  bullet.world->setGravity(vec(0, 0, 0));
  SoftBody* outer = addCube(0, 1.0);
  SoftBodySettings s = outer->settings();
  s.scale *= 0.2;
  s.position = {0.1, 1.0, 0.0};
  SoftBody* inner = *system.createBody(outer->sharedNetwork(), s);
  separate(1.0, 1.0 / 60.0);
  EXPECT_NEAR(between(*outer, *inner, 0), 0.1, 1e-6);
}

TEST_F(OverlapTest, whatIsPutIntoABodyIsAlsoPutThereAfterARestoration) {
  bullet.world->setGravity(btVector3(0, 0, 0));
  btRigidBody* box = bullet.addBox(vec(0.3, 0.3, 0.3), 0.0, vec(5, 2, 0));
  SoftBody* cube = addCube(0, 2);
  const auto putAt = [&](double x) {
    box->getWorldTransform().setOrigin(vec(x, 2, 0));
    bullet.world->updateSingleAabb(box);
  };
  putAt(0.6);  // near, but apart
  for (int i = 0; i < 3; ++i) bullet.tick();
  const std::vector<std::uint8_t> saved = system.saveState();
  const auto run = [&] {
    putAt(0.3);
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 20; ++i) bullet.tick(), hashes.push_back(cube->stateHash());
    return hashes;
  };
  const std::vector<std::uint64_t> first = run();
  EXPECT_LT(cube->centerOfMass().x(), -0.01) << "it is pushed out";
  ASSERT_TRUE(system.restoreState(saved));
  EXPECT_EQ(run(), first);
}

TEST_F(OverlapTest, goesOnAlikeFromASavedState) {
  addCube(0, 0.26), addCube(0.03, 0.6, 0.02);
  separate(0.3, 1.0 / 60.0);
  const std::vector<std::uint8_t> state = system.saveState();
  const auto hashesAfter = [&] {
    separate(0.5, 1.0 / 60.0);
    return std::make_pair(system.body(0)->stateHash(), system.body(1)->stateHash());
  };
  const auto once = hashesAfter();
  ASSERT_TRUE(system.restoreState(state));
  EXPECT_EQ(hashesAfter(), once);
}

}  // namespace
}  // namespace limber::test
