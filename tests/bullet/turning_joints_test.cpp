// SPDX-License-Identifier: Zlib
// Joints between rigid bodies to which a soft body is attached keep momentum and energy while they turn.
#include "support/soft_world.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace limber::test {
namespace {

using Eigen::Vector3d;

using Make = std::function<btTypedConstraint*(btRigidBody&, btRigidBody&)>;

struct NamedJoint {
  std::string name;
  Make make;
  double tolerance = 1e-3;  ///< of momentum and energy
  double gap = 1e-4;        ///< m
};

/// Bullet locks an axis with two equal limits only once it is beyond them: a tick too late.
constexpr double kLateTolerance = 5e-3, kLateGap = 2e-3;

btTransform frameAt(double x) {
  btTransform frame;
  frame.setIdentity();
  frame.setOrigin(vec(x, 0, 0));
  return frame;
}

/// All joints of Bullet that hold two pivots together.
std::vector<NamedJoint> joints() {
  return {
      {"point to point",
       [](btRigidBody& a, btRigidBody& b) {
         return new btPoint2PointConstraint(a, b, vec(0.2, 0, 0), vec(-0.2, 0, 0));
       }},
      {"hinge",
       [](btRigidBody& a, btRigidBody& b) {
         return new btHingeConstraint(a, b, vec(0.2, 0, 0), vec(-0.2, 0, 0), vec(0, 0, 1), vec(0, 0, 1));
       }},
      {"fixed", [](btRigidBody& a,
                   btRigidBody& b) { return new btFixedConstraint(a, b, frameAt(0.2), frameAt(-0.2)); }},
      {"cone", [](btRigidBody& a,
                  btRigidBody& b) { return new btConeTwistConstraint(a, b, frameAt(0.2), frameAt(-0.2)); }},
      {"six degrees",
       [](btRigidBody& a, btRigidBody& b) {
         auto* joint = new btGeneric6DofConstraint(a, b, frameAt(0.2), frameAt(-0.2), true);
         joint->setAngularLowerLimit(vec(0, 0, 0)), joint->setAngularUpperLimit(vec(0, 0, 0));
         return joint;
       },
       kLateTolerance, kLateGap},
      {"slider that is locked",
       [](btRigidBody& a, btRigidBody& b) {
         auto* joint = new btSliderConstraint(a, b, frameAt(0.2), frameAt(-0.2), true);
         joint->setLowerLinLimit(0), joint->setUpperLinLimit(0);
         return joint;
       },
       kLateTolerance, kLateGap}};
}

RopeSettings ropeOf(std::uint32_t segments) {
  RopeSettings rope;
  rope.length = 0.4;
  rope.segments = segments;
  return rope;
}

/// Settings of a stiff rope that begins at x and touches nothing.
SoftBodySettings undamped(double mass, double x) {
  SoftBodySettings s = settingsAt({x, 0.1, 0.0});
  setSprings(s, 2e4, 0.0);
  s.totalMass = mass;
  s.collisionMask = 0;
  return s;
}

/// Two jointed boxes with a taut rope between them, which spin without gravity.
struct SpinningPair {
  SpinningPair(const NamedJoint& type, double spin) : bullet(0.0), system(*bullet.world) {
    for (const double x : {-0.2, 0.2})
      bodies.push_back(bullet.addBox(vec(0.15, 0.05, 0.05), 3.0, vec(x, 0, 0)));
    joint.reset(type.make(*bodies[0], *bodies[1]));
    bullet.world->addConstraint(joint.get(), true);
    SoftBodySettings s = undamped(0.1, -0.2);
    s.angularVelocity = {0.0, spin, 0.0};
    soft = *system.createBody(*buildRope(ropeOf(2)), s);
    EXPECT_TRUE(system.attach(soft, 0, *bodies[0]));
    EXPECT_TRUE(system.attach(soft, 2, *bodies[1]));
    for (btRigidBody* body : bodies) {
      body->setActivationState(DISABLE_DEACTIVATION);
      body->setAngularVelocity(vec(0, spin, 0));
      body->setLinearVelocity(vec(0, spin, 0).cross(body->getCenterOfMassPosition()));
    }
  }
  ~SpinningPair() { bullet.world->removeConstraint(joint.get()); }
  SpinningPair(const SpinningPair&) = delete;
  SpinningPair& operator=(const SpinningPair&) = delete;

  Vector3d angularMomentum() const {
    Vector3d sum = soft->angularMomentum();
    for (const btRigidBody* body : bodies) sum += angularMomentumOf(*body);
    return sum;
  }
  double energy() const {
    double sum = energyOf(*soft);
    for (const btRigidBody* body : bodies) sum += kineticEnergyOf(*body);
    return sum;
  }
  double gap() const {
    const btVector3 a = bodies[0]->getWorldTransform() * vec(0.2, 0, 0),
                    b = bodies[1]->getWorldTransform() * vec(-0.2, 0, 0);
    return double((a - b).length());
  }

  BulletWorld bullet;
  SoftBodySystem system;
  std::vector<btRigidBody*> bodies;
  std::unique_ptr<btTypedConstraint> joint;
  SoftBody* soft = nullptr;
};

/// Bullet's own joints are solved along the directions at the start of a tick, and pull a body that turns
/// apart by (omega h)^2 / 2 of its arm, here 1 mm; the rope pulled it together again, at an angle. Bullet in
/// single precision rounds the poses to 1e-7.
TEST(TurningJoints, keepMomentumAndEnergy) {
  for (const NamedJoint& type : joints()) {
    SCOPED_TRACE(type.name);
    SpinningPair pair(type, 6.0);
    const Vector3d before = pair.angularMomentum();
    const double energy = pair.energy();
    double widest = 0.0;
    for (int i = 0; i < 180; ++i) {
      pair.bullet.tick();
      widest = std::max(widest, pair.gap());
    }
    EXPECT_LT((pair.angularMomentum() - before).norm(), type.tolerance * before.norm());
    EXPECT_NEAR(pair.energy(), energy, type.tolerance * energy);
    EXPECT_LT(widest, type.gap);
  }
}

/// An arm of two links that swings on a shoulder, with a rope along it.
TEST(TurningJoints, letALimbSwing) {
  SoftWorld bullet(-10.0);
  std::vector<btRigidBody*> links;
  for (const double x : {0.2, 0.6}) links.push_back(bullet.addBox(vec(0.15, 0.05, 0.05), 2.0, vec(x, 0, 0)));
  btPoint2PointConstraint shoulder(*links[0], vec(-0.2, 0, 0));
  btPoint2PointConstraint elbow(*links[0], *links[1], vec(0.2, 0, 0), vec(-0.2, 0, 0));
  bullet.world->addConstraint(&shoulder, true);
  bullet.world->addConstraint(&elbow, true);
  SoftBody* soft = bullet.addSoft(*buildRope(ropeOf(4)), undamped(0.2, 0.2));
  ASSERT_TRUE(bullet.system.attach(soft, 0, *links[0]));
  ASSERT_TRUE(bullet.system.attach(soft, 4, *links[1]));
  for (btRigidBody* link : links) link->setActivationState(DISABLE_DEACTIVATION);
  const auto energy = [&] {
    double sum = energyOf(*soft, 10.0);
    for (const btRigidBody* link : links) sum += energyOf(*link, 10.0);
    return sum;
  };
  const double before = energy();
  double least = before, most = before;
  for (int i = 0; i < 180; ++i) {
    bullet.tick();
    least = std::min(least, energy()), most = std::max(most, energy());
  }
  // of 20 J that it may lose; the rigid arm alone loses more than a joule
  EXPECT_LT(most - before, 0.05);
  EXPECT_GT(least - before, -0.1);
  bullet.world->removeConstraint(&shoulder);
  bullet.world->removeConstraint(&elbow);
}

}  // namespace
}  // namespace limber::test
