// SPDX-License-Identifier: Zlib
// A flat floor acts as one plane, no matter how it is cut into pieces.
#include "bullet/soft_body_data.h"
#include "support/soft_world.h"
#include "support/tiled_floors.h"

#include <cmath>

namespace limber::test {
namespace {

using Eigen::Vector3d;

class TiledFloor : public testing::TestWithParam<FloorKind> {};

/// Returns settings of a body that lies on the slope and moves down along it at `speed` (m/s).
SoftBodySettings onFloor(double height, double slope, double speed) {
  SoftBodySettings s = testedSettings();
  const Eigen::AngleAxisd rotation(-slope, Vector3d::UnitZ());
  s.position = rotation * Vector3d(0.013, height, 0.021);
  s.rotation = rotation;
  s.linearVelocity = rotation * Vector3d(speed, 0, 0);
  s.friction = 1.0;
  s.pointRadius = kRadius;
  return s;
}

/// Returns the distance (m) between the body and the floor; negative for a body that penetrates it.
double gapToFloor(const SoftBody& body, double slope) {
  const Vector3d up(std::sin(slope), std::cos(slope), 0);
  double height = 1e9;
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) height = std::min(height, up.dot(body.position(i)));
  return height - kRadius;
}

/// Returns the velocity (m/s) of the centre of mass (all masses are equal).
Vector3d velocityOf(const SoftBody& body) {
  Vector3d sum = Vector3d::Zero();
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) sum += body.velocity(i);
  return sum / body.pointCount();
}

TEST_P(TiledFloor, motionOnTilesIsThatOnOnePlane) {
  for (const double stiffness : {1e3, 1e5}) {
    SCOPED_TRACE(stiffness);
    SoftWorld bullet;
    addTiledFloor(bullet, GetParam(), 0.0);
    SoftBodySettings s = onFloor(0.5 + kRadius, 0.0, 3.0);
    s.extensionStiffness = s.compressionStiffness = stiffness;
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
    double highest = 0.0;
    for (int i = 0; i < 30; ++i) {
      bullet.tick();
      highest = std::max(highest, gapToFloor(*cube, 0.0));
    }
    // single precision makes steps of 1e-7 m between tiles, which may cost at most 1e-3 of the speed
    EXPECT_NEAR(velocityOf(*cube).x(), 3.0, 3e-3);
    EXPECT_LT(highest, 1e-3) << "it does not hop";
  }
}

/// Applications rarely place a body exactly on the terrain: a float of a metre is rounded to some 1e-7 m.
TEST_P(TiledFloor, whatIsPutIntoItALittleIsPushedOut) {
  for (const double depth : {-1e-9, 0.0, 1e-9, 1e-4, 0.4 * kRadius}) {
    SCOPED_TRACE(depth);
    SoftWorld bullet;
    addTiledFloor(bullet, GetParam(), 0.5);
    SoftBodySettings s = onFloor(0.5 - depth, 0.0, 0.0);
    s.position.x() = 0.5;
    setSprings(s, 1e4, 5.0);
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
    bullet.simulate(1.0);
    EXPECT_NEAR(lowest(*cube), kRadius, 1e-4);
    EXPECT_NEAR(cube->centerOfMass().y(), 0.5 + kRadius, 5e-3) << "but for its sag";
  }
}

/// Bullet finds a tile when a point comes onto it, and would slow the point down at the rounded edge.
TEST_P(TiledFloor, pointsInTheWorldSlideOverItBesideOthers) {
  SoftWorld bullet;
  addTiledFloor(bullet, GetParam(), 0.0);
  // 0.1 m per tick: then corners are 13 mm past the edges of tiles, which are rounded by 40 mm
  SoftBodySettings s = onFloor(0.5 + kRadius, 0.0, 1.5);
  s.collision = Collision::Points;
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
  s.position.z() += 1.1;
  ASSERT_TRUE(bullet.system.createBody(closedCubeNetwork(), s));
  bullet.addBox(vec(0.2, 0.2, 0.2), 0.1, vec(0.013, 0.6, -0.74))->setLinearVelocity(vec(1.5, 0, 0));
  for (int i = 0; i < 10; ++i) bullet.tick(1.0 / 15.0);
  EXPECT_NEAR(velocityOf(*cube).x(), 1.5, 1.5e-3);
}

/// The contacts that push the points and those with the floor are solved together.
TEST_P(TiledFloor, pointsInTheWorldAreNotPushedThroughIt) {
  SoftWorld bullet;
  addTiledFloor(bullet, GetParam(), 0.0);
  SoftBodySettings s = onFloor(kRadius, 0.0, 0.0);
  s.collision = Collision::Points;
  SoftBody* below = bullet.addSoft(pairNetwork(), s);
  s.position.y() = 0.3;
  s.linearVelocity.y() = -10.0;
  ASSERT_TRUE(bullet.system.createBody(pairNetwork(), s));
  for (int i = 0; i < 10; ++i) {
    bullet.tick();
    EXPECT_GT(gapToFloor(*below, 0.0), -0.1 * kRadius) << i;
  }
}

TEST_P(TiledFloor, aCubeSlidesDownASlopeAgainstFriction) {
  const double slope = M_PI / 6, friction = 0.2;
  SoftWorld bullet;
  addTiledFloor(bullet, GetParam(), friction, slope);
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), onFloor(0.5 + kRadius, slope, 0.0));
  bullet.simulate(1.0);
  const double expected = kGravity * (std::sin(slope) - friction * std::cos(slope));
  const double speed = velocityOf(*cube).dot(Vector3d(std::cos(slope), -std::sin(slope), 0));
  // at first it rocks and slips a little
  EXPECT_NEAR(speed / expected, 1.0, 0.01);
}

TEST_P(TiledFloor, aRopeAndAClothSlideFreely) {
  const double slope = M_PI / 6;
  for (const SharedNetwork& network : {*buildRope(), squareCloth(7)}) {
    SoftWorld bullet;
    addTiledFloor(bullet, GetParam(), 0.0, slope);
    SoftBody* body = bullet.addSoft(network, onFloor(kRadius, slope, 0.0));
    bullet.simulate(1.0);
    const double speed = velocityOf(*body).dot(Vector3d(std::cos(slope), -std::sin(slope), 0));
    EXPECT_NEAR(speed / (kGravity * std::sin(slope)), 1.0, 3e-3);
  }
}

TEST_P(TiledFloor, mirroredAndVerySoftBodiesDoNotSinkIn) {
  for (const double mirror : {1.0, -1.0})
    for (const double stiffness : {1e3, 15.0}) {
      SCOPED_TRACE(testing::Message() << "scale " << mirror << ", " << stiffness << " N/m");
      SoftWorld bullet;
      addTiledFloor(bullet, GetParam(), 0.5);
      SoftBodySettings s = onFloor(0.8, 0.0, 0.0);
      s.scale.x() = mirror;
      s.extensionStiffness = s.compressionStiffness = stiffness;
      SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
      double deepest = 1.0;
      for (int i = 0; i < 90; ++i) {
        bullet.tick();
        deepest = std::min(deepest, lowest(*cube));
      }
      // an impact at 2.4 m/s penetrates by up to a tenth of the radius for a substep
      EXPECT_GT(deepest, 0.9 * kRadius);
    }
}

/// A cube slides from each mesh to the next.
TEST(SurfaceTiles, aBodyCrossesMeshesAndForgetsThem) {
  SoftWorld bullet;
  for (int i = 0; i < 12; ++i) {
    auto mesh = std::make_unique<btTriangleMesh>();
    const double x = -1.0 + 0.5 * i;
    mesh->addTriangle(vec(x, 0, -2), vec(x, 0, 2), vec(x + 0.5, 0, -2));
    mesh->addTriangle(vec(x + 0.5, 0, -2), vec(x, 0, 2), vec(x + 0.5, 0, 2));
    bullet.add(std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true), 0, btVector3(0, 0, 0))
        ->setFriction(0);
    bullet.meshes.push_back(std::move(mesh));
  }
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), onFloor(0.5 + kRadius, 0.0, 5.0));
  bullet.simulate(0.8);
  EXPECT_NEAR(velocityOf(*cube).x(), 5.0, 5e-3);
  // of 12 meshes on its path; four or five are near at a time
  EXPECT_LE(dataOf(*cube).surface.searches.size(), 6u);
}

INSTANTIATE_TEST_SUITE_P(Kinds, TiledFloor, testing::ValuesIn(kFloorKinds),
                         [](const auto& kind) { return nameOf(kind.param); });

}  // namespace
}  // namespace limber::test
