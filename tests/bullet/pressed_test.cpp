// SPDX-License-Identifier: Zlib
// A kinematic hand that presses something farther than it can yield: the forces stay finite.
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <algorithm>

namespace limber::test {
namespace {

/// A box that moves down to a height and stays there.
struct Hand {
  Hand(BulletWorld& bullet, const btVector3& half, const btVector3& at)
      : body(bullet.addBox(half, 0, at)), height(double(at.y())) {
    body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
  }
  void moveDown(double step, double lowest) {
    height = std::max(lowest, height - step);
    btTransform pose = body->getWorldTransform();
    pose.setOrigin(vec(double(pose.getOrigin().x()), height, double(pose.getOrigin().z())));
    body->setInterpolationWorldTransform(body->getWorldTransform());
    body->setWorldTransform(pose);
  }

  btRigidBody* body;
  double height;
};

/// N, between the two bodies.
double forceBetween(const BulletWorld& bullet, const btRigidBody* a, const btRigidBody* b, double tick) {
  double sum = 0.0;
  btDispatcher* dispatcher = bullet.world->getDispatcher();
  for (int m = 0; m < dispatcher->getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = *dispatcher->getManifoldByIndexInternal(m);
    if (std::minmax(manifold.getBody0(), manifold.getBody1()) != std::minmax<const btCollisionObject*>(a, b))
      continue;
    for (int i = 0; i < manifold.getNumContacts(); ++i)
      sum += double(manifold.getContactPoint(i).getAppliedImpulse()) / tick;
  }
  return sum;
}

/// A block of a kilogram on the floor that touches a small jelly. Bullet's solver presses such a block with
/// 70 N at 1/60 s, as its impulses end after ten iterations; here they end with the softness of contacts.
TEST(Pressed, aBlockOnTheFloorIsNotShotAway) {
  for (const double tick : {1.0 / 60, 1.0 / 240}) {
    SoftWorld bullet;
    bullet.addBoxFloor();
    btRigidBody* block = bullet.addAwakeBox(vec(0.1, 0.03, 0.1), 1.0, vec(0, 0.03, 0));
    SoftBodySettings s = testedSettings();
    s.totalMass = 0.2;
    s.damping = 1.0;
    s.scale.setConstant(0.06);
    s.pointRadius = 0.001;
    s.position = {0.1315, 0.031, 0};
    SoftBody* jelly = bullet.addSoft(closedCubeNetwork(), s);
    Hand hand(bullet, vec(0.03, 0.03, 0.03), vec(-0.05, 0.12, 0));
    double fastest = 0.0, strongest = 0.0;
    for (double t = 0.0; t < 2.0; t += tick) {
      hand.moveDown(0.1 * tick, 0.087);  // 3 mm too low
      bullet.tick(tick);
      fastest = std::max(fastest, double(block->getLinearVelocity().length()));
      strongest = std::max(strongest, forceBetween(bullet, block, hand.body, tick));
    }
    EXPECT_LT(fastest, 1.0) << tick;
    EXPECT_LT(strongest * tick, 400.0) << tick << ": the softness ends the impulse, whatever the tick";
    EXPECT_GT(strongest, 10.0) << tick;
    EXPECT_NEAR(jelly->centerOfMass().y(), 0.031, 0.003) << tick;
    EXPECT_NEAR(heightOf(*block), 0.0285, 0.002) << tick;
  }
}

/// Points between the hand and the floor, closer than the cloth is thick.
TEST(Pressed, aClothOnTheFloorIsNotPressedEverHarder) {
  SoftWorld bullet;
  btStaticPlaneShape plane(vec(0, 1, 0), 0);
  btRigidBody floor(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane));
  bullet.world->addRigidBody(&floor);
  SoftBodySettings s = settingsAt({0, 0.00404, 0});
  s.totalMass = 0.1;
  setSprings(s, 500.0, 0.05);
  s.pointRadius = 0.004;
  SoftBody* body = bullet.addSoft(squareCloth(14, 0.4), s);
  Hand hand(bullet, vec(0.03, 0.02, 0.03), vec(0, 0.06, 0));
  const auto press = [&](double seconds) {
    for (double t = 0.0; t < seconds; t += 1.0 / 60) {
      hand.moveDown(0.1 / 60, 0.0272);
      bullet.tick();
    }
    double force = 0.0;
    for (const SoftContact& contact : body->contacts())
      if (contact.other == hand.body) force += contact.normalImpulse * 60.0;
    return force;
  };
  const double early = press(1.0), late = press(1.0);
  EXPECT_GT(early, 1.0);
  EXPECT_LT(late, 1.5 * early);
  EXPECT_LT(late, 1e4);
  hand.body->setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(0, 1, 0)));
  hand.body->setInterpolationWorldTransform(hand.body->getWorldTransform());
  double highest = 0.0;
  for (int i = 0; i < 30; ++i) {
    bullet.tick();
    for (std::uint32_t p = 0; p < body->pointCount(); ++p) highest = std::max(highest, body->position(p).y());
  }
  EXPECT_LT(highest, 0.04) << "released, it does not jump";
  bullet.world->removeRigidBody(&floor);
}

}  // namespace
}  // namespace limber::test
