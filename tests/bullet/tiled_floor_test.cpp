// SPDX-License-Identifier: Zlib
// A flat floor is one plane, however it is cut into pieces.
#include "bullet/soft_body_data.h"
#include "support/bullet_measures.h"
#include "support/bullet_world.h"
#include "support/constants.h"
#include "support/networks.h"
#include "support/tested_way.h"
#include "support/tiled_floors.h"

#include <limber/soft_body_system.h>

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;
using test::BulletWorld;
using test::FloorKind;
using test::kGravity;
using test::kRadius;
using test::lowest;

class TiledFloor : public testing::TestWithParam<FloorKind> {};

/// At rest on the floor, turned with it, moving down along it with `speed`.
SoftBodySettings onFloor(double height, double slope, double speed) {
  SoftBodySettings s = test::testedSettings();
  const Eigen::AngleAxisd turn(-slope, Vector3d::UnitZ());
  s.position = turn * Vector3d(0.013, height, 0.021);
  s.rotation = turn;
  s.linearVelocity = turn * Vector3d(speed, 0, 0);
  s.friction = 1.0;
  s.pointRadius = kRadius;
  return s;
}

/// m, of the point that is farthest from the floor or deepest in it.
double highestBottom(const SoftBody& body, double slope) {
  const Vector3d up(std::sin(slope), std::cos(slope), 0);
  double height = 1e9;
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) height = std::min(height, up.dot(body.position(i)));
  return height - kRadius;
}

/// m/s, of the centre of mass (all masses are equal).
Vector3d velocityOf(const SoftBody& body) {
  Vector3d sum = Vector3d::Zero();
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) sum += body.velocity(i);
  return sum / body.pointCount();
}

TEST_P(TiledFloor, motionOnTilesIsThatOnOnePlane) {
  for (const double stiffness : {1e3, 1e5}) {
    SCOPED_TRACE(stiffness);
    BulletWorld bullet;
    test::addTiledFloor(bullet, GetParam(), 0.0);
    SoftBodySystem system(*bullet.world);
    SoftBodySettings s = onFloor(0.5 + kRadius, 0.0, 3.0);
    s.extensionStiffness = s.compressionStiffness = stiffness;
    SoftBody* cube = *system.createBody(test::closedCubeNetwork(), s);
    double highest = 0.0;
    for (int i = 0; i < 30; ++i) {
      bullet.tick();
      highest = std::max(highest, highestBottom(*cube, 0.0));
    }
    // single precision rounds the height of one tile beside the next to 1e-7 m: no more than 1e-3 of the
    // speed
    EXPECT_NEAR(velocityOf(*cube).x(), 3.0, 3e-3);
    EXPECT_LT(highest, 1e-3) << "it does not hop";
  }
}

/// What is put on terrain is rarely put just beside it, and a float of a metre is some 1e-7 m.
TEST_P(TiledFloor, whatIsPutIntoItALittleIsPushedOut) {
  for (const double depth : {-1e-9, 0.0, 1e-9, 1e-4, 0.4 * kRadius}) {
    SCOPED_TRACE(depth);
    BulletWorld bullet;
    test::addTiledFloor(bullet, GetParam(), 0.5);
    SoftBodySystem system(*bullet.world);
    SoftBodySettings s = onFloor(0.5 - depth, 0.0, 0.0);
    s.position.x() = 0.5;
    s.extensionStiffness = s.compressionStiffness = 1e4;
    s.damping = 5.0;
    SoftBody* cube = *system.createBody(test::closedCubeNetwork(), s);
    bullet.simulate(1.0);
    EXPECT_NEAR(lowest(*cube), kRadius, 1e-4);
    EXPECT_NEAR(cube->centerOfMass().y(), 0.5 + kRadius, 5e-3) << "but for its sag";
  }
}

/// Bullet meets a tile for the first time when a point gets onto it, and would brake that at the rounded
/// edge.
TEST_P(TiledFloor, pointsInTheWorldSlideOverItBesideOthers) {
  BulletWorld bullet;
  test::addTiledFloor(bullet, GetParam(), 0.0);
  SoftBodySystem system(*bullet.world);
  // 0.1 m in a tick: it then has corners 13 mm past the edges of tiles, which are rounded by 40 mm
  SoftBodySettings s = onFloor(0.5 + kRadius, 0.0, 1.5);
  s.collision = Collision::Points;
  SoftBody* cube = *system.createBody(test::closedCubeNetwork(), s);
  s.position.z() += 1.1;
  ASSERT_TRUE(system.createBody(test::closedCubeNetwork(), s));
  bullet.addBox(test::vec(0.2, 0.2, 0.2), 0.1, test::vec(0.013, 0.6, -0.74))
      ->setLinearVelocity(test::vec(1.5, 0, 0));
  for (int i = 0; i < 10; ++i) bullet.tick(1.0 / 15.0);
  EXPECT_NEAR(velocityOf(*cube).x(), 1.5, 1.5e-3);
}

/// What pushes them is solved together with what bears them.
TEST_P(TiledFloor, pointsInTheWorldAreNotPushedThroughIt) {
  BulletWorld bullet;
  test::addTiledFloor(bullet, GetParam(), 0.0);
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = onFloor(kRadius, 0.0, 0.0);
  s.collision = Collision::Points;
  SoftBody* below = *system.createBody(test::pairNetwork(), s);
  s.position.y() = 0.3;
  s.linearVelocity.y() = -10.0;
  ASSERT_TRUE(system.createBody(test::pairNetwork(), s));
  for (int i = 0; i < 10; ++i) {
    bullet.tick();
    EXPECT_GT(highestBottom(*below, 0.0), -0.1 * kRadius) << i;
  }
}

TEST_P(TiledFloor, aCubeSlidesDownASlopeAgainstFriction) {
  const double slope = M_PI / 6, friction = 0.2;
  BulletWorld bullet;
  test::addTiledFloor(bullet, GetParam(), friction, slope);
  SoftBodySystem system(*bullet.world);
  SoftBody* cube = *system.createBody(test::closedCubeNetwork(), onFloor(0.5 + kRadius, slope, 0.0));
  bullet.simulate(1.0);
  const double expected = kGravity * (std::sin(slope) - friction * std::cos(slope));
  const double speed = velocityOf(*cube).dot(Vector3d(std::cos(slope), -std::sin(slope), 0));
  // while it settles it rocks, and slips a little
  EXPECT_NEAR(speed / expected, 1.0, 0.01);
}

TEST_P(TiledFloor, aRopeAndAClothSlideFreely) {
  const double slope = M_PI / 6;
  RopeSettings rope;
  ClothSettings cloth;
  cloth.width = cloth.depth = 1.0;
  cloth.columns = cloth.rows = 7;
  for (const SharedNetwork& network : {*buildRope(rope), *buildCloth(cloth)}) {
    BulletWorld bullet;
    test::addTiledFloor(bullet, GetParam(), 0.0, slope);
    SoftBodySystem system(*bullet.world);
    SoftBody* body = *system.createBody(network, onFloor(kRadius, slope, 0.0));
    bullet.simulate(1.0);
    const double speed = velocityOf(*body).dot(Vector3d(std::cos(slope), -std::sin(slope), 0));
    EXPECT_NEAR(speed / (kGravity * std::sin(slope)), 1.0, 3e-3);
  }
}

TEST_P(TiledFloor, mirroredAndVerySoftBodiesDoNotSinkIn) {
  for (const double mirror : {1.0, -1.0})
    for (const double stiffness : {1e3, 15.0}) {
      SCOPED_TRACE(testing::Message() << "scale " << mirror << ", " << stiffness << " N/m");
      BulletWorld bullet;
      test::addTiledFloor(bullet, GetParam(), 0.5);
      SoftBodySystem system(*bullet.world);
      SoftBodySettings s = onFloor(0.8, 0.0, 0.0);
      s.scale.x() = mirror;
      s.extensionStiffness = s.compressionStiffness = stiffness;
      SoftBody* cube = *system.createBody(test::closedCubeNetwork(), s);
      double deepest = 1.0;
      for (int i = 0; i < 90; ++i) {
        bullet.tick();
        deepest = std::min(deepest, lowest(*cube));
      }
      // what hits the floor at 2.4 m/s has got up to a tenth of the radius into it for a substep
      EXPECT_GT(deepest, 0.9 * kRadius);
    }
}

/// The cube, over and over from one mesh to the next.
TEST(SurfaceTiles, aBodyCrossesMeshesAndForgetsThem) {
  BulletWorld bullet;
  for (int i = 0; i < 12; ++i) {
    auto mesh = std::make_unique<btTriangleMesh>();
    const double x = -1.0 + 0.5 * i;
    mesh->addTriangle(test::vec(x, 0, -2), test::vec(x, 0, 2), test::vec(x + 0.5, 0, -2));
    mesh->addTriangle(test::vec(x + 0.5, 0, -2), test::vec(x, 0, 2), test::vec(x + 0.5, 0, 2));
    bullet.add(std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true), 0, btVector3(0, 0, 0))
        ->setFriction(0);
    bullet.meshes.push_back(std::move(mesh));
  }
  SoftBodySystem system(*bullet.world);
  SoftBody* cube = *system.createBody(test::closedCubeNetwork(), onFloor(0.5 + kRadius, 0.0, 5.0));
  bullet.simulate(0.8);
  EXPECT_NEAR(velocityOf(*cube).x(), 5.0, 5e-3);
  // of 12 that it has come near; it reaches four or five at a time
  EXPECT_LE(dataOf(*cube).surface.patches.size(), 6u);
}

INSTANTIATE_TEST_SUITE_P(Kinds, TiledFloor, testing::ValuesIn(test::kFloorKinds),
                         [](const auto& kind) { return test::nameOf(kind.param); });

}  // namespace
}  // namespace limber
