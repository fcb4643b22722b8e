// SPDX-License-Identifier: Zlib
// Compares the contacts that bodies report with the laws of motion: weights, momenta, positions.
#include "support/allocation_counter.h"
#include "support/soft_world.h"

#include <cmath>

namespace limber::test {
namespace {

constexpr double kWeight = kGravity;  // N, of bodies of 1 kg

SoftBodySettings weighedSettings(double height) {
  SoftBodySettings s = settingsAt({0, height, 0});
  setSprings(s, 2000, 5);
  s.friction = 1;
  s.pointRadius = kRadius;
  return s;
}

SoftBody* addWeighedCube(SoftBodySystem& system, double height = 0.5 + kRadius) {
  SoftBody* body = *system.createBody(fullCubeNetwork(), weighedSettings(height));
  body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  return body;
}

/// Adds a cube with a closed surface.
SoftBody* addClosedCube(SoftBodySystem& system, double height) {
  SoftBody* body = *system.createBody(closedCubeNetwork(), weighedSettings(height));
  body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  return body;
}

struct Sums {
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();   // N s
  Eigen::Vector3d friction = Eigen::Vector3d::Zero();  // N s
  double normal = 0.0;                                 // N s
};

void add(Sums& sums, const SoftBody& body, const btCollisionObject* other = nullptr) {
  for (const SoftContact& c : body.contacts()) {
    EXPECT_EQ(c.body, &body);
    if (other && c.other != other) continue;
    sums.impulse += eigen(c.impulse);
    sums.friction += eigen(c.frictionImpulse);
    sums.normal += c.normalImpulse;
  }
}

/// Returns the mean impulses, N s per tick, over a minute that starts when all bodies are at rest.
Sums meanOfAMinute(BulletWorld& bullet, const SoftBody& body, const btCollisionObject* other = nullptr) {
  bullet.simulate(10.0);
  Sums sums;
  const int ticks = 3600;
  for (int i = 0; i < ticks; ++i) {
    bullet.tick(kTick);
    add(sums, body, other);
  }
  sums.impulse /= ticks, sums.friction /= ticks, sums.normal /= ticks;
  return sums;
}

// Relative. A body at rest has no momentum that could hide an error.
constexpr double kTolerance = 1e-3;

TEST(ContactTruth, aRestingCubeBearsItsWeight) {
  enum { OnPlane, OnBox, OnFreeBox };
  for (const int kind : {OnPlane, OnBox, OnFreeBox}) {
    SoftWorld bullet;
    btRigidBody* floor = kind == OnPlane ? bullet.addPlaneFloor() : bullet.addBoxFloor();
    if (kind == OnFreeBox) floor = bullet.addAwakeBox(vec(1, 0.2, 1), 2.0, vec(0, 0.2, 0));
    const double height = (kind == OnFreeBox ? 0.9 : 0.5) + kRadius;
    const Sums mean = meanOfAMinute(bullet, *addWeighedCube(bullet.system, height), floor);
    EXPECT_NEAR(mean.normal / (kWeight * kTick), 1.0, kTolerance) << kind;
    EXPECT_NEAR(mean.impulse.x(), 0.0, kTolerance * kWeight * kTick) << kind;
  }
}

TEST(ContactTruth, aFreeBoxOnACubeIsBorneByIt) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addBoxFloor();
  SoftBody* cube = addWeighedCube(bullet.system);
  btRigidBody* box = bullet.addAwakeBox(vec(0.7, 0.1, 0.7), 0.5, vec(0, 1.1 + 2 * kRadius, 0));
  const Sums onBox = meanOfAMinute(bullet, *cube, box);
  EXPECT_NEAR(onBox.impulse.y() / (-0.5 * kWeight * kTick), 1.0, kTolerance);
  Sums onFloor;
  add(onFloor, *cube, floor);
  // only the last tick, at rest
  EXPECT_NEAR(onFloor.impulse.y() / (1.5 * kWeight * kTick), 1.0, kTolerance);
}

TEST(ContactTruth, aCubeOnACubeIsBorneByItAsBothTell) {
  if (!kSurface) GTEST_SKIP() << "points of cubes do not rest on points";
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBody* lower = addClosedCube(bullet.system, 0.5 + kRadius);
  SoftBody* upper = addClosedCube(bullet.system, 1.5 + 3 * kRadius);
  bullet.simulate(10.0);
  Sums up, down;
  const int ticks = 3600;
  for (int i = 0; i < ticks; ++i) {
    bullet.tick(kTick);
    add(up, *upper, lower->surfaceObject());
    add(down, *lower, upper->surfaceObject());
  }
  EXPECT_NEAR(up.impulse.y() / (kWeight * kTick * ticks), 1.0, kTolerance);
  // float vectors of up to 0.1 N s: several rounding errors in each of 3600 ticks
  EXPECT_LT((up.impulse + down.impulse).norm(), 1e-5);
}

TEST(ContactTruth, theImpulsesOfACollisionAreTheChangesOfMomentumInBothBodiesReports) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = weighedSettings(0);
  s.linearVelocity = {0, 1, 0};
  SoftBody* a = bullet.addSoft(closedCubeNetwork(), s);
  s.position = {0, 1.3, 0};
  s.linearVelocity = {0, -1, 0};
  SoftBody* b = bullet.addSoft(closedCubeNetwork(), s);
  const Eigen::Vector3d before = a->linearMomentum();
  Sums onA, onB;
  for (int i = 0; i < 60; ++i) {
    bullet.tick(kTick);
    for (const SoftContact& c : a->contacts()) EXPECT_EQ(c.otherBody, b);
    add(onA, *a);
    add(onB, *b);
  }
  ASSERT_GT(onB.impulse.y(), 0.5);
  // Points in the world exchange their velocities with Bullet as floats, once per tick.
  EXPECT_LT((a->linearMomentum() - before - onA.impulse).norm(), kSurface ? 1e-5 : 1e-4);
  EXPECT_LT((onA.impulse + onB.impulse).norm(), 1e-5);
}

TEST(ContactTruth, frictionHoldsACubeOnAnIncline) {
  const double angle = 0.3;
  for (const bool free : {false, true}) {
    SoftWorld bullet(0.0);
    // The incline is horizontal and gravity is tilted instead.
    bullet.world->setGravity(vec(kGravity * std::sin(angle), -kGravity * std::cos(angle), 0));
    btRigidBody* floor = bullet.addBoxFloor();
    floor->setFriction(1);
    if (free) {
      floor = bullet.addBox(vec(1, 0.2, 1), 2.0, vec(0, 0.2, 0));
      floor->setFriction(1);
      floor->setActivationState(DISABLE_DEACTIVATION);
    }
    const Sums mean =
        meanOfAMinute(bullet, *addWeighedCube(bullet.system, (free ? 0.9 : 0.5) + kRadius), floor);
    EXPECT_NEAR(mean.friction.x() / (-kWeight * std::sin(angle) * kTick), 1.0, kTolerance) << free;
    EXPECT_NEAR(mean.normal / (kWeight * std::cos(angle) * kTick), 1.0, kTolerance) << free;
  }
}

TEST(ContactTruth, aMarbleOnAFaceTellsTriangleAndPlace) {
  if (!kSurface) GTEST_SKIP() << "faces are not in the world";
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBody* cube = addClosedCube(bullet.system, 0.5 + kRadius);
  const double r = 0.1;
  btRigidBody* marble =
      bullet.add(std::make_unique<btSphereShape>(btScalar(r)), 0.05, vec(0.12, 1 + 2 * kRadius + r, 0.2));
  marble->setFriction(1);
  marble->setAngularFactor(0);
  marble->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(5.0);
  int found = 0;
  for (const SoftContact& c : cube->contacts()) {
    if (c.other != marble) continue;
    ++found;
    ASSERT_LT(c.side.triangle, cube->network().surface.size());
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(c.side.points[i], cube->network().surface[c.side.triangle][i]);
      point += c.side.weights[static_cast<int>(i)] * cube->position(c.side.points[i]);
    }
    EXPECT_NEAR(c.side.weights.sum(), 1.0, 1e-12);
    // positions of up to 1 m in floats
    EXPECT_LT((eigen(c.position + btScalar(kRadius) * c.normal) - point).norm(), 1e-6);
    EXPECT_LT((eigen(c.position - btScalar(c.distance + r) * c.normal) -
               eigen(marble->getWorldTransform().getOrigin()))
                  .norm(),
              1e-5);
    EXPECT_NEAR(c.impulse.y(), -0.05 * kWeight * kTick, kTolerance * 0.05 * kWeight * kTick);
  }
  EXPECT_EQ(found, 1);
}

TEST(ContactTruth, pointsNameThemselvesAndTheFloor) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addPlaneFloor();
  SoftBody* cube = addClosedCube(bullet.system, 0.5 + kRadius);
  bullet.simulate(5.0);
  ASSERT_EQ(cube->contacts().size(), 4u);
  for (const SoftContact& c : cube->contacts()) {
    EXPECT_EQ(c.other, floor);
    EXPECT_EQ(c.otherBody, nullptr);
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i)
      point += c.side.weights[static_cast<int>(i)] * cube->position(c.side.points[i]);
    // one radius above the floor, within float rounding
    EXPECT_NEAR(point.y(), kRadius, 1e-5);
    EXPECT_NEAR(c.distance, 0.0, 1e-5);
    if (!kSurface) {
      EXPECT_EQ(c.side.triangle, ContactSide::kNone);
      continue;
    }
    const Triangle& t = cube->network().surface[c.side.triangle];
    const Eigen::Vector3d a = cube->position(t[0]);
    const Eigen::Vector3d normal = (cube->position(t[1]) - a).cross(cube->position(t[2]) - a).normalized();
    EXPECT_LT(normal.y(), -0.99);  // the bottom face
  }
}

TEST(ContactTruth, aSleepingBodyKeepsItsContactsUntilTheirPartnerGoes) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addBoxFloor();
  SoftBody* cube = bullet.addSoft(fullCubeNetwork(), weighedSettings(0.5 + kRadius));
  bullet.simulate(15.0);
  ASSERT_TRUE(cube->sleeping());
  EXPECT_EQ(cube->contacts().size(), 4u);
  bullet.world->removeRigidBody(floor);
  EXPECT_TRUE(cube->contacts().empty());
}

TEST(ContactTruth, contactsOfAWorldThatIsGoneAreGone) {
  auto bullet = std::make_unique<BulletWorld>();
  bullet->addBoxFloor();
  SoftBodySystem system(*bullet->world);
  SoftBody* cube = addWeighedCube(system);
  bullet->simulate(1.0);
  EXPECT_FALSE(cube->contacts().empty());
  bullet.reset();
  EXPECT_TRUE(cube->contacts().empty());
}

TEST(ContactTruth, equalRunsTellTheSameBitForBit) {
  const auto run = [] {
    std::vector<double> values;
    SoftWorld bullet;
    bullet.addBoxFloor();
    SoftBody* bodies[] = {addClosedCube(bullet.system, 0.6), addClosedCube(bullet.system, 1.8)};
    bullet.addBox(vec(0.2, 0.2, 0.2), 1, vec(0.1, 3, 0));
    for (int i = 0; i < 120; ++i) {
      bullet.tick(kTick);
      for (const SoftBody* body : bodies)
        for (const SoftContact& c : body->contacts()) {
          values.push_back(c.normalImpulse);
          values.push_back(c.distance);
          values.push_back(double(c.position.x()));
          values.push_back(c.side.triangle);
        }
    }
    return values;
  };
  const std::vector<double> first = run();
  EXPECT_GT(first.size(), 1000u);
  EXPECT_EQ(first, run());
}

TEST(ContactTruth, askingAllocatesNothingAfterWarmUp) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  ContactListener listener;
  bullet.system.setContactListener(&listener);
  bullet.system.reportManifolds(true);
  std::vector<SoftBody*> bodies;
  for (int i = 0; i < 4; ++i)
    bodies.push_back(addClosedCube(bullet.system, 0.5 + kRadius + i * (1 + 2 * kRadius)));
  bullet.addAwakeBox(vec(0.2, 0.2, 0.2), 1, vec(0.1, 5, 0));
  // until all bodies are at rest
  bullet.simulate(8.0);
  const AllocationCounter counter;
  std::size_t contacts = 0;
  for (int i = 0; i < 60; ++i) {
    bullet.tick(kTick);
    for (const SoftBody* body : bodies) contacts += body->contacts().size();
  }
  EXPECT_EQ(counter.allocations(), 0u);
  EXPECT_GT(contacts, 0u);
}

}  // namespace
}  // namespace limber::test
