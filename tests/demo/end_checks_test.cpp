// SPDX-License-Identifier: Zlib
// Each end check must fail in a scene with errors.
#include "scenes/end_checks.h"

#include "created_scene.h"
#include "scenes/arrangement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace limber::scenes {
namespace {

constexpr int kTicksToSleep = 600;  // ticks, more than four cubes need to fall asleep

void run(Scene& scene, int ticks) {
  for (int i = 0; i < ticks; ++i) tick(scene);
}

void movePoint(SoftBody& body, std::uint32_t i, const btVector3& to) {
  body.point(i)->getWorldTransform().setOrigin(to);
  body.point(i)->getInterpolationWorldTransform().setOrigin(to);
}

void expectContains(const std::string& text, const char* part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << text << "\" does not say: " << part;
}

TEST(EndChecks, fourCubesPass) {
  const auto scene = created("cubes", 4);
  run(*scene, kTicksToSleep);
  EXPECT_EQ(checkEnd(*scene), "");
}

TEST(EndChecks, cubesInTheAirAreNotCalm) {
  const auto scene = created("cubes", 4);
  run(*scene, 20);
  expectContains(checkEnd(*scene), "is not calm");
}

TEST(EndChecks, runOfNoTicksIsNotCalm) { expectContains(checkEnd(*created("cubes", 1)), "is not calm"); }

TEST(EndChecks, aSpikeFails) {
  const auto scene = created("cubes", 1);
  EXPECT_EQ(checkSpikes(3.0)(*scene), "");
  SoftBody& cube = *scene->soft->body(0);
  cube.point(0)->setLinearVelocity(toBullet(1e4 * (cube.position(0) - cube.centerOfMass())));
  run(*scene, 1);
  expectContains(checkSpikes(3.0)(*scene), "body 0 has spikes");
}

TEST(EndChecks, aBodyThatFliesAwayFails) {
  const auto scene = created("cubes", 2);
  EXPECT_EQ(checkWithin(50.0)(*scene), "");
  SoftBody& cube = *scene->soft->body(1);
  for (std::uint32_t i = 0; i < cube.pointCount(); ++i)
    movePoint(cube, i, toBullet(cube.position(i) + Eigen::Vector3d(0.0, 0.0, 80.0)));
  run(*scene, 1);
  expectContains(checkWithin(50.0)(*scene), "of body 1 has flown away");
}

TEST(EndChecks, aBodyThatRollsAwayIsFineAndOneThatWobblesIsNot) {
  const auto scene = created("cubes", 1);
  run(*scene, kTicksToSleep);
  SoftBody& cube = *scene->soft->body(0);
  const auto setVelocities = [&](auto velocityAt) {
    cube.wake();
    for (std::uint32_t i = 0; i < cube.pointCount(); ++i) {
      const Eigen::Vector3d v = velocityAt(Eigen::Vector3d(cube.position(i) - cube.centerOfMass()));
      cube.point(i)->setLinearVelocity(btVector3(btScalar(v.x()), btScalar(v.y()), btScalar(v.z())));
    }
  };
  setVelocities([](const Eigen::Vector3d&) { return Eigen::Vector3d(5, 0, 0); });
  run(*scene, 2);  // the first tick may begin a new measurement window
  expectContains(checkCalm(0.02)(*scene), "is not calm");
  setVelocities([](const Eigen::Vector3d& r) {
    return Eigen::Vector3d(Eigen::Vector3d(2, 0, 0) + Eigen::Vector3d(0, 0, -4).cross(r));
  });
  EXPECT_EQ(checkCalmOrRolling(0.02)(*scene), "");
  setVelocities([](const Eigen::Vector3d& r) { return Eigen::Vector3d(2.0 * r.x(), 0, 0); });
  expectContains(checkCalmOrRolling(0.02)(*scene), "is not calm");
  setVelocities([](const Eigen::Vector3d&) { return Eigen::Vector3d(0, -3, 0); });
  expectContains(checkCalmOrRolling(0.02)(*scene), "is not calm");
}

TEST(EndChecks, pointBelowTheFloorIsFound) {
  const auto scene = created("cubes", 2);
  movePoint(*scene->soft->body(1), 3, btVector3(0, btScalar(-0.5), 0));
  expectContains(checkAboveFloor(*scene), "point 3 of body 1 is 0.5 m below the floor");
}

TEST(EndChecks, pointThatIsNowhereIsFound) {
  const auto scene = created("cubes", 2);
  movePoint(*scene->soft->body(0), 7, btVector3(0, btScalar(NAN), 0));
  expectContains(checkFinite(*scene), "point 7 of body 0 is nowhere");
}

TEST(EndChecks, squashedCubeHasLostItsShape) {
  const auto scene = created("cubes", 1);
  SoftBody& cube = *scene->soft->body(0);
  for (std::uint32_t i = 0; i < cube.pointCount(); ++i) {
    const Eigen::Vector3d p = cube.position(i);
    movePoint(cube, i, btVector3(btScalar(p.x()), btScalar(0.8 * p.y()), btScalar(p.z())));
  }
  expectContains(checkShapes(0.03)(*scene), "body 0 has lost its shape");
}

TEST(EndChecks, mirroredCubeIsInsideOut) {
  const auto scene = created("cubes", 1);
  SoftBody& cube = *scene->soft->body(0);
  for (std::uint32_t i = 0; i < cube.pointCount(); ++i) {
    const Eigen::Vector3d p = cube.position(i);
    movePoint(cube, i, btVector3(btScalar(-p.x()), btScalar(p.y()), btScalar(p.z())));
  }
  expectContains(checkShapes(10.0)(*scene), "is inside out");
}

TEST(EndChecks, awakeBodyIsFound) {
  const auto scene = created("cubes", 1);
  run(*scene, kTicksToSleep);
  EXPECT_EQ(checkAsleep(*scene), "");
  scene->soft->body(0)->wake();
  expectContains(checkAsleep(*scene), "is still awake");
}

TEST(EndChecks, stretchedRopeIsFound) {
  const auto scene = created("rope", 1);
  SoftBody& rope = *scene->soft->body(0);
  EXPECT_EQ(checkStretch(0.01)(*scene), "");
  const Eigen::Vector3d end = rope.position(0);
  movePoint(rope, 0, btVector3(btScalar(end.x() - 0.1), btScalar(end.y()), btScalar(end.z())));
  expectContains(checkStretch(0.01)(*scene), "body 0 is stretched by");
}

TEST(EndChecks, ropeWithoutItsBoxDoesNotHang) {
  const auto scene = created("rope", 1);
  scene->world->dynamics.removeRigidBody(scene->world->statics[1].get());
  run(*scene, 240);
  expectContains(scene->endChecks.back()(*scene), "rope 0 does not lie on the box");
}

TEST(EndChecks, clothWithoutItsSphereDoesNotDrape) {
  const auto scene = created("cloth", 1);
  scene->world->dynamics.removeRigidBody(scene->world->statics[1].get());
  run(*scene, 90);
  expectContains(scene->endChecks.back()(*scene), "cloth 0 does not lie on the sphere");
}

TEST(EndChecks, pointInsideTheSphereIsFound) {
  const auto scene = created("cloth", 1);
  const Check check = checkOutsideBall({0.0, 0.75, 0.0}, 0.75, 0.01);
  EXPECT_EQ(check(*scene), "");
  movePoint(*scene->soft->body(0), 500, btVector3(0, btScalar(0.75), 0));
  expectContains(check(*scene), "point 500 of body 0 is 0.75 m inside the sphere");
}

// --- errors of shapes --------------------------------------------------------------------------------------

using Points = std::vector<Eigen::Vector3d>;

Points unitCube() {
  Points points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1, (i >> 1) & 1, i >> 2);
  return points;
}

Points map(Points points, const Eigen::Affine3d& motion) {
  for (Eigen::Vector3d& p : points) p = motion * p;
  return points;
}

TEST(ShapeError, rigidMotionIsNoError) {
  Random random(5);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Affine3d motion = Eigen::Translation3d(3.0, -1.0, 7.0) * random.rotation();
    const ShapeError error = shapeError(unitCube(), map(unitCube(), motion));
    EXPECT_LT(error.relativeRms, 1e-12);
    EXPECT_FALSE(error.mirrored);
  }
}

TEST(ShapeError, mirrorImageIsNoRigidMotion) {
  const Eigen::Affine3d mirror(Eigen::Scaling(-1.0, 1.0, 1.0));
  const ShapeError error = shapeError(unitCube(), map(unitCube(), mirror));
  EXPECT_TRUE(error.mirrored);
  EXPECT_GT(error.relativeRms, 0.3);
}

// a stretch by s in x moves each point of the cube by s / 2
TEST(ShapeError, stretchIsMeasured) {
  const Eigen::Affine3d stretch(Eigen::Scaling(1.2, 1.0, 1.0));
  EXPECT_NEAR(shapeError(unitCube(), map(unitCube(), stretch)).relativeRms, 0.1, 1e-12);
}

TEST(ShapeError, isRelativeToTheSize) {
  const Eigen::Affine3d large(Eigen::Scaling(100.0, 100.0, 100.0));
  const Eigen::Affine3d stretched(Eigen::Scaling(120.0, 100.0, 100.0));
  EXPECT_NEAR(shapeError(map(unitCube(), large), map(unitCube(), stretched)).relativeRms, 0.1, 1e-12);
}

TEST(ShapeError, pointThatIsNowhereIsInfinitelyOff) {
  Points broken = unitCube();
  broken[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(shapeError(unitCube(), broken).relativeRms, std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace limber::scenes
