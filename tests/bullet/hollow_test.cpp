// SPDX-License-Identifier: Zlib
// Closed soft bodies that are hollow keep in what is inside. Solid ones do not.
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <cmath>

namespace limber::test {
namespace {

SoftBodySettings settingsOf(double mass, double y) {
  SoftBodySettings s;
  s.position = {0, y, 0};
  s.totalMass = mass;
  setSprings(s, 2000.0 * mass, 2.0 * mass);
  s.pointRadius = 0.02;
  return s;
}

/// A balloon or a limp bag of 1 m radius and 4 kg, just above the floor.
SoftBody* addBag(SoftBodySystem& system, double pressure, bool hollow) {
  SoftBodySettings s = settingsOf(4.0, 1.05);
  s.volumeModulus = 0.0;
  s.pressure = pressure;
  s.hollow = hollow;
  return *system.createBody(bracedNetwork(small_meshes::icosphere(1)), s);
}

/// Returns the height (m) of the bag's skin below its content after a second and a half.
double heightInside(double pressure, bool hollow, bool softContent, double tick) {
  SoftWorld bullet;
  bullet.addPlaneFloor();
  SoftBody* bag = addBag(bullet.system, pressure, hollow);
  SoftBody* jelly = nullptr;
  btRigidBody* ball = nullptr;
  if (softContent) {
    SoftBodySettings s = settingsOf(0.5, 0.9);
    s.scale *= 0.3;
    jelly = bullet.addSoft(closedCubeNetwork(), s);
  } else {
    ball = bullet.add(std::make_unique<btSphereShape>(btScalar(0.15)), 0.5, vec(0, 0.9, 0));
  }
  bullet.simulate(1.5, tick);
  EXPECT_EQ(bag->restorations(), 0u);
  const double content = jelly ? lowest(*jelly) : heightOf(*ball) - 0.15;
  return content - lowest(*bag);
}

TEST(Hollow, bodiesKeepInWhatIsInside) {
  if (!kSurface) GTEST_SKIP() << "needs Collision::Surface";
  for (const double tick : {1.0 / 240.0, 1.0 / 60.0, 1.0 / 30.0})
    for (const double pressure : {0.0, 500.0})
      for (const bool soft : {false, true})
        EXPECT_GT(heightInside(pressure, true, soft, tick), soft ? 0.03 : 0.015)
            << tick << ' ' << pressure << ' ' << soft;
}

TEST(Hollow, solidBodiesDoNot) {
  if (!kSurface) GTEST_SKIP() << "needs Collision::Surface";
  for (const bool soft : {false, true}) EXPECT_LT(heightInside(0.0, false, soft, 1.0 / 60.0), 0.01) << soft;
}

TEST(Hollow, mayChangeWhileTheBodyLives) {
  if (!kSurface) GTEST_SKIP() << "needs Collision::Surface";
  SoftWorld bullet;
  bullet.addPlaneFloor();
  SoftBody* bag = addBag(bullet.system, 500.0, true);
  btRigidBody* ball = bullet.add(std::make_unique<btSphereShape>(btScalar(0.15)), 0.5, vec(0, 0.9, 0));
  bullet.simulate(2.0);
  EXPECT_GT(heightOf(*ball), 0.15 + 0.03);
  SoftBodySettings s = bag->settings();
  s.hollow = false;
  ASSERT_TRUE(bag->change(s));
  bullet.simulate(1.0);
  EXPECT_FALSE(bag->settings().hollow);
  s.hollow = true;
  s.collision = Collision::Points;
  EXPECT_EQ(validate(s).error(), "hollow needs collision to be Collision::Surface");
}

}  // namespace
}  // namespace limber::test
