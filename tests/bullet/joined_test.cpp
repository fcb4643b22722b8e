// SPDX-License-Identifier: Zlib
// Soft bodies attached to rigid bodies that touch other objects or hang on joints of Bullet's. Energy does
// not rise, momentum is kept, and attached points stay in place.
#include "support/soft_world.h"
#include "support/variants.h"

#include <cmath>
#include <functional>
#include <memory>
#include <random>

namespace limber::test {
namespace {

SoftBodySettings lightlyDamped(double stiffness, double mass) {
  SoftBodySettings s = testedSettings();
  s.totalMass = mass;
  setSprings(s, stiffness, 0.04 * std::sqrt(stiffness * mass / 8));
  s.friction = 0.5;
  return s;
}

// --- attached, and in contact ------------------------------------------------------------------------------

struct Glued {
  btVector3 half, position;  ///< of the box
};

/// Lets a cube fall on the floor. One corner of it is attached to a box.
void expectNoEnergyIsGained(const Glued& glued, double stiffness) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBodySettings s = lightlyDamped(stiffness, 1.0);
  s.position = {0, 2.5, 0};
  SoftBody* cube = bullet.addSoft(fullCubeNetwork(), s);
  btRigidBody* box = bullet.addAwakeBox(glued.half, 3.0, glued.position);
  ASSERT_TRUE(bullet.system.attach(cube, 1, *box));
  const btVector3 pivot = box->getWorldTransform().inverse() * vec(0.5, 2.0, -0.5);
  const double start = energyOf(*cube, kGravity) + energyOf(*box, kGravity);
  double maxEnergy = start, separation = 0;
  for (int i = 0; i < 120; ++i) {
    bullet.tick();
    maxEnergy = std::max(maxEnergy, energyOf(*cube, kGravity) + energyOf(*box, kGravity));
    separation = std::max(separation, (cube->position(1) - eigen(box->getWorldTransform() * pivot)).norm());
  }
  EXPECT_LT(maxEnergy, 1.01 * start);
  // If Bullet finds a contact first, it stops the box alone for a tick, which at 7 m/s is 0.12 m. The
  // attachment then reduces the gap by a fifth in each tick.
  EXPECT_LT(separation, 0.12);
  EXPECT_LT((cube->position(1) - eigen(box->getWorldTransform() * pivot)).norm(), 0.02)
      << "they still tumble";
}

TEST(Glued, aCubeOnABoxNeverGainsEnergy) {
  const Glued scenes[] = {{vec(.3, .3, .3), vec(0.85, 1.65, 0.1)},
                          {vec(.5, .5, .5), vec(0.0, 1.4, 0.0)},
                          {vec(.4, .2, .6), vec(1.0, 2.0, 0.3)}};
  for (const Glued& glued : scenes)
    for (const double stiffness : variants({1e3, 1e6}, {1e5})) {
      SCOPED_TRACE(stiffness);
      expectNoEnergyIsGained(glued, stiffness);
    }
}

TEST(Glued, keepsMomentumInAHit) {
  for (const double stiffness : {1e3, 1e5}) {
    SoftWorld bullet(0.0);
    SoftBody* cube = bullet.addSoft(fullCubeNetwork(), lightlyDamped(stiffness, 1.0));
    btRigidBody* box = bullet.addBox(vec(.3, .3, .3), 3.0, vec(0.82, -0.5, -0.5));
    btRigidBody* ball = bullet.add(std::make_unique<btSphereShape>(btScalar(0.2)), 2.0, vec(2.5, -0.3, -0.4));
    for (btRigidBody* body : {box, ball}) body->setActivationState(DISABLE_DEACTIVATION);
    ball->setLinearVelocity(vec(-4, 0, 0));
    ASSERT_TRUE(bullet.system.attach(cube, 1, *box));
    const auto momentum = [&]() -> Eigen::Vector3d {
      return momentumOf(*box) + momentumOf(*ball) + cube->linearMomentum();
    };
    const Eigen::Vector3d before = momentum();
    bullet.simulate(1.5);
    EXPECT_GT(std::abs(double(box->getLinearVelocity().x())), 0.5) << "it is hit";
    // Bullet's velocities are floats
    EXPECT_LT((momentum() - before).norm(), 1e-5 * before.norm()) << stiffness;
  }
}

// --- attached to bodies on joints --------------------------------------------------------------------------

/// A joint at `frame` between `box` and the world or the static `base`. The box is at the origin without
/// rotation.
using Joint = std::unique_ptr<btTypedConstraint>;
using MakeJoint = std::function<Joint(btRigidBody& box, btRigidBody& base, const btTransform& frame)>;

template <class SixDof>
void limit(SixDof& joint) {
  joint.setLinearLowerLimit(vec(-0.1, -0.1, -0.1));
  joint.setLinearUpperLimit(vec(0.1, 0.1, 0.1));
  joint.setAngularLowerLimit(vec(-0.5, -0.5, -0.5));
  joint.setAngularUpperLimit(vec(0.5, 0.5, 0.5));
}

btTransform onBase(const btRigidBody& base, const btTransform& frame) {
  return base.getWorldTransform().inverse() * frame;
}

/// Without cone twist and universal joints: with these a box gains energy even without any soft body.
const std::pair<const char*, MakeJoint> kJoints[] = {
    {"point to point",
     [](btRigidBody& box, btRigidBody&, const btTransform& f) -> Joint {
       return std::make_unique<btPoint2PointConstraint>(box, f.getOrigin());
     }},
    {"hinge",
     [](btRigidBody& box, btRigidBody&, const btTransform& f) -> Joint {
       return std::make_unique<btHingeConstraint>(box, f);
     }},
    {"slider",
     [](btRigidBody& box, btRigidBody& base, const btTransform& f) -> Joint {
       auto joint = std::make_unique<btSliderConstraint>(base, box, onBase(base, f), f, true);
       joint->setLowerLinLimit(-0.5f), joint->setUpperLinLimit(0.5f);
       joint->setLowerAngLimit(-1), joint->setUpperAngLimit(1);
       return joint;
     }},
    {"six degrees of freedom",
     [](btRigidBody& box, btRigidBody& base, const btTransform& f) -> Joint {
       auto joint = std::make_unique<btGeneric6DofConstraint>(base, box, onBase(base, f), f, true);
       limit(*joint);
       return joint;
     }},
    {"six degrees of freedom 2",
     [](btRigidBody& box, btRigidBody& base, const btTransform& f) -> Joint {
       auto joint = std::make_unique<btGeneric6DofSpring2Constraint>(base, box, onBase(base, f), f);
       limit(*joint);
       return joint;
     }},
    {"fixed",
     [](btRigidBody& box, btRigidBody& base, const btTransform& f) -> Joint {
       return std::make_unique<btFixedConstraint>(base, box, onBase(base, f), f);
     }},
};

class JointDice {
 public:
  explicit JointDice(unsigned seed) : numbers_(seed) {}
  double between(double low, double high) { return low + (high - low) * (double(numbers_()) / 4294967296.0); }
  double decades(double low, double high) { return std::pow(10.0, between(low, high)); }

 private:
  std::mt19937 numbers_;  // defined by the standard: the same numbers on all platforms
};

btTransform randomFrame(JointDice& dice) {
  const btVector3 pivot = vec(dice.between(-.5, .5), dice.between(0, .5), dice.between(-.5, .5));
  const btVector3 axis = vec(dice.between(-1, 1), dice.between(-1, 1), dice.between(-1, 1)).normalized();
  return btTransform(btQuaternion(axis, static_cast<btScalar>(dice.between(0, 3))), pivot);
}

/// Simulates a cube that is attached by a corner to a box on the joint. Nothing collides.
void expectNoEnergyIsGained(const MakeJoint& make, unsigned seed, double rate) {
  JointDice dice(seed);
  SoftWorld bullet;
  const double mass = dice.decades(-1, 1.5), softMass = dice.decades(-1, 1);
  btRigidBody* box = bullet.addBox(vec(dice.between(.1, .5), dice.between(.1, .5), dice.between(.1, .5)),
                                   mass, vec(0, 0, 0));
  box->setActivationState(DISABLE_DEACTIVATION);
  btRigidBody* base = bullet.addBox(vec(.01, .01, .01), 0, vec(0, 0, 50));
  const Joint joint = make(*box, *base, randomFrame(dice));
  bullet.world->addConstraint(joint.get());
  SoftBodySettings s = lightlyDamped(dice.decades(2.5, 5.5), softMass);
  s.collisionMask = 0;
  s.position = {dice.between(-.6, .6), dice.between(-.6, .6), dice.between(-.6, .6)};
  SoftBody* cube = bullet.addSoft(fullCubeNetwork(), s);
  const auto corner = static_cast<std::uint32_t>(dice.between(0, 8));
  ASSERT_TRUE(bullet.system.attach(cube, corner, *box));
  const double start = energyOf(*cube, kGravity) + energyOf(*box, kGravity);
  double maxEnergy = start;
  for (int i = 0; i < 2 * rate; ++i) {
    bullet.tick(1 / rate);
    maxEnergy = std::max(maxEnergy, energyOf(*cube, kGravity) + energyOf(*box, kGravity));
  }
  // relative to the energy of a fall of one metre
  EXPECT_LT(maxEnergy - start, 0.01 * (mass + softMass) * kGravity)
      << "seed " << seed << ", " << rate << " ticks a second";
  bullet.world->removeConstraint(joint.get());
}

TEST(Joined, aCubeOnABoxThatHangsOnAJointNeverGainsEnergy) {
  for (const auto& [name, make] : kJoints) {
    SCOPED_TRACE(name);
    for (const unsigned seed : variants({0u, 1u, 2u}, {3u, 4u, 5u}))
      for (const double rate : {60.0, 15.0}) expectNoEnergyIsGained(make, seed, rate);
  }
}

// --- driven by joints ------------------------------------------------------------------------------------

constexpr double kSpring = 40.0;  // N/m

/// Makes the joint a spring along y that is rigid in all other directions.
template <class SixDof>
Joint springAlongY(std::unique_ptr<SixDof> joint) {
  joint->setLinearLowerLimit(vec(0, 1, 0));
  joint->setLinearUpperLimit(vec(0, -1, 0));
  joint->setAngularLowerLimit(vec(0, 0, 0));
  joint->setAngularUpperLimit(vec(0, 0, 0));
  joint->enableSpring(1, true);
  joint->setStiffness(1, btScalar(kSpring));
  joint->setEquilibriumPoint();
  return joint;
}

/// A cube whose four upper corners are attached to a box above it, which hangs on a joint.
struct Driven {
  explicit Driven(const MakeJoint& make) {
    box = bullet.addBox(vec(.5, .1, .5), 2.0, vec(0, 0, 0));
    box->setActivationState(DISABLE_DEACTIVATION);
    joint = make(*box, *bullet.addBox(vec(.01, .01, .01), 0, vec(0, 0, 50)), btTransform::getIdentity());
    bullet.world->addConstraint(joint.get());
    SoftBodySettings s = lightlyDamped(1e5, 1.0);
    s.collisionMask = 0;
    s.position = {0, -0.6, 0};
    cube = *system.createBody(fullCubeNetwork(), s);
    for (std::uint32_t i = 0; i < cube->pointCount(); ++i)
      if (cube->position(i).y() > -0.2) {
        EXPECT_TRUE(system.attach(cube, i, *box));
      }
  }
  ~Driven() { bullet.world->removeConstraint(joint.get()); }

  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};
  btRigidBody* box;
  SoftBody* cube;
  Joint joint;
};

/// Returns the smallest and the largest change (J) of the energy, with springs, during the last two swings.
std::pair<double, double> energyGained(const MakeJoint& make, double rate) {
  Driven d(make);
  const auto energy = [&] {
    const double y = double(d.box->getWorldTransform().getOrigin().y());
    return energyOf(*d.cube, kGravity) + energyOf(*d.box, kGravity) + 0.5 * kSpring * y * y;
  };
  const double start = energy();
  double maxGain = -HUGE_VAL, minGain = HUGE_VAL;
  for (int i = 0; i < 5 * rate; ++i) {
    d.bullet.tick(1 / rate);
    if (i < 3.3 * rate) continue;  // a swing is 1.7 s
    maxGain = std::max(maxGain, energy() - start);
    minGain = std::min(minGain, energy() - start);
  }
  return {minGain, maxGain};
}

TEST(Joined, whatBouncesOnASpringOfBulletsKeepsItsEnergy) {
  const std::pair<const char*, MakeJoint> joints[] = {
      {"spring",
       [](btRigidBody& box, btRigidBody& base, const btTransform& f) -> Joint {
         return springAlongY(
             std::make_unique<btGeneric6DofSpringConstraint>(base, box, onBase(base, f), f, true));
       }},
      {"spring 2",
       [](btRigidBody& box, btRigidBody& base, const btTransform& f) -> Joint {
         return springAlongY(std::make_unique<btGeneric6DofSpring2Constraint>(base, box, onBase(base, f), f));
       }},
  };
  // the error of velocity Verlet is (omega h)^2 / 8 = 5e-4, and the cube's damping absorbs its vibration
  const double swing = 0.5 * std::pow(3.0 * kGravity, 2) / kSpring;
  for (const auto& [name, make] : joints)
    for (const double rate : {60.0, 240.0}) {
      const auto [minGain, maxGain] = energyGained(make, rate);
      EXPECT_LT(maxGain, 0.002 * swing) << name << ", " << rate << " ticks a second";
      EXPECT_GT(minGain, -0.002 * swing) << name << ", " << rate << " ticks a second";
    }
}

TEST(Joined, aMotorPushesWithItsForce) {
  constexpr double kForce = 6.0, kTime = 0.5;
  const MakeJoint motor = [](btRigidBody& box, btRigidBody& base, const btTransform& f) -> Joint {
    auto joint = std::make_unique<btSliderConstraint>(base, box, onBase(base, f), f, true);
    joint->setLowerLinLimit(1), joint->setUpperLinLimit(-1);
    joint->setPoweredLinMotor(true);
    joint->setTargetLinMotorVelocity(100);
    joint->setMaxLinMotorForce(btScalar(kForce));
    return joint;
  };
  for (const double rate : {60.0, 240.0}) {
    Driven d(motor);
    d.bullet.simulate(kTime, 1 / rate);
    const double momentum = 2.0 * double(d.box->getLinearVelocity().x()) + d.cube->linearMomentum().x();
    EXPECT_NEAR(std::abs(momentum), kForce * kTime, 1e-3 * kForce * kTime) << rate << " ticks a second";
  }
}

/// The spring is so stiff that a swing takes nine ticks. Errors of Bullet's solver near the rest position
/// would add energy.
TEST(Joined, aStiffSpringOfBulletsSwingsAsFarAsItShould) {
  constexpr double kStiff = 4860.0, kSpeed = 1.0;  // N/m, m/s
  const auto joint = [](auto spring) -> Joint {
    spring->setLinearLowerLimit(vec(1, 0, 0)), spring->setLinearUpperLimit(vec(-1, 0, 0));
    spring->setAngularLowerLimit(vec(0, 0, 0)), spring->setAngularUpperLimit(vec(0, 0, 0));
    spring->enableSpring(0, true), spring->setEquilibriumPoint();
    return spring;
  };
  const MakeJoint joints[] = {
      [&](btRigidBody& box, btRigidBody& base, const btTransform& f) {
        auto spring = std::make_unique<btGeneric6DofSpringConstraint>(base, box, onBase(base, f), f, true);
        spring->setStiffness(0, btScalar(kStiff));
        return joint(std::move(spring));
      },
      [&](btRigidBody& box, btRigidBody& base, const btTransform& f) {
        auto spring = std::make_unique<btGeneric6DofSpring2Constraint>(base, box, onBase(base, f), f);
        spring->setStiffness(0, btScalar(kStiff), false);  // the same stiffness at every tick
        return joint(std::move(spring));
      }};
  for (const MakeJoint& make : joints) {
    Driven d(make);
    d.bullet.world->setGravity(vec(0, 0, 0));
    d.box->setGravity(vec(0, 0, 0));
    d.box->setLinearVelocity(vec(kSpeed, 0, 0));
    for (std::uint32_t i = 0; i < d.cube->pointCount(); ++i)
      d.cube->point(i)->setLinearVelocity(vec(kSpeed, 0, 0));
    double farthest = 0, fastest = 0;
    for (int i = 0; i < 300; ++i) {
      d.bullet.tick();
      farthest = std::max(farthest, std::abs(double(d.box->getWorldTransform().getOrigin().x())));
      fastest = std::max(fastest, double(d.box->getLinearVelocity().length()));
    }
    // sampled at the ends of ticks, 40 degrees of a swing apart; the cube deforms a little
    const double swing = kSpeed / std::sqrt(kStiff / 3.0);
    EXPECT_LT(farthest, 1.05 * swing);
    EXPECT_GT(farthest, 0.85 * swing);
    EXPECT_LT(fastest, 1.05 * kSpeed);
  }
}

/// An arm of 2 kg and 1 m on an angular spring at its end, coupled to a soft body by a very weak spring.
TEST(Joined, anAngularSpringOfBulletsSwingsAsFarAsItShould) {
  SoftWorld bullet(0.0);
  btRigidBody* arm = bullet.addBox(vec(.5, .05, .05), 2.0, vec(.5, 0, 0));
  btRigidBody* base = bullet.addBox(vec(.01, .01, .01), 0, vec(0, 0, 50));
  arm->setActivationState(DISABLE_DEACTIVATION);
  btTransform frame = btTransform::getIdentity();
  frame.setOrigin(vec(-.5, 0, 0));
  btGeneric6DofSpring2Constraint joint(*base, *arm, base->getWorldTransform().inverse(), frame);
  joint.setLinearLowerLimit(vec(0, 0, 0)), joint.setLinearUpperLimit(vec(0, 0, 0));
  joint.setAngularLowerLimit(vec(0, 0, 1)), joint.setAngularUpperLimit(vec(0, 0, -1));
  joint.enableSpring(5, true), joint.setStiffness(5, 200), joint.setEquilibriumPoint();
  bullet.world->addConstraint(&joint, true);
  SoftBodySettings s = lightlyDamped(1e4, 1.0);
  s.position = {5, 0, 0};
  SoftBody* cube = bullet.addSoft(fullCubeNetwork(), s);
  SpringSettings weak;
  weak.stiffness = 1e-3;
  ASSERT_TRUE(bullet.system.addSpring({arm}, {cube->point(0)}, weak));
  constexpr double kSpin = 0.5;  // rad/s
  arm->setAngularVelocity(vec(0, 0, kSpin));
  arm->setLinearVelocity(vec(0, 0.5 * kSpin, 0));
  double maxAngle = 0;
  for (int i = 0; i < 720; ++i) {
    bullet.tick(1.0 / 240.0);
    maxAngle = std::max(maxAngle, std::abs(double(arm->getWorldTransform().getRotation().getAngle())));
  }
  bullet.world->removeConstraint(&joint);
  // the inertia about the joint is 2 (1 + 0.01) / 12 + 2 / 4 kg m^2
  const double inertia = 2.0 * 1.01 / 12.0 + 0.5;
  EXPECT_NEAR(maxAngle, kSpin / std::sqrt(200.0 / inertia), 5e-4);
}

TEST(Joined, aJointBreaksAtItsThreshold) {
  const MakeJoint ball = [](btRigidBody& box, btRigidBody&, const btTransform& f) -> Joint {
    return std::make_unique<btPoint2PointConstraint>(box, f.getOrigin());
  };
  for (const double rate : {15.0, 60.0, 240.0})
    for (const double fraction : {0.2, 0.7, 0.9, 0.97, 1.03}) {
      Driven d(ball);
      d.joint->setBreakingImpulseThreshold(btScalar(fraction * 3.0 * kGravity / rate));
      for (int i = 0; i < 3; ++i) d.bullet.tick(1 / rate);
      EXPECT_EQ(d.joint->isEnabled(), fraction > 1.0)
          << fraction << " of the weight, " << rate << " ticks a second";
    }
}

TEST(Joined, whatHangsOnAMovingKinematicBodyGoesAsFast) {
  for (const double rate : {15.0, 60.0, 240.0}) {
    btRigidBody* base = nullptr;
    const MakeJoint fixed = [&](btRigidBody& box, btRigidBody& fixedBase, const btTransform& f) -> Joint {
      base = &fixedBase;
      return std::make_unique<btFixedConstraint>(fixedBase, box, onBase(fixedBase, f), f);
    };
    Driven d(fixed);
    base->setCollisionFlags(base->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    base->setActivationState(DISABLE_DEACTIVATION);
    btTransform pose = base->getWorldTransform();
    for (int i = 0; i < 2 * rate; ++i) {
      pose.setOrigin(pose.getOrigin() + vec(2 / rate, 0, 0));
      base->setWorldTransform(pose);
      d.bullet.tick(1 / rate);
    }
    // the cube still swings slightly from the start
    EXPECT_NEAR(d.cube->linearMomentum().x(), 2.0, 5e-3) << rate << " ticks a second";
    EXPECT_NEAR(double(d.box->getLinearVelocity().x()), 2.0, 5e-3) << rate << " ticks a second";
  }
}

}  // namespace
}  // namespace limber::test
