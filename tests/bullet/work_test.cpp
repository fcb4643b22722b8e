// SPDX-License-Identifier: Zlib
// The work of a tick depends on nearby objects, not on the size of the world. The tests count work
// and allocations; they do not measure time.
#include "support/allocation_counter.h"
#include "support/soft_world.h"

namespace limber::test {
namespace {

SoftBodySettings cubeSettingsAt(double x, double y) {
  SoftBodySettings s = settingsAt({x, y, 0});
  s.pointRadius = kRadius;
  return s;
}

constexpr double kTile = 0.25;  // m

/// The structure of the compound of a floor's boxes.
enum class Boxes { InTree, InList, InRowsOfTrees };

btTransform at(double x, double y, double z) {
  btTransform pose = btTransform::getIdentity();
  pose.setOrigin(vec(x, y, z));
  return pose;
}

/// Returns a compound of side x side boxes with their tops at y = 0, centred at the origin.
std::unique_ptr<btCompoundShape> makeTiles(BulletWorld& bullet, int side, Boxes arrangement) {
  bullet.shapes.push_back(std::make_unique<btBoxShape>(vec(kTile / 2, 0.05, kTile / 2)));
  btCollisionShape* tile = bullet.shapes.back().get();
  auto tiles = std::make_unique<btCompoundShape>(arrangement != Boxes::InList);
  const double first = -0.5 * (side - 1) * kTile;
  for (int i = 0; i < side; ++i) {
    btCompoundShape* row = tiles.get();
    if (arrangement == Boxes::InRowsOfTrees) {
      bullet.shapes.push_back(std::make_unique<btCompoundShape>());
      row = static_cast<btCompoundShape*>(bullet.shapes.back().get());
    }
    for (int j = 0; j < side; ++j) row->addChildShape(at(first + kTile * i, -0.05, first + kTile * j), tile);
    if (row != tiles.get()) tiles->addChildShape(btTransform::getIdentity(), row);
  }
  return tiles;
}

/// The number of tiles that a cube of a metre can touch, including a margin of a quarter of a metre, in which
/// the search for deep penetrations takes place.
constexpr std::size_t kNear = 8 * 8;

TEST(SurfaceWork, ofACompoundThePartsThatAreNearAreLookedAt) {
  for (const Boxes arrangement : {Boxes::InTree, Boxes::InList, Boxes::InRowsOfTrees}) {
    SCOPED_TRACE(static_cast<int>(arrangement));
    SoftWorld bullet;
    bullet.add(makeTiles(bullet, 100, arrangement), 0, vec(0, 0, 0));
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), cubeSettingsAt(0.06, 0.5 + kRadius));
    for (int i = 0; i < 5; ++i) bullet.tick();
    EXPECT_GE(bullet.system.profile().rigidParts, 16u) << "the tiles under it";
    EXPECT_LE(bullet.system.profile().rigidParts, kNear);
    EXPECT_GT(lowest(*cube), 0.5 * kRadius) << "it lies on them";
  }
}

TEST(SurfaceWork, bodiesShareTheParts) {
  SoftWorld bullet;
  bullet.add(makeTiles(bullet, 20, Boxes::InTree), 0, vec(0, 0, 0));
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(
        bullet.system.createBody(closedCubeNetwork(), cubeSettingsAt(0.06, 0.5 + kRadius + 1.01 * i)));
  bullet.tick();
  EXPECT_LE(bullet.system.profile().rigidParts, kNear);
}

TEST(SurfaceWork, ofACompoundThatMovesThePartsThatAreNearAreLookedAt) {
  SoftWorld bullet(0.0);
  btRigidBody* plate = bullet.add(makeTiles(bullet, 40, Boxes::InTree), 100, vec(0, 0, 0));
  plate->setActivationState(DISABLE_DEACTIVATION);
  plate->setLinearVelocity(vec(0, 3, 0));
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), cubeSettingsAt(0.06, 0.6));
  for (int i = 0; i < 20; ++i) {
    bullet.tick();
    EXPECT_LE(bullet.system.profile().rigidParts, kNear);
  }
  const double top = heightOf(*plate);
  EXPECT_GT(top, 0.4) << "it has reached the cube";
  EXPECT_GT(lowest(*cube), top) << "and pushes it";
}

/// Returns the position of a free cube half a second after a fast, rotating plate has hit it.
Eigen::Vector3d afterBlowOf(bool compound) {
  SoftWorld bullet(0.0);
  auto box = std::make_unique<btBoxShape>(vec(1.0, 0.1, 0.3));
  btVector3 inertia;
  box->calculateLocalInertia(2, inertia);
  std::unique_ptr<btCollisionShape> shape = std::move(box);
  if (compound) {
    auto parent = std::make_unique<btCompoundShape>();
    parent->addChildShape(btTransform::getIdentity(), shape.get());
    bullet.shapes.push_back(std::move(shape));
    shape = std::move(parent);
  }
  btRigidBody* plate = bullet.add(std::move(shape), 2, vec(0.2, -1.2, 0.1));
  plate->setMassProps(2, inertia);
  plate->updateInertiaTensor();
  plate->setLinearVelocity(vec(0, 12, 0));
  plate->setAngularVelocity(vec(0, 0, 12));
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), cubeSettingsAt(0, 0));
  for (int i = 0; i < 30; ++i) bullet.tick();
  return cube->centerOfMass();
}

TEST(SurfaceWork, whatComesFastAndTurningIsNear) {
  const Eigen::Vector3d alone = afterBlowOf(false), inCompound = afterBlowOf(true);
  EXPECT_GT(alone.norm(), 0.5) << "it was hit";
  // the same values within the rounding of a product of two transforms
  EXPECT_LT((alone - inCompound).norm(), 1e-4);
}

/// Returns the substeps in a second of a carpet on a turntable.
std::size_t substepsOnTurntable(double turn) {
  SoftWorld bullet(-10.0);
  btRigidBody* slab = bullet.addAwakeBox(vec(0.5, 0.1, 0.5), 5.0, vec(0, -0.1, 0));
  slab->setDamping(0, 0);
  btHingeConstraint axle(*slab, vec(0, 0, 0), vec(0, 1, 0));
  bullet.world->addConstraint(&axle, true);
  SoftBodySettings s = settingsAt({0, 0.01, 0});
  s.sleepingSpeed = 0.0;
  s.extensionStiffness = s.compressionStiffness = 300.0;
  SoftBody* carpet = bullet.addSoft(squareCloth(8, 0.8), s);
  slab->setAngularVelocity(vec(0, turn, 0));
  carpet->setVelocity(vec(0, 0, 0), vec(0, turn, 0));
  std::size_t substeps = 0;
  for (int i = 0; i < 60; ++i) {
    bullet.tick();
    substeps += bullet.system.profile().substeps;
  }
  EXPECT_NEAR(double(slab->getAngularVelocity().y()), turn, 0.01 * turn + 1e-6) << "angular momentum is kept";
  bullet.world->removeConstraint(&axle);
  return substeps;
}

TEST(SurfaceWork, whatTurnsTogetherIsLikeWhatRests) {
  EXPECT_LE(substepsOnTurntable(5.0), substepsOnTurntable(0.0));
}

// --- memory ------------------------------------------------------------------------------------------------

TEST(Allocation, aTickAllocatesNothingAfterWarmUp) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  const SharedNetwork open = cubeNetwork(), closed = closedCubeNetwork();
  for (int i = 0; i < 12; ++i) {
    SoftBody* body = bullet.addSoft(i < 8 ? open : closed, settingsAt({1.5 * i, 1.0, 0}));
    body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  }
  btRigidBody* box = bullet.addBox(vec(0.2, 0.2, 0.2), 1, vec(0, 3, 0));
  ASSERT_TRUE(bullet.system.addSpring({bullet.system.body(0)->point(0)}, {bullet.system.body(1)->point(0)}));
  ASSERT_TRUE(bullet.system.attach(bullet.system.body(2), 1, *box));
  bullet.simulate(8.0);  // the box rolls for some seconds; its largest number of contacts still grows
  EXPECT_EQ(allocationsIn([&] { bullet.simulate(1.0); }), 0u);
}

TEST(Allocation, theCounterCounts) {
  const AllocationCounter counter;
  const auto made = std::make_unique<int>(1);
  EXPECT_GE(counter.allocations(), 1u);
  EXPECT_EQ(*made, 1);
}

}  // namespace
}  // namespace limber::test
