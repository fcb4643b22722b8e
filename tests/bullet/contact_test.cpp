// SPDX-License-Identifier: Zlib
// Bullet finds and solves the contacts: bounce, rest and friction of soft bodies on its shapes.
#include "support/soft_world.h"

#include <cmath>

namespace limber::test {
namespace {

enum class Floor { Plane, Box, Hull, TriangleMesh };

std::string floorName(const testing::TestParamInfo<Floor>& info) {
  const char* names[] = {"Plane", "Box", "Hull", "TriangleMesh"};
  return names[static_cast<int>(info.param)];
}

void addFloor(BulletWorld& bullet, Floor floor) {
  if (floor == Floor::Plane) bullet.addPlaneFloor();
  if (floor == Floor::Box) bullet.addBoxFloor();
  if (floor == Floor::Hull) bullet.addHullFloor();
  if (floor == Floor::TriangleMesh) bullet.addTriangleFloor();
}

class SoftCubeOn : public testing::TestWithParam<Floor> {};

TEST_P(SoftCubeOn, bouncesAndComesToRest) {
  SoftWorld bullet;
  addFloor(bullet, GetParam());
  SoftBodySettings s = settingsAt({0.1, 1.5, 0.05});
  s.rotation = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized());
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  const double radius = pointRadius(body->network(), body->settings());
  double deepest = 1e9, impact = 0, afterBounce = 0;
  bool bounced = false;
  for (int i = 0; i < 480; ++i) {
    const double before = body->linearMomentum().y();
    impact = std::max(impact, -before);
    bullet.tick();
    deepest = std::min(deepest, lowest(*body));
    bounced = bounced || (before < 0 && body->linearMomentum().y() > 0.2);
    afterBounce = std::max(afterBounce, bounced ? body->linearMomentum().y() : 0.0);
  }
  EXPECT_TRUE(bounced) << "it must leave the floor again after the first hit";
  EXPECT_LT(afterBounce, impact) << "no faster than it came";
  EXPECT_TRUE(body->sleeping()) << "after eight seconds all is calm";
  EXPECT_GT(deepest, -radius) << "no point's centre goes through the floor at any time";
  EXPECT_NEAR(lowest(*body), radius, 0.1 * radius) << "it rests on its points";
}

TEST(SleepingCube, itsManifoldsKeepTheImpulsesOfTheLastTick) {
  if (kSurface) GTEST_SKIP() << "only points have Bullet's manifolds";
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBody* body = bullet.addSoft(cubeNetwork(), settingsAt({0.0, 0.6, 0.0}));
  for (int i = 0; i < 600 && !body->sleeping(); ++i) bullet.tick();
  ASSERT_TRUE(body->sleeping());
  const double impulses = bullet.impulsesInManifolds();
  EXPECT_GT(impulses, 0.0);
  bullet.simulate(1.0);
  EXPECT_EQ(bullet.impulsesInManifolds(), impulses);
}

/// Returns the height of the highest point of a frictionless cube at rest on the floor.
double restHeight(Floor floor, double stiffness, double dt) {
  SoftWorld bullet;
  addFloor(bullet, floor);
  SoftBodySettings s = settingsAt({0.1, 0.52, 0.05});
  s.friction = 0;
  setSprings(s, stiffness, 0.2 * std::sqrt(stiffness * 0.125));
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(6.0, dt);
  return highest(*body);
}

TEST_P(SoftCubeOn, restsAtTheSameHeightAtAnyTick) {
  // a body that considers the floor only once per tick rests h^2 g M / M_touching = 5.45 mm too low at 60 Hz
  for (double stiffness : {1e3, 1e4}) {
    const double reference = restHeight(Floor::Plane, stiffness, 1.0 / 960);
    for (double dt : {1.0 / 30, 1.0 / 60, 1.0 / 120})
      EXPECT_NEAR(restHeight(GetParam(), stiffness, dt), reference, 1e-6)
          << "k " << stiffness << " dt " << dt;
  }
}

TEST_P(SoftCubeOn, stiffCubesRestOnTheirPointsToo) {
  // the sag of a stiff cube is W / (stiffness of its side) to first order; compared with that of a soft one
  const double at1e4 = restHeight(Floor::Plane, 1e4, 1.0 / 240) - 1.02;
  EXPECT_NEAR(restHeight(GetParam(), 1e5, 1.0 / 60), 1.02 + at1e4 / 10, 1e-6);
  EXPECT_NEAR(restHeight(GetParam(), 1e6, 1.0 / 60), 1.02 + at1e4 / 100, 1e-6);
}

TEST_P(SoftCubeOn, standsStillAndCarriesItsWeight) {
  SoftWorld bullet;
  addFloor(bullet, GetParam());
  SoftBodySettings s = settingsAt({0.1, 0.52, 0.05});
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(8.0);
  const double radius = pointRadius(body->network(), body->settings());
  const double energy = body->elasticEnergy(), height = body->centerOfMass().y();
  double impulse = 0, fastest = 0, deepest = 1;
  for (int i = 0; i < 3600; ++i) {
    bullet.tick();
    deepest = std::min(deepest, lowest(*body));
    fastest = std::max(fastest, body->kineticEnergy());
    impulse += bullet.impulsesInManifolds();
  }
  if (!kSurface) {
    EXPECT_NEAR(impulse / 60.0 / 9.81, 1.0, 1e-4) << "Bullet's manifolds tell the weight, over a minute";
  }
  EXPECT_GT(deepest, 0.99 * radius) << "no point deeper than 1 % of its radius";
  EXPECT_LT(fastest, 1e-5) << "J; Bullet's rounding of box contacts stirs velocities of 1e-3 m/s at most";
  EXPECT_NEAR(body->elasticEnergy(), energy, 1e-4 * energy);
  EXPECT_NEAR(body->centerOfMass().y(), height, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Floors, SoftCubeOn,
                         testing::Values(Floor::Plane, Floor::Box, Floor::Hull, Floor::TriangleMesh),
                         floorName);

TEST(Contact, holdsAndSlidesOnAnInclineAsCoulombSays) {
  const double mu = 0.5;
  for (double ratio : {0.97, 1.03, 1.3}) {
    SoftWorld bullet;
    const double angle = std::atan(ratio * mu);
    bullet.world->setGravity(vec(9.81 * std::sin(angle), -9.81 * std::cos(angle), 0));
    bullet.addPlaneFloor()->setFriction(1);
    SoftBodySettings s = settingsAt({0, 0.5 + 0.02, 0});
    s.friction = mu;
    setSprings(s, 1e4, 5);
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    body->point(0)->setActivationState(DISABLE_DEACTIVATION);
    bullet.simulate(1.0);
    const double start = body->centerOfMass().x(), speed = body->linearMomentum().x();
    bullet.simulate(1.0);
    const double displacement = body->centerOfMass().x() - start;
    if (ratio < 1) {
      EXPECT_LT(std::abs(displacement), 1e-5) << "held";
    } else {
      const double acceleration = 9.81 * (std::sin(angle) - mu * std::cos(angle));
      EXPECT_NEAR(body->linearMomentum().x() - speed, acceleration, 5e-3 * acceleration) << ratio;
    }
  }
}

TEST(Contact, reboundIsThatOfTheConvergedReference) {
  const auto rebound = [](double stiffness, double dt, int substeps) {
    SoftWorld bullet;
    bullet.addPlaneFloor();
    SoftBodySettings s = settingsAt({0, 1.02, 0});
    setSprings(s, stiffness, 0.04 * std::sqrt(stiffness * 0.125));
    s.stepping.minSubsteps = substeps;
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    double highestAfter = 0;
    bool falls = false, rises = false;
    for (double t = 0; t < 1.0; t += dt) {
      bullet.tick(dt);
      falls = falls || body->linearMomentum().y() < -1.0;
      rises = rises || (falls && body->linearMomentum().y() > 0.0);
      if (rises) highestAfter = std::max(highestAfter, body->centerOfMass().y() - 0.52);
    }
    return highestAfter;
  };
  for (double stiffness : {1e3, 1e4, 1e5}) {
    const double reference = rebound(stiffness, 1.0 / 480, 200);
    // an impact makes any scheme first order in the substep
    EXPECT_NEAR(rebound(stiffness, 1.0 / 60, 1), reference, 0.05 * reference) << "k " << stiffness;
  }
}

TEST(Contact, aMovingPlatformCarriesItsLoad) {
  SoftWorld bullet;
  btRigidBody* platform = bullet.addBox(vec(2, 0.1, 2), 0, vec(0, -0.1, 0));
  platform->setCollisionFlags(platform->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  platform->setActivationState(DISABLE_DEACTIVATION);
  SoftBodySettings s = settingsAt({0, 0.52, 0});
  s.friction = 1;
  SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
  const double radius = pointRadius(body->network(), body->settings());
  bullet.simulate(3.0);
  double phase = 0, deepest = 1;
  const double along = body->centerOfMass().x();
  for (int i = 0; i < 600; ++i) {
    phase += 1.0 / 60;
    // up, down (slower than a free fall) and sideways, from rest
    const double up = 0.3 * (1 - std::cos(2 * phase)), side = 0.2 * (1 - std::cos(1.5 * phase));
    btTransform pose(btQuaternion::getIdentity(), vec(side, up - 0.1, 0));
    platform->setWorldTransform(pose);
    bullet.tick();
    deepest = std::min(deepest, lowest(*body) - up);
    EXPECT_NEAR(body->centerOfMass().x() - along, side, 0.02) << "carried along at tick " << i;
  }
  EXPECT_GT(deepest, 0.99 * radius);
}

TEST(Contact, aCornerHoldsAgainstTwoWalls) {
  // A point between a floor and a wall has two contact constraints, and must meet both.
  SoftWorld bullet;
  bullet.world->setGravity(vec(-6, -8, 0));
  bullet.addBoxFloor();
  bullet.addBox(btVector3(1, 50, 50), 0, btVector3(-1, 0, 0));
  SoftBodySettings s = settingsAt({0.6, 0.6, 0});
  s.friction = 0;
  SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
  body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(8.0);
  const double radius = pointRadius(body->network(), body->settings());
  EXPECT_NEAR(lowest(*body), radius, 0.01 * radius);
  double leftmost = 1;
  for (std::uint32_t i = 0; i < 8; ++i) leftmost = std::min(leftmost, body->position(i).x());
  EXPECT_NEAR(leftmost, radius, 0.01 * radius);
  EXPECT_LT(body->kineticEnergy(), 1e-5);
}

TEST(Contact, aBodyPlacedInsideTheFloorComesOutGently) {
  for (double depth : {0.01, 0.05, 0.2}) {
    SoftWorld bullet;
    bullet.addBoxFloor();
    SoftBodySettings s = settingsAt({0, 0.52 - depth, 0});
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    double highestSpeed = 0;
    for (int i = 0; i < 240; ++i) {
      bullet.tick();
      highestSpeed = std::max(highestSpeed, body->linearMomentum().y());
    }
    EXPECT_GT(lowest(*body), 0.0) << "depth " << depth;
    // The plugin's contacts lift the body at 0.5 m/s at most. Bullet's solver, which runs after them,
    // corrects erp2 = 20 % of a penetration per tick, which is a speed of 12 times the depth per second.
    EXPECT_LT(highestSpeed, 0.6 + 1.1 * 12 * depth) << "depth " << depth;
  }
}

TEST(Contact, fastPointsAreStoppedByAThinPlate) {
  // 20 m/s is 33 cm per tick: without continuous collision all points pass through a plate of 2 cm
  for (double speed : {1.0, 2.0, 3.0, 5.0, 20.0, 50.0}) {
    SoftWorld bullet(0.0);
    bullet.addBox(btVector3(5, btScalar(0.01), 5), 0, btVector3(0, 0, 0));
    SoftBodySettings s = settingsAt({0, 2, 0});
    s.linearVelocity = {0, -speed, 0};
    s.extensionStiffness = s.compressionStiffness = 1e4;
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    bullet.simulate(1.0);
    EXPECT_GT(lowest(*body), 0.0) << "speed " << speed;
  }
}

TEST(Contact, fastPointsAreStoppedByATriangleMesh) {
  // A mesh has no inside: a point that has passed through it is not pushed back. Some speeds are below and
  // some above the threshold of Bullet's swept test.
  for (double speed : {0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 30.0, 60.0}) {
    SoftWorld bullet(0.0);
    bullet.addTriangleFloor();
    SoftBodySettings s = settingsAt({0.11, 0.9, 0.07});
    s.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized());
    s.linearVelocity = {0.3 * speed, -speed, 0};
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    for (int i = 0; i < 180; ++i) {
      bullet.tick();
      ASSERT_GT(lowest(*body), 0.0) << "speed " << speed << " tick " << i;
    }
  }
}

TEST(Contact, aFreeBoxLandsOnASoftCubeAndStays) {
  SoftWorld bullet;
  bullet.addPlaneFloor();
  SoftBodySettings s = settingsAt({0, 0.52, 0});
  s.extensionStiffness = s.compressionStiffness = 2000;
  SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
  btRigidBody* plate = bullet.addBox(vec(0.7, 0.1, 0.7), 0.2, vec(0, 1.3, 0));
  bullet.simulate(5.0);
  EXPECT_GT(heightOf(*plate), 1.0);
  EXPECT_LT(heightOf(*plate), 1.15);
  EXPECT_GT(lowest(*body), 0.0);
}

TEST(Contact, pointsOfOneBodyPassThroughEachOther) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.pointRadius = 0.4;  // neighbouring spheres overlap deeply
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  const std::uint64_t before = body->stateHash();
  bullet.simulate(0.5);
  EXPECT_EQ(body->stateHash(), before) << "at rest without forces nothing may move, to the bit";
}

TEST(Contact, pointsOfDifferentBodiesCollide) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.pointRadius = 0.1;
  SoftBody* left = bullet.addSoft(cubeNetwork(), s);
  s.position = {1.5, 0, 0};
  s.linearVelocity = {-1, 0, 0};
  SoftBody* right = bullet.addSoft(cubeNetwork(), s);
  left->point(0)->setActivationState(DISABLE_DEACTIVATION);
  right->point(0)->setActivationState(DISABLE_DEACTIVATION);
  const double momentum = right->linearMomentum().x();
  bullet.simulate(2.0);
  EXPECT_LT(left->linearMomentum().x(), 0.5 * momentum) << "the left one was pushed";
  // velocities of 1 m/s in floats, some hundred contacts
  EXPECT_NEAR(left->linearMomentum().x() + right->linearMomentum().x(), momentum, 1e-5);
}

TEST(Contact, pointsBounceByTheRestitutionOfBothMaterials) {
  for (const bool free : {false, true}) {
    SCOPED_TRACE(free ? "a heavy plate that flies along" : "a floor");
    SoftWorld bullet(0.0);
    // The plate cannot rotate. If it can move, it is 1e6 times as heavy as the body that hits it.
    btRigidBody* plate = bullet.addBox(vec(3, 1, 3), free ? 1e6 : 0.0, vec(0, -1, 0));
    plate->setAngularFactor(btScalar(0));
    plate->setRestitution(btScalar(0.75));
    SoftBodySettings s = settingsAt({0, 0.5, 0});
    s.restitution = 0.8;
    s.damping = 0.0;
    s.linearVelocity = {0.5, -3, 0};
    s.friction = 0.0;
    SoftBody* body = bullet.addSoft(pairNetwork(), s);  // both points hit at once
    bullet.simulate(0.5);
    // Each point rebounds with 0.6 of its speed, within the float rounding of Bullet's narrowphase.
    EXPECT_NEAR(body->velocity(0).y(), 0.6 * 3, 5e-5);
    EXPECT_NEAR(body->velocity(1).y(), 0.6 * 3, 5e-5);
    EXPECT_NEAR(body->linearMomentum().x(), 0.5, 2e-5);
  }
}

TEST(Contact, groupsAndMasksAreTheUsers) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBodySettings s = settingsAt({0, 1, 0});
  s.collisionGroup = 1 << 7;
  s.collisionMask = 1 << 9;  // not the floor's group
  SoftBody* ghost = bullet.addSoft(cubeNetwork(), s);
  const btRigidBody* object = kSurface ? ghost->surfaceObject() : ghost->point(0);
  EXPECT_EQ(object->getBroadphaseHandle()->m_collisionFilterGroup, 1 << 7);
  EXPECT_EQ(object->getBroadphaseHandle()->m_collisionFilterMask, 1 << 9);
  bullet.simulate(1.0);
  EXPECT_LT(lowest(*ghost), -2.0) << "falls through";
}

}  // namespace
}  // namespace limber::test
