// SPDX-License-Identifier: Zlib
// Points of soft bodies that the user holds.
#include "support/soft_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace limber::test {
namespace {

SoftBody* addGrabbedCube(SoftBodySystem& system, double mass = 2.0) {
  SoftBodySettings s = testedSettings();
  setSprings(s, 5000, 20);
  s.totalMass = mass;
  return *system.createBody(closedCubeNetwork(), s);
}

TEST(Grab, aPointFollowsTheTargetAndTheReleasedBodyFalls) {
  SoftWorld bullet;
  SoftBody* cube = addGrabbedCube(bullet.system);
  const Eigen::Vector3d start = cube->position(7);
  Result<Grab> held = grab(bullet.system, cube, 7);
  ASSERT_TRUE(held) << held.error();
  const auto placeAt = [&](double t) {
    return Eigen::Vector3d(start + Eigen::Vector3d(std::sin(2 * t), 0.5 * t, std::cos(2 * t) - 1));
  };
  const double sag = kGravity / std::pow(2 * kPi * 4.0, 2);
  for (int i = 0; i < 180; ++i) {
    const double t = kTick * i;
    const Eigen::Vector3d v = (placeAt(t + kTick) - placeAt(t)) / kTick;
    held->moveTo(vec(placeAt(t).x(), placeAt(t).y(), placeAt(t).z()), vec(v.x(), v.y(), v.z()));
    bullet.tick();
    if (i > 60) {
      EXPECT_LT((cube->position(7) - placeAt(t + kTick)).norm(), sag + 0.12);
    }
  }
  const Eigen::Vector3d last = placeAt(kTick * 180);
  held->moveTo(vec(last.x(), last.y(), last.z()));
  double height = 0.0, force = 0.0;  // means: the cube swings about the place
  for (int i = 0; i < 1200; ++i) {
    bullet.tick();
    height += cube->position(7).y() / 1200;
    force += double(held->force().y()) / 1200;
  }
  EXPECT_NEAR(height, last.y() - sag, 0.01);
  EXPECT_NEAR(force, 2.0 * kGravity, 0.02 * 2.0 * kGravity);
  held->release();
  EXPECT_FALSE(held->holds());
  EXPECT_EQ(bullet.system.springCount(), 0u);
  const double before = cube->centerOfMass().y(), speed = cube->linearMomentum().y() / 2.0;
  bullet.simulate(0.5);
  EXPECT_NEAR(cube->centerOfMass().y(), before + 0.5 * speed - 0.125 * kGravity, 0.05);
}

TEST(Grab, atRestItDoesNotOscillate) {
  SoftWorld bullet(0.0);
  SoftBody* pair = addGrabbedCube(bullet.system);
  Result<Grab> held = grab(bullet.system, pair, 0);
  ASSERT_TRUE(held);
  const Eigen::Vector3d place = pair->position(0) + Eigen::Vector3d(0.2, 0, 0);
  double beyond = 0.0;
  for (int i = 0; i < 120; ++i) {
    held->moveTo(vec(place.x(), place.y(), place.z()));
    bullet.tick();
    beyond = std::max(beyond, (pair->position(0) - place).x());
  }
  EXPECT_LT(beyond, 0.03);
  EXPECT_LT((pair->position(0) - place).norm(), 0.02);
}

/// A rope along the x axis that is pulled along itself.
TEST(Grab, pullsStraightOverAnyDistance) {
  for (const double distance : {1.0, 10.0, 30.0}) {
    SoftWorld bullet(0.0);
    SoftBody* rope = bullet.addSoft(*buildRope());
    Result<Grab> held = grab(bullet.system, rope, 16);
    ASSERT_TRUE(held);
    const Eigen::Vector3d end = rope->position(16);
    held->moveTo(vec(end.x() + distance, end.y(), end.z()));
    for (int i = 0; i < 5; ++i) bullet.tick();
    const Eigen::Vector3d momentum = rope->linearMomentum();
    EXPECT_GT(momentum.x(), 0.0);
    // the pull consists of three springs of 50 m, which turn a little when the point moves within a tick
    EXPECT_LT(std::hypot(momentum.y(), momentum.z()), 1e-3 * distance * momentum.x()) << distance;
  }
}

TEST(Grab, pullsNoMoreThanItsForce) {
  SoftWorld bullet;
  bullet.addPlaneFloor();
  SoftBody* cube = addGrabbedCube(bullet.system);
  GrabSettings weak;
  weak.maxForce = 0.5 * 2.0 * kGravity;
  Result<Grab> held = grab(bullet.system, cube, 7, weak);
  ASSERT_TRUE(held);
  for (int i = 0; i < 120; ++i) {
    held->moveTo(vec(0, 10, 0));
    bullet.tick();
  }
  EXPECT_LT(lowest(*cube), 0.1) << "it is not lifted by half its weight";
}

// The limit holds in each tick, not only in those with a moveTo().
TEST(Grab, aSmallForceDoesNotHoldAHangingRope) {
  double depths[2];
  for (const bool moves : {false, true}) {
    SoftWorld bullet(-kGravity);
    SoftBodySettings s = testedSettings();
    s.totalMass = 2.0;
    s.damping = 50.0;
    SoftBody* body = bullet.addSoft(ropeNetwork(4), s);
    GrabSettings weak;
    weak.maxForce = 10.0;
    Result<Grab> held = grab(bullet.system, body, 0, weak);
    ASSERT_TRUE(held);
    const btVector3 place = held->body()->point(0)->getCenterOfMassPosition();
    for (int i = 0; i < 120; ++i) {
      if (moves) held->moveTo(place);
      bullet.tick();
    }
    depths[moves] = double(place.y()) - body->position(0).y();
    EXPECT_GT(depths[moves], 0.5) << "it slides down under 19.6 N";
  }
  EXPECT_NEAR(depths[0], depths[1], 1e-9);
}

/// The pull is limited to 10 N of 1 kg: with critical damping for each distance d it goes at up to
/// sqrt(F d / m) / 2 = 11 m/s, and stops at the place.
TEST(Grab, goesFarWithASmallForceAndStops) {
  SoftWorld bullet(0.0);
  SoftBody* cube = addGrabbedCube(bullet.system, 1.0);
  GrabSettings weak;
  weak.maxForce = 10.0;
  Result<Grab> held = grab(bullet.system, cube, 7, weak);
  ASSERT_TRUE(held);
  const Eigen::Vector3d start = cube->position(7), place = start + Eigen::Vector3d(50, 0, 0);
  double beyond = 0.0;
  for (int i = 0; i < 1200; ++i) {
    held->moveTo(vec(place.x(), place.y(), place.z()));
    bullet.tick();
    beyond = std::max(beyond, cube->centerOfMass().x() - place.x());
    if (i == 180) {
      EXPECT_GT(cube->centerOfMass().x() - start.x(), 10.0);
    }
  }
  EXPECT_LT((cube->position(7) - place).norm(), 0.1);
  EXPECT_LT(beyond, 1.0) << "the cube swings about its corner";
}

TEST(Grab, itsForceIsWhatMovesTheBody) {
  SoftWorld bullet(0.0);
  SoftBody* cube = addGrabbedCube(bullet.system, 1.0);
  Result<Grab> held = grab(bullet.system, cube, 7);
  ASSERT_TRUE(held);
  const Eigen::Vector3d place = cube->position(7) + Eigen::Vector3d(0.5, 0, 0);
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero(), before = impulse;
  for (int i = 0; i < 20; ++i) {
    held->moveTo(vec(place.x(), place.y(), place.z()), vec(0, 0, 0));
    bullet.tick(kTick / 8.0);
    const Eigen::Vector3d now = eigen(held->force());
    if (i > 0) impulse += kTick / 8.0 * 0.5 * (before + now);
    if (i == 0) impulse = cube->linearMomentum();
    before = now;
  }
  // the trapezoidal rule over 19 ticks of 1/480 s
  EXPECT_NEAR(impulse.x(), cube->linearMomentum().x(), 0.05 * cube->linearMomentum().x());
}

TEST(Grab, survivesTheBodyAndTheSystem) {
  BulletWorld bullet;
  auto system = std::make_unique<SoftBodySystem>(*bullet.world);
  SoftBody* cube = addGrabbedCube(*system);
  Grab held = std::move(*grab(*system, cube, 0));
  Grab other = std::move(*grab(*system, addGrabbedCube(*system), 1));
  ASSERT_TRUE(held.holds());
  system->destroyBody(cube);
  EXPECT_FALSE(held.holds());
  EXPECT_EQ(held.body(), nullptr);
  held.moveTo(vec(0, 1, 0));
  bullet.tick();
  EXPECT_TRUE(other.holds());
  other.moveTo(vec(0, std::numeric_limits<double>::quiet_NaN(), 0));
  system.reset();
  EXPECT_FALSE(other.holds());
  other.moveTo(vec(0, 1, 0));
  other.release();
}

TEST(Grab, refusesWhatIsNotThere) {
  SoftWorld bullet;
  SoftBody* cube = addGrabbedCube(bullet.system);
  EXPECT_FALSE(grab(bullet.system, SurfaceHit()));
  EXPECT_FALSE(grab(bullet.system, nullptr, 0));
  EXPECT_FALSE(grab(bullet.system, cube, 100));
  GrabSettings bad;
  bad.frequency = 0;
  EXPECT_FALSE(grab(bullet.system, cube, 0, bad));
  cube->pin(0);
  EXPECT_FALSE(grab(bullet.system, cube, 0));
  EXPECT_EQ(bullet.system.springCount(), 0u);
}

TEST(SurfaceGrab, holdsWhatARayHits) {
  SoftWorld bullet;
  SoftBody* cube = addGrabbedCube(bullet.system);
  bullet.tick();
  TriangleRay ray(vec(0.3, 0.2, 5), vec(0.3, 0.2, -5));
  bullet.world->rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
  ASSERT_TRUE(ray.hasHit());
  Result<Grab> held =
      grab(bullet.system, surfaceHit(ray.m_collisionObject, ray.triangle, ray.m_hitPointWorld));
  ASSERT_TRUE(held);
  EXPECT_EQ(held->body(), cube);
  EXPECT_GT(cube->position(held->point()).z(), 0.0) << "on the front";
  bullet.simulate(1.0);
  EXPECT_GT(cube->centerOfMass().y(), -1.2) << "it hangs there";
}

TEST(Grab, holdsNothingOnceTheWorldIsGone) {
  auto bullet = std::make_unique<BulletWorld>();
  SoftBodySystem system(*bullet->world);
  SoftBody* cube = addGrabbedCube(system);
  Result<Grab> result = grab(system, cube, 7);
  ASSERT_TRUE(result);
  Grab held = std::move(*result);
  EXPECT_TRUE(held.holds());
  bullet.reset();
  EXPECT_FALSE(held.holds());
  held.moveTo(vec(1, 1, 1));
  held.release();
}

}  // namespace
}  // namespace limber::test
