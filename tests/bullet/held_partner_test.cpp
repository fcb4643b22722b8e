// SPDX-License-Identifier: Zlib
// Anchors and springs to bodies that nothing moves but the user: static, kinematic and frozen ones. Pins.
#include "support/soft_world.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace limber::test {
namespace {

enum class Link { Anchor, Spring };
enum class Held { Static, Kinematic, Disabled };

/// Makes a body of the world held, at its place.
void hold(BulletWorld& bullet, btRigidBody& body, Held how) {
  if (how == Held::Disabled) return body.forceActivationState(DISABLE_SIMULATION);
  if (how == Held::Kinematic)
    return body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  bullet.world->removeRigidBody(&body);
  body.setMassProps(0, vec(0, 0, 0));
  bullet.world->addRigidBody(&body);
}

void place(btRigidBody& body, const btVector3& position) {
  body.setWorldTransform(btTransform(btQuaternion::getIdentity(), position));
  body.setInterpolationWorldTransform(body.getWorldTransform());
}

/// A body that hangs from, or carries, a box of 2 kg.
struct LinkedToBox {
  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};
  SoftBody* soft;
  btRigidBody* box;

  LinkedToBox(const SharedNetwork& network, const SoftBodySettings& s, std::uint32_t point,
              const btVector3& boxAt, Link link, double gravity)
      : bullet(gravity), soft(*system.createBody(network, s)) {
    box = bullet.addBox(vec(0.2, 0.2, 0.2), 2.0, boxAt);
    box->setActivationState(DISABLE_DEACTIVATION);
    SpringSettings spring;
    spring.stiffness = 5000.0;
    spring.damping = 10.0;
    if (link == Link::Anchor)
      EXPECT_TRUE(system.attach(soft, point, *box));
    else
      EXPECT_TRUE(system.addSpring({soft->point(point)}, {box}, spring));
  }

  double energy() const { return energyOf(*soft); }
};

/// Streaming of levels, or a shift of the origin: nothing has moved.
TEST(HeldPartners, placedTogetherWithABodyTheyDoNotPullIt) {
  for (const Link link : {Link::Anchor, Link::Spring})
    for (const Held how : {Held::Static, Held::Kinematic, Held::Disabled})
      for (const double distance : {5.0, 500.0}) {
        LinkedToBox s(closedCubeNetwork(), testedSettings(), 0, vec(0, 2, 0), link, 0.0);
        hold(s.bullet, *s.box, how);
        s.bullet.simulate(0.2);
        place(*s.box, vec(distance, 2, 0));
        btTransform pose = s.soft->transform();
        pose.setOrigin(pose.getOrigin() + vec(distance, 0, 0));
        ASSERT_TRUE(s.soft->setTransform(pose));
        s.bullet.simulate(0.2);
        // 1e-4 m of rounding at 500 m
        EXPECT_LT(s.energy(), 1e-3) << int(link) << int(how) << " " << distance;
      }
}

/// A cutscene freezes what swings on a rope. The rope has 1.5 J, and falls by some centimetres.
TEST(HeldPartners, areFrozenWhereTheyAre) {
  for (const Link link : {Link::Anchor, Link::Spring})
    for (const Held how : {Held::Static, Held::Kinematic, Held::Disabled}) {
      SoftBodySettings settings = settingsAt({0, 5, 0});
      setSprings(settings, 5000.0, 10.0);
      LinkedToBox s(chainNetwork(8), settings, 8, vec(0, 3.9, 0), link, -9.81);
      s.soft->pin(0);
      s.bullet.simulate(1.0);
      s.box->setLinearVelocity(vec(3, 0, 0));
      s.bullet.simulate(0.3);
      const double before = s.energy();
      hold(s.bullet, *s.box, how);
      for (int i = 0; i < 60; ++i) {
        s.bullet.tick();
        ASSERT_LT(s.energy(), before + 1.0) << int(link) << int(how) << " tick " << i;
      }
    }
}

TEST(HeldPartners, pullWithTheForceOfTheAcceleration) {
  for (const double acceleration : {2.0, 20.0}) {
    SoftBodySettings settings = testedSettings();
    settings.totalMass = 2.0;
    settings.damping = 20.0;
    LinkedToBox s(closedCubeNetwork(), settings, 0, vec(0, 2, 0), Link::Anchor, -9.81);
    for (std::uint32_t i = 1; i < 8; ++i) ASSERT_TRUE(s.system.attach(s.soft, i, *s.box));
    hold(s.bullet, *s.box, Held::Kinematic);
    double height = 2.0, speed = 0.0, force = 0.0;
    for (int i = 0; i < 60; ++i) {
      speed += acceleration / 60.0;
      height += speed / 60.0;
      s.box->setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(0, height, 0)));
      s.bullet.tick();
      force = 0.0;
      for (std::uint32_t p = 0; p < 8; ++p) force += double(s.soft->anchorForce(p).y());
    }
    // all points move with the box; its heights are rounded
    EXPECT_NEAR(force, 2.0 * (9.81 + acceleration), 0.02);
  }
}

// --- pins --------------------------------------------------------------------------------------------------

/// Bodies whose shape springs, an inner pressure or tetrahedra keep.
std::vector<std::pair<SharedNetwork, SoftBodySettings>> bodiesOnPins() {
  SoftBodySettings s = testedSettings();
  s.totalMass = 2.0;
  s.damping = 3.0;
  SoftBodySettings inflated = s;
  inflated.pressure = 200.0;
  return {{closedCubeNetwork(), s},
          {closedCubeNetwork(), inflated},
          {tetrahedralCubeNetwork(), s},
          {clothNetwork(6, 6), s}};
}

// It falls within the tick and takes along what lies on it; Bullet's rigid bodies stay 14 mm deep at 1/60 s.
TEST(HeldPartners, carryWhatLiesOnThemWhenTheyArePlacedEachTick) {
  for (const double mass : {5.0, 500.0})
    for (const double tick : {1.0 / 60.0, 1.0 / 120.0}) {
      SoftWorld bullet;
      SoftBodySettings s = testedSettings();
      s.scale.setConstant(0.4);
      s.damping = 5.0;
      s.position = {0, 1.31, 0};
      SoftBody* cube = bullet.addSoft(fullCubeNetwork(), s);
      btRigidBody* tray = bullet.addAwakeBox(vec(0.5, 0.1, 0.5), btScalar(mass), vec(0, 1, 0));
      for (int i = 0; i * tick < 4.0; ++i) {
        place(*tray, vec(0, 1, 0));
        tray->setLinearVelocity(vec(0, 0, 0));
        tray->setAngularVelocity(vec(0, 0, 0));
        bullet.tick(tick);
      }
      EXPECT_NEAR(cube->centerOfMass().y(), 1.3, 0.014) << mass << " kg, tick " << tick;
    }
}

/// The mean force in a second is the weight and the change of momentum per time, however the bodies swing.
TEST(PinForce, bearsTheWeightAndChangesTheMomentum) {
  constexpr double kShort = 1.0 / 240.0;
  for (const auto& [network, settings] : bodiesOnPins()) {
    SoftWorld bullet;
    SoftBody* body = bullet.addSoft(network, settings);
    EXPECT_EQ(body->pinForce(0), vec(0, 0, 0));
    for (const std::uint32_t i : {0u, 3u}) ASSERT_TRUE(body->pin(i));
    bullet.simulate(2.0);
    const std::uint64_t hash = body->stateHash();
    const Eigen::Vector3d start = body->linearMomentum();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (int i = 0; i < 240; ++i) {
      // the forces of both ends of the tick
      const auto force = [&] { return eigen(body->pinForce(0) + body->pinForce(3)); };
      const Eigen::Vector3d before = force();
      ASSERT_TRUE(i > 0 || body->stateHash() == hash);
      bullet.tick(kShort);
      mean += 0.5 * kShort * (before + force());
    }
    const Eigen::Vector3d expected = body->linearMomentum() - start + Eigen::Vector3d(0, 2.0 * 9.81, 0);
    // the forces of a swing change by some percent in a tick, and the mean of both ends is right to second
    // order
    EXPECT_LT((mean - expected).norm(), 0.005 * 2.0 * 9.81);
  }
}

}  // namespace
}  // namespace limber::test
