// SPDX-License-Identifier: Zlib
// Objects and soft bodies without contact response: they are reported and push nothing. Bullet's own soft
// bodies in the same world.
#include "support/allocation_counter.h"
#include "support/soft_world.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <algorithm>
#include <memory>
#include <string>

namespace limber::test {
namespace {

SoftBody* addSensedCube(SoftBodySystem& system, double y) {
  SoftBodySettings s = settingsAt({0, y, 0});
  setSprings(s, 5000, 20);
  s.pointRadius = kRadius;
  return *system.createBody(closedCubeNetwork(), s);
}

struct SensorCalls : ContactListener {
  std::string calls;
  const btCollisionObject* other = nullptr;
  void contactBegins(const ContactPair& pair) override { calls += 'b', other = pair.other; }
  void contactEnds(const ContactPair&) override { calls += 'e'; }
};

/// Drops a cube through an object and checks that it falls freely, and that it is reported once.
void expectSensed(BulletWorld& bullet, const btCollisionObject& sensor) {
  SoftBodySystem system(*bullet.world);
  SensorCalls calls;
  system.setContactListener(&calls);
  SoftBody* cube = addSensedCube(system, 2.0);
  for (int i = 0; i < 60; ++i) {
    bullet.tick();
    for (const SoftContact& c : cube->contacts()) {
      EXPECT_EQ(c.other, &sensor);
      EXPECT_EQ(c.normalImpulse, 0.0);
      EXPECT_NEAR(c.side.weights.sum(), 1.0, 1e-6);
    }
  }
  EXPECT_EQ(calls.calls, "be");
  EXPECT_EQ(calls.other, &sensor);
  EXPECT_NEAR(cube->centerOfMass().y(), 2.0 - 0.5 * kGravity, 0.1);
  system.setContactListener(nullptr);
}

TEST(Sensors, aBoxWithoutResponseReportsACube) {
  BulletWorld bullet;
  btRigidBody* box = bullet.addBox(vec(2, 0.6, 2), 0, vec(0, 0, 0));
  box->setCollisionFlags(box->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  expectSensed(bullet, *box);
}

TEST(SurfaceSensors, aGhostSmallerThanATriangleReportsACube) {
  BulletWorld bullet;
  btSphereShape shape(btScalar(0.05));
  btGhostObject ghost;
  ghost.setCollisionShape(&shape);
  ghost.setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
  ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(0.5, 0, 0.21)));
  bullet.world->addCollisionObject(&ghost);
  expectSensed(bullet, ghost);
  bullet.world->removeCollisionObject(&ghost);
}

TEST(SurfaceSensors, aSoftBodyCanBeASensor) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addBoxFloor();
  SoftBody* cube = addSensedCube(bullet.system, 0.7);
  SoftBody* solid = addSensedCube(bullet.system, 2.0);
  cube->surfaceObject()->setCollisionFlags(cube->surfaceObject()->getCollisionFlags() |
                                           btCollisionObject::CF_NO_CONTACT_RESPONSE);
  bool touchesFloor = false, touchesSolid = false;
  for (int i = 0; i < 60; ++i) {
    bullet.tick();
    for (const SoftContact& c : cube->contacts()) {
      touchesFloor = touchesFloor || c.other == floor;
      touchesSolid = touchesSolid || c.otherBody == solid;
      EXPECT_TRUE(c.impulse.isZero());
    }
    if (i == 20) cube->setTransform(btTransform(btQuaternion::getIdentity(), vec(0, 0.3, 0)));
  }
  EXPECT_TRUE(touchesFloor);
  EXPECT_LT(cube->centerOfMass().y(), -0.5) << "it falls through the floor";
  EXPECT_NEAR(lowest(*solid), kRadius, 0.05) << "which holds the other one";
}

TEST(SurfaceSensors, aTickAllocatesNothing) {
  SoftWorld bullet;
  bullet.addPlaneFloor();
  btRigidBody* zone = bullet.addBox(vec(0.4, 0.4, 0.4), 0, vec(0.5, 0.5, 0.3));
  zone->setCollisionFlags(zone->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  SoftBody* cube = addSensedCube(bullet.system, 0.5 + kRadius);
  cube->surfaceObject()->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(1.0);
  EXPECT_EQ(allocationsIn([&] { bullet.simulate(0.5); }), 0u);
  const auto isZone = [&](const SoftContact& c) { return c.other == zone; };
  EXPECT_TRUE(std::any_of(cube->contacts().begin(), cube->contacts().end(), isZone));
}

// --- Bullet's soft bodies ----------------------------------------------------------------------------------

TEST(Sensors, bulletsOwnSoftBodiesAreIgnored) {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(btVector3(0, -10, 0));
  world.getWorldInfo().m_gravity = btVector3(0, -10, 0);
  btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
  btRigidBody floor(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane));
  world.addRigidBody(&floor);
  btSoftBody* theirs = btSoftBodyHelpers::CreateEllipsoid(world.getWorldInfo(), btVector3(0, 1.5, 0),
                                                          btVector3(1, 1, 1) * btScalar(0.5), 128);
  world.addSoftBody(theirs);
  SoftBodySystem system(world);
  SoftBody* ours = addSensedCube(system, 0.6);
  for (int i = 0; i < 120; ++i) world.stepSimulation(btScalar(1) / 60, 0);
  EXPECT_NEAR(lowest(*ours), kRadius, 0.02);
  EXPECT_EQ(ours->restorations(), 0u);
  for (const SoftContact& c : ours->contacts()) EXPECT_EQ(c.other, &floor);
  btScalar top = -10;
  for (int i = 0; i < theirs->m_nodes.size(); ++i) top = btMax(top, theirs->m_nodes[i].m_x.y());
  EXPECT_LT(double(top), 0.9) << "it falls through the cube, of which the top is at 1.04 m";
  world.removeSoftBody(theirs);
  delete theirs;
  world.removeRigidBody(&floor);
}

TEST(Sensors, aSoftBodyWithoutResponseIsReportedWithBothSides) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.collision = Collision::Surface;
  SoftBody* sensor = bullet.addSoft(closedCubeNetwork(), s);
  sensor->surfaceObject()->setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
  s.position = {0, 0.8, 0};
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
  bullet.tick();
  ASSERT_FALSE(cube->contacts().empty());
  for (const SoftContact& c : cube->contacts()) {
    EXPECT_EQ(c.otherBody, sensor);
    EXPECT_NEAR(c.side.weights.sum(), 1.0, 1e-6);
    EXPECT_NEAR(c.otherSide.weights.sum(), 1.0, 1e-6);
  }
}

TEST(SurfaceSensors, softBodiesReportEachOtherAlike) {
  SoftWorld bullet(0.0);
  SoftBody* sensor = addSensedCube(bullet.system, 0.0);
  SoftBody* cube = addSensedCube(bullet.system, 1.2);
  sensor->surfaceObject()->setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
  ASSERT_TRUE(cube->setVelocity(vec(0, -1, 0), vec(0, 0, 0)));
  ASSERT_TRUE(sensor->setTransform(btTransform(btQuaternion(vec(0, 1, 0), btScalar(0.7)), vec(0, 0, 0))));
  int ticksInContact = 0;
  for (int i = 0; i < 90; ++i) {
    bullet.tick();
    const std::size_t contacts = cube->contacts().size();
    ASSERT_EQ(sensor->contacts().size(), contacts) << "tick " << i;
    for (std::size_t c = 0; c < contacts; ++c) EXPECT_EQ(sensor->contacts()[c].otherBody, cube);
    ticksInContact += contacts > 0;
  }
  EXPECT_GE(ticksInContact, 75)
      << "from the twelfth tick on; their corners stay far from the other one's faces";
}

// --- the profile -------------------------------------------------------------------------------------------

TEST(Profile, countsTheWorkOfTheTick) {
  SoftWorld bullet;
  bullet.addPlaneFloor();
  bullet.addBox(vec(1, 0.2, 1), 2.0, vec(0, 1.3, 0));
  SoftBody* cube = addSensedCube(bullet.system, 0.5 + kRadius);
  SoftBodySettings far = cube->settings();
  far.position = {30, 5, 0};
  SoftBody* alone = bullet.addSoft(closedCubeNetwork(), far);
  bullet.simulate(0.3);
  const TickProfile& p = bullet.system.profile();
  EXPECT_EQ(p.awakeBodies, 2u);
  EXPECT_EQ(p.pointsStepped, 16u);
  EXPECT_EQ(p.substeps, static_cast<std::size_t>(cube->substeps() + alone->substeps()));
  EXPECT_EQ(p.islands, 1u) << "the cube under the box";
  EXPECT_GE(p.contacts, 8u) << "four on the floor, four under the box";
  EXPECT_GT(p.searchMs, 0.0);
  EXPECT_GT(p.islandsMs, 0.0);
  EXPECT_GT(p.chooseMs, 0.0);
  EXPECT_NEAR(p.totalMs(),
              p.readMs + p.searchMs + p.islandsMs + p.chooseMs + p.stepMs + p.writeMs + p.readBackMs, 1e-9);
  TickProfile twice = p;
  twice += p;
  EXPECT_EQ(twice.totalMs(), 2.0 * p.totalMs());
  EXPECT_EQ(twice.springSubsteps, 2 * p.springSubsteps);
}

TEST(Profile, bodiesThatAreSteppedTogetherHaveOneIsland) {
  SoftWorld bullet;
  bullet.addPlaneFloor();
  SoftBody* apart = addSensedCube(bullet.system, 0.5 + kRadius);
  SoftBodySettings s = apart->settings();
  SoftBody* others[4];  // one on another, two under a box
  for (int i = 0; i < 4; ++i) {
    s.position = {i < 2 ? 3.0 : 4.5 + 1.5 * i, 0.5 + kRadius + (i == 1 ? 1 + 2 * kRadius : 0.0), 0};
    others[i] = bullet.addSoft(closedCubeNetwork(), s);
  }
  bullet.addBox(vec(2, 0.1, 0.5), 1.0, vec(8.25, 1.1 + 2 * kRadius, 0));
  EXPECT_EQ(apart->island(), -1) << "before the first tick";
  bullet.simulate(0.3);
  EXPECT_EQ(others[0]->island(), others[1]->island());
  EXPECT_EQ(others[2]->island(), others[3]->island()) << "the box couples them";
  EXPECT_NE(others[0]->island(), others[2]->island());
  EXPECT_NE(apart->island(), others[0]->island());
  EXPECT_GE(apart->island(), 0);
  ASSERT_TRUE(bullet.system.addSpring({apart->point(0)}, {others[0]->point(0)}));
  bullet.tick();
  EXPECT_EQ(apart->island(), others[1]->island()) << "a spring couples them";
}

}  // namespace
}  // namespace limber::test
