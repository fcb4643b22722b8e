// SPDX-License-Identifier: Zlib
// A flat floor acts as one plane, no matter how it is cut into pieces.
#include "bullet/soft_body_data.h"
#include "support/soft_world.h"
#include "support/tiled_floors.h"
#include "support/variants.h"

#include <algorithm>
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

// --- pieces much smaller than the motion in a tick ---------------------------------------------------------

// The search for a point's contacts then covers less than its motion, and is repeated within the tick.

constexpr double kLongTick = 1.0 / 15.0, kFineCell = 0.01, kHalfFloor = 0.6;  // s, m, m

/// Adds a static mesh of small triangles through (x, height(x), z).
template <class Height>
btRigidBody* addFineMesh(BulletWorld& bullet, Height height) {
  auto mesh = std::make_unique<btTriangleMesh>();
  const int count = static_cast<int>(std::lround(2.0 * kHalfFloor / kFineCell));
  const auto corner = [&](int i, int j) {
    const double x = -kHalfFloor + i * kFineCell;
    return vec(x, height(x), -kHalfFloor + j * kFineCell);
  };
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) {
      mesh->addTriangle(corner(i, j), corner(i, j + 1), corner(i + 1, j));
      mesh->addTriangle(corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1));
    }
  auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
  bullet.meshes.push_back(std::move(mesh));
  return bullet.add(std::move(shape), 0, btVector3(0, 0, 0));
}

btRigidBody* addFineBoxes(BulletWorld& bullet) {
  auto compound = std::make_unique<btCompoundShape>();
  const int count = static_cast<int>(std::lround(2.0 * kHalfFloor / kFineCell));
  const double half = 0.5 * kFineCell;
  bullet.shapes.push_back(std::make_unique<btBoxShape>(vec(half, half, half)));
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) {
      const btVector3 center = vec((2 * i + 1) * half - kHalfFloor, -half, (2 * j + 1) * half - kHalfFloor);
      compound->addChildShape(btTransform(btQuaternion::getIdentity(), center), bullet.shapes.back().get());
    }
  return bullet.add(std::move(compound), 0, btVector3(0, 0, 0));
}

btRigidBody* addFineFloor(BulletWorld& bullet, bool boxes) {
  return boxes ? addFineBoxes(bullet) : addFineMesh(bullet, [](double) { return 0.0; });
}

/// Returns settings of a cube of 0.3 m that moves at a velocity above the floor.
SoftBodySettings smallCube(double height, const Vector3d& velocity) {
  SoftBodySettings s = testedSettings();
  s.scale = Vector3d::Constant(0.3);
  s.position = {0.0013, height, 0.0021};
  s.linearVelocity = velocity;
  s.friction = 1.0;
  s.pointRadius = 0.005;
  s.sleepingSpeed = 0.0;
  setSprings(s, 1e4, 5.0);
  return s;
}

TEST(FinePieces, aBodyLandsAndRestsAsOnAPlane) {
  for (const auto& [speed, stiffness] : variants(
           {std::pair(5.0, 1e4), std::pair(20.0, 10.0)},
           {std::pair(0.0, 1e4), std::pair(1.0, 1e4), std::pair(20.0, 1e4)}))  // a soft one has few substeps
    for (const bool boxes : {false, true}) {
      SCOPED_TRACE(testing::Message() << speed << " m/s, " << stiffness << " N/m, boxes " << boxes);
      SoftWorld fine, plane;
      addFineFloor(fine, boxes)->setFriction(0.5);
      plane.addPlaneFloor()->setFriction(0.5);
      SoftBodySettings s = smallCube(0.155 + 0.1 * speed, {0.05 * speed, -speed, 0});
      setSprings(s, stiffness, 5e-4 * stiffness);
      SoftBody *onFine = fine.addSoft(closedCubeNetwork(), s),
               *onPlane = plane.addSoft(closedCubeNetwork(), s);
      for (int i = 0; i < 7; ++i) {
        fine.tick(kLongTick);
        plane.tick(kLongTick);
        EXPECT_LT((onFine->centerOfMass() - onPlane->centerOfMass()).norm(), 1e-3) << i;
        EXPECT_GT(lowest(*onFine), 0.9 * s.pointRadius.value()) << i;
      }
    }
}

TEST(FinePieces, reportedImpulsesAreThoseThatStopTheBody) {
  for (const double restitution : {0.0, 0.8}) {
    SCOPED_TRACE(restitution);
    SoftWorld bullet;
    addFineFloor(bullet, false)->setRestitution(static_cast<btScalar>(restitution));
    SoftBodySettings s = smallCube(0.2, {0.5, -5.0, 0.0});
    s.restitution = 1.0;
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
    Vector3d impulse = Vector3d::Zero();
    for (int i = 0; i < 6; ++i) {
      bullet.tick(kLongTick);
      for (const SoftContact& contact : cube->contacts()) impulse += eigen(contact.impulse);
    }
    const Vector3d weight(0.0, -kGravity * 6 * kLongTick * cube->totalMass(), 0.0);
    const Vector3d change = cube->totalMass() * (velocityOf(*cube) - s.linearVelocity);
    EXPECT_LT((impulse + weight - change).norm(), 1e-3 * change.norm());
  }
}

/// The points pass from one side of the groove to the other some times within a tick, down and up again.
TEST(FinePieces, pointsThatTurnRoundInAGrooveStayInIt) {
  constexpr double kSteepness = 3.0;
  RopeSettings rope;
  rope.segments = 1;
  for (const double speed : {5.0, 10.0, 15.0})
    for (const double x : {0.01, 0.02, 0.04}) {
      SCOPED_TRACE(testing::Message() << speed << " m/s, from " << x << " m");
      SoftWorld bullet;
      addFineMesh(bullet, [](double at) { return kSteepness * std::abs(at); })->setRestitution(btScalar(0.9));
      SoftBodySettings s = smallCube(0.3, {0.0, -speed, 0.0});
      s.position.x() = x, s.position.z() = 0.15;
      s.rotation = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY());  // along the groove
      s.restitution = 1.0, s.friction = 0.0;
      s.stepping.minSubsteps = 60;
      SoftBody* body = bullet.addSoft(*buildRope(rope), s);
      for (int i = 0; i < 6; ++i) {
        bullet.tick(kLongTick);
        for (std::uint32_t p = 0; p < body->pointCount(); ++p) {
          const Vector3d at = body->position(p);
          const double gap = (at.y() - kSteepness * std::abs(at.x())) / std::hypot(1.0, kSteepness);
          const bool isOver = std::abs(at.x()) > kHalfFloor;  // it has left the groove
          EXPECT_TRUE(isOver || gap > 0.9 * s.pointRadius.value()) << i << ": " << gap;
        }
      }
    }
}

/// Without friction it slides over hills and keeps its energy, but for the deformations.
TEST(FinePieces, aBodyThatSlidesOverHillsStaysOnThem) {
  const auto height = [](double x) { return 0.02 * std::cos(15.0 * x); };
  for (const double speed : {2.0, 4.0}) {
    SCOPED_TRACE(speed);
    SoftWorld bullet;
    addFineMesh(bullet, height)->setFriction(0);
    SoftBodySettings s = smallCube(0.0, {speed, 0.0, 0.0});
    s.position.x() = -0.35;
    s.position.y() = 0.18;
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
    const double atStart = energyOf(*cube, kGravity);
    for (int i = 0; i < std::floor(0.7 / speed / kLongTick); ++i) {
      bullet.tick(kLongTick);
      EXPECT_LT(energyOf(*cube, kGravity), atStart + 1e-3) << i;
      for (std::uint32_t p = 0; p < cube->pointCount(); ++p) {
        const Vector3d x = cube->position(p);
        // chords of the triangles are up to 6e-5 m below the hills
        EXPECT_GT(x.y() - height(x.x()), 0.9 * s.pointRadius.value() - 6e-5) << i;
      }
    }
    EXPECT_GT(velocityOf(*cube).x(), 0.4 * speed);
  }
}

}  // namespace
}  // namespace limber::test
