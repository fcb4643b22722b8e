// SPDX-License-Identifier: Zlib
// Bullet's filters, and shapes that change under a body at rest.
#include "support/soft_world.h"

#include <cmath>
#include <memory>
#include <utility>

namespace limber::test {
namespace {

// --- filters -----------------------------------------------------------------------------------------------

/// Rejects all pairs that contain this object.
struct Excluding final : btOverlapFilterCallback {
  const btCollisionObject* object = nullptr;
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    return a->m_clientObject != object && b->m_clientObject != object &&
           (a->m_collisionFilterGroup & b->m_collisionFilterMask) &&
           (b->m_collisionFilterGroup & a->m_collisionFilterMask);
  }
};

TEST(OverlapFilter, isAskedForWhatSoftBodiesTouch) {
  BulletWorld bullet;
  Excluding filter;
  bullet.world->getPairCache()->setOverlapFilterCallback(&filter);
  filter.object = bullet.addBoxFloor();
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = settingsAt({0, 2.0, 0});
  s.linearVelocity = {0, -30, 0};  // beyond the boxes that the broadphase has computed
  SoftBody* body = *system.createBody(closedCubeNetwork(), s);
  bullet.simulate(1.0);
  // free fall, within Bullet's rounding and the first half tick
  EXPECT_NEAR(body->centerOfMass().y(), 2.0 - 30.0 - 0.5 * 9.81, 0.15);
}

TEST(OverlapFilter, keepsASleeperAsleep) {
  BulletWorld bullet;
  Excluding filter;
  bullet.world->getPairCache()->setOverlapFilterCallback(&filter);
  bullet.addBoxFloor();
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = settingsAt({0, 0.52, 0});
  s.damping = 5.0;
  SoftBody* body = *system.createBody(closedCubeNetwork(), s);
  for (int i = 0; i < 600 && !body->sleeping(); ++i) bullet.tick();
  ASSERT_TRUE(body->sleeping());
  btRigidBody* bullets = bullet.addBox(vec(0.05, 0.05, 0.05), 1.0, vec(-5, 0.5, 0));
  bullet.world->removeRigidBody(bullets);
  filter.object = bullets;
  bullet.world->addRigidBody(bullets);
  bullets->setGravity(btVector3(0, 0, 0));
  bullets->setLinearVelocity(btVector3(60, 0, 0));
  for (int i = 0; i < 12; ++i) {
    bullet.tick();
    ASSERT_TRUE(body->sleeping()) << "tick " << i;
  }
  EXPECT_GT(double(bullets->getWorldTransform().getOrigin().x()), 5.0) << "it has flown through";
}

TEST(NoContactResponse, ofTheSoftBodyItselfIsHonoured) {
  if (!kSurface) GTEST_SKIP() << "a point mass has a flag of its own, which Bullet honours";
  SoftWorld bullet;
  bullet.addBoxFloor();
  btRigidBody* box = bullet.addBox(vec(0.2, 0.2, 0.2), 1.0, vec(0, 0.2, 0));
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), settingsAt({0, 2.0, 0}));
  body->surfaceObject()->setCollisionFlags(body->surfaceObject()->getCollisionFlags() |
                                           btCollisionObject::CF_NO_CONTACT_RESPONSE);
  bullet.simulate(1.0);
  EXPECT_LT(body->centerOfMass().y(), -2.5);
  EXPECT_NEAR(heightOf(*box), 0.2, 0.01);
}

TEST(NoContactResponse, betweenSoftBodiesTheOrderOfCreationIsTheSame) {
  if (!kSurface) GTEST_SKIP() << "a point mass has a flag of its own, which Bullet honours";
  for (const bool lowerFirst : {true, false})
    for (const bool ghostIsLower : {true, false}) {
      SoftWorld bullet(0.0);
      SoftBody* first = bullet.addSoft(closedCubeNetwork(), settingsAt({0, lowerFirst ? 0.0 : 1.3, 0}));
      SoftBody* second = bullet.addSoft(closedCubeNetwork(), settingsAt({0, lowerFirst ? 1.3 : 0.0, 0}));
      SoftBody *lower = lowerFirst ? first : second, *upper = lowerFirst ? second : first;
      btRigidBody* ghost = (ghostIsLower ? lower : upper)->surfaceObject();
      ghost->setCollisionFlags(ghost->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
      for (std::uint32_t i = 0; i < upper->pointCount(); ++i)
        upper->point(i)->setLinearVelocity(vec(0, -2, 0));
      bullet.simulate(1.0);
      EXPECT_EQ(lower->linearMomentum().norm(), 0.0) << lowerFirst << ghostIsLower;
    }
}

// --- shapes that change ------------------------------------------------------------------------------------

/// A cube at rest on a hull.
struct RestingCube {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addHullFloor();
  SoftBody* body = nullptr;
  double before = 0.0;  ///< m, height of its centre

  RestingCube() {
    SoftBodySettings s = settingsAt({0, 0.55, 0});
    s.damping = 5.0;
    body = bullet.addSoft(closedCubeNetwork(), s);
    body->point(0)->setActivationState(DISABLE_DEACTIVATION);
    bullet.simulate(1.0);
    before = body->centerOfMass().y();
  }
};

TEST(ChangedShape, aHullThatGrowsLiftsWhatRestsOnIt) {
  RestingCube scene;
  auto& [bullet, floor, body, before] = scene;
  btVector3 low, high, lowAfter, highAfter;
  floor->getCollisionShape()->getAabb(floor->getWorldTransform(), low, high);
  floor->getCollisionShape()->setLocalScaling(vec(1, 1.01, 1));
  floor->getCollisionShape()->getAabb(floor->getWorldTransform(), lowAfter, highAfter);
  bullet.simulate(3.0);
  const double raised = double(highAfter.y() - high.y());
  ASSERT_GT(raised, 0.004);
  // the tolerance is a tenth: contacts that push a point out may be this deep
  EXPECT_NEAR(body->centerOfMass().y() - before, raised, 0.1 * raised);
}

TEST(ChangedShape, cornersMovedWithinTheBoundingBoxAreSeen) {
  if (!kSurface) GTEST_SKIP() << "Bullet's own manifold keeps the contact, as under a rigid body";
  RestingCube scene;
  auto& [bullet, floor, body, before] = scene;
  // the bounding box stays the same; the top under the cube sinks by 0.1 m
  auto& hull = *static_cast<btConvexHullShape*>(floor->getCollisionShape());
  const auto box = [&] {
    btVector3 low, high;
    hull.recalcLocalAabb();
    hull.getAabb(btTransform::getIdentity(), low, high);
    return std::make_pair(low, high);
  };
  const auto boxBefore = box();
  for (int i = 0; i < hull.getNumPoints(); ++i)
    if (hull.getUnscaledPoints()[i].y() > 0 && hull.getUnscaledPoints()[i].x() > 0)
      hull.getUnscaledPoints()[i].setY(hull.getUnscaledPoints()[i].y() - btScalar(0.2));
  ASSERT_EQ(box(), boxBefore);
  bullet.simulate(0.2);
  EXPECT_LT(body->centerOfMass().y(), before - 0.03);
}

TEST(ChangedShape, anIdThatTheBroadphaseUsesAgainIsAnotherObject) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btAxisSweep3 broadphase(btVector3(-100, -100, -100), btVector3(100, 100, 100));
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(btVector3(0, btScalar(-9.81), 0));
  btConvexHullShape hull;
  for (int i = 0; i < 8; ++i) hull.addPoint(vec(i & 1 ? 5 : -5, i & 2 ? 0 : -1, i & 4 ? 5 : -5), i == 7);
  SoftBodySystem system(world);
  const auto floorAt = [&](double y) {
    auto floor = std::make_unique<btRigidBody>(0, nullptr, &hull);
    floor->getWorldTransform().setOrigin(vec(0, y, 0));
    world.addRigidBody(floor.get());
    return floor;
  };
  auto floor = floorAt(0.0);
  SoftBodySettings s = settingsAt({0, 0.56, 0});
  s.damping = 5.0;
  SoftBody* body = *system.createBody(closedCubeNetwork(), s);
  body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  for (int i = 0; i < 60; ++i) world.stepSimulation(btScalar(kTick), 0);
  const int id = floor->getBroadphaseHandle()->m_uniqueId;
  world.removeRigidBody(floor.get());
  floor = floorAt(-0.5);
  EXPECT_EQ(floor->getBroadphaseHandle()->m_uniqueId, id);
  const double before = body->centerOfMass().y();
  for (int i = 0; i < 12; ++i) world.stepSimulation(btScalar(kTick), 0);
  // free fall over 0.2 s
  EXPECT_NEAR(body->centerOfMass().y(), before - 0.5 * 9.81 * 0.2 * 0.2, 0.03);
  system.removeAll();
  world.removeRigidBody(floor.get());
}

/// Whatever else has changed since the last tick, as here the springs.
TEST(RemovedObject, endsTheBodyBeforeItIsSearchedForContacts) {
  for (const bool isFirst : {true, false}) {
    SoftWorld bullet;
    SoftBodySettings s = testedSettings();
    s.selfCollision = kSurface;
    SoftBody *cloth = bullet.addSoft(*buildCloth(), s), *other = bullet.addSoft(*buildCloth(), s);
    SpringConstraint* spring = *bullet.system.addSpring({nullptr}, {other->point(0)});
    bullet.tick();
    btRigidBody* object = cloth->surfaceObject() ? cloth->surfaceObject() : cloth->point(3);
    if (isFirst) bullet.world->removeRigidBody(object);
    ASSERT_TRUE(bullet.system.removeSpring(spring));
    if (!isFirst) bullet.world->removeRigidBody(object);
    bullet.simulate(0.2);
    EXPECT_FALSE(cloth->alive());
    EXPECT_TRUE(other->alive());
  }
}

}  // namespace
}  // namespace limber::test
