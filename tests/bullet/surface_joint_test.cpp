// SPDX-License-Identifier: Zlib
// Bullet's constraints on surface objects act in the step like those on rigid bodies: energy, momentum,
// sleep.
#include "support/soft_world.h"

#include <cmath>

namespace limber::test {
namespace {

constexpr double kMass = 2.0;

SoftBodySettings cubeSettings(const Eigen::Vector3d& position, double stiffness = 1e4) {
  SoftBodySettings s = settingsAt(position);
  s.totalMass = kMass;
  setSprings(s, stiffness, 0.1 * std::sqrt(stiffness));
  return s;
}

/// Five cubes on hinges of one axis, let go from the horizontal at 1/15 s.
TEST(SurfaceJoints, chainsOfJointedOnesKeepTogetherAndGainNoEnergy) {
  for (const double tick : {1.0 / 60, 1.0 / 15}) {
    SoftWorld bullet;
    std::vector<SoftBody*> cubes;
    std::vector<std::unique_ptr<btTypedConstraint>> joints;
    const btVector3 left = vec(-0.6, 0, 0), right = vec(0.6, 0, 0), axis = vec(0, 0, 1);
    for (int i = 0; i < 5; ++i) {
      cubes.push_back(bullet.addSoft(closedCubeNetwork(), cubeSettings({1.2 * i, 10, 0}, 2e4)));
      btRigidBody& object = *cubes.back()->surfaceObject();
      if (i == 0)
        joints.push_back(std::make_unique<btHingeConstraint>(object, left, axis));
      else
        joints.push_back(std::make_unique<btHingeConstraint>(*cubes[cubes.size() - 2]->surfaceObject(),
                                                             object, right, left, axis, axis));
      bullet.world->addConstraint(joints.back().get(), true);
    }
    double start = 0.0, lowest = 0.0;
    for (const SoftBody* cube : cubes) start += kMass * 9.81 * cube->centerOfMass().y();
    for (double t = 0.0; t < 4.0; t += tick) {
      bullet.world->stepSimulation(btScalar(tick), 0);
      double energy = -start;
      for (SoftBody* cube : cubes) energy += energyOf(*cube) + kMass * 9.81 * cube->centerOfMass().y();
      ASSERT_LT(energy, 0.01) << t << " s";
      lowest = std::min(lowest, cubes.back()->centerOfMass().y() - 10.0);
      for (std::size_t i = 1; i < cubes.size(); ++i) {
        const btVector3 apart = cubes[i - 1]->surfaceObject()->getWorldTransform() * right -
                                cubes[i]->surfaceObject()->getWorldTransform() * left;
        // turning by up to a radian in a tick
        ASSERT_LT(double(apart.length()), 10.0 * tick * tick) << t << " s";
      }
    }
    EXPECT_LT(lowest, -5.0);
    for (const auto& joint : joints) bullet.world->removeConstraint(joint.get());
  }
}

using Joint = std::unique_ptr<btTypedConstraint>;

/// The joints, by name, whose frames are at the places in a and b of one point in the world.
std::vector<std::pair<const char*, Joint>> jointsOf(btRigidBody& a, btRigidBody& b, const btVector3& point) {
  const btTransform inA(btQuaternion::getIdentity(), point - a.getWorldTransform().getOrigin()),
      inB(btQuaternion::getIdentity(), point - b.getWorldTransform().getOrigin());
  const btVector3 y = vec(0, 1, 0), z = vec(0, 0, 1);
  auto slider = std::make_unique<btSliderConstraint>(a, b, inA, inB, true);
  slider->setLowerLinLimit(-2), slider->setUpperLinLimit(2);
  std::vector<std::pair<const char*, Joint>> joints;
  joints.emplace_back("point to point",
                      std::make_unique<btPoint2PointConstraint>(a, b, inA.getOrigin(), inB.getOrigin()));
  joints.emplace_back("hinge", std::make_unique<btHingeConstraint>(a, b, inA, inB));
  joints.emplace_back("fixed", std::make_unique<btFixedConstraint>(a, b, inA, inB));
  joints.emplace_back("cone twist", std::make_unique<btConeTwistConstraint>(a, b, inA, inB));
  joints.emplace_back("slider", std::move(slider));
  btVector3 anchor = point, first = y, second = z;
  joints.emplace_back("universal", std::make_unique<btUniversalConstraint>(a, b, anchor, first, second));
  joints.emplace_back("two hinges and a spring",
                      std::make_unique<btHinge2Constraint>(a, b, anchor, first, second));
  return joints;
}

/// Sliders and springs displace the pivots of the two bodies.
TEST(SurfaceJoints, ofAllKindsKeepTheMomentaOfAFreePair) {
  for (const double tick : {1.0 / 60, 1.0 / 15})
    for (std::size_t kind = 0; kind < 7; ++kind) {
      SoftWorld bullet(0.0);
      std::vector<SoftBody*> cubes;
      for (const double side : {-1.0, 1.0}) {
        SoftBodySettings s = cubeSettings({0.6 * side, 0, 0});
        s.totalMass = 2.0 + side;
        s.damping = 0.0;
        s.linearVelocity = {0.25 + 0.25 * side, -side, 0.15 + 0.15 * side};
        s.angularVelocity = {1.0 + side, 0.5 - 0.5 * side, -2.5 - 0.5 * side};
        cubes.push_back(bullet.addSoft(closedCubeNetwork(), s));
      }
      const auto [name, joint] =
          std::move(jointsOf(*cubes[0]->surfaceObject(), *cubes[1]->surfaceObject(), vec(0, 0, 0))[kind]);
      bullet.world->addConstraint(joint.get(), true);
      const auto spin = [&] {
        return Eigen::Vector3d(cubes[0]->angularMomentum() + cubes[1]->angularMomentum());
      };
      const auto energy = [&] { return energyOf(*cubes[0]) + energyOf(*cubes[1]); };
      const Eigen::Vector3d before = spin();
      const double start = energy();
      for (double t = 0.0; t < 5.0; t += tick) {
        bullet.world->stepSimulation(btScalar(tick), 0);
        ASSERT_LT(energy(), start) << name << ' ' << t << " s";
      }
      // Bullet's floats
      EXPECT_LT((spin() - before).norm(), 1e-4 * before.norm()) << name << ' ' << tick;
      bullet.world->removeConstraint(joint.get());
    }
}

/// Returns the energy (J) that a cube loses of its swing of 10 s on a universal joint at (0, 10, 0) m, from
/// rest at 0.2 rad.
double lossOfASwing(double tick) {
  const Eigen::Vector3d pivot(0, 10, 0);
  const Eigen::AngleAxisd turn(0.2, Eigen::Vector3d::UnitZ());
  SoftWorld bullet;
  SoftBodySettings s = cubeSettings(pivot + turn * Eigen::Vector3d(0, -2, 0));
  s.rotation = turn;
  SoftBody& cube = *bullet.addSoft(closedCubeNetwork(), s);
  btRigidBody* post =
      bullet.add(std::make_unique<btSphereShape>(btScalar(0.1)), 0, vec(pivot.x(), pivot.y(), pivot.z()));
  btUniversalConstraint joint(*post, *cube.surfaceObject(), vec(pivot.x(), pivot.y(), pivot.z()),
                              vec(0, 1, 0), vec(0, 0, 1));
  bullet.world->addConstraint(&joint, true);
  const auto energy = [&] { return energyOf(cube) + kMass * 9.81 * cube.centerOfMass().y(); };
  const double start = energy();
  for (double t = 0.0; t < 10.0; t += tick) {
    bullet.world->stepSimulation(btScalar(tick), 0);
    EXPECT_LT((cube.centerOfMass() - pivot).norm(), 2.0 + 1e-4) << t << " s";
  }
  bullet.world->removeConstraint(&joint);
  return start - energy();
}

/// It has no rows for locked axes whose error is exactly 0. The cube then fell for a tick, and was stopped.
TEST(SurfaceJoints, aPendulumOnAUniversalJointSwingsOn) {
  constexpr double kSwing = 2.0 * 9.81 * 2.0 * (1.0 - 0.980067);  // m g l (1 - cos 0.2)
  for (const double tick : {1.0 / 15, 1.0 / 60}) EXPECT_NEAR(lossOfASwing(tick), 0.0, 0.02 * kSwing) << tick;
}

/// Half of its weight: it falls at g / 2.
TEST(SurfaceJoints, aClampLimitsTheImpulseOfATick) {
  for (const double tick : {1.0 / 240, 1.0 / 15}) {
    SoftWorld bullet;
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), cubeSettings({0, 0, 0}));
    btPoint2PointConstraint joint(*cube->surfaceObject(), vec(0, 0, 0));
    const auto clamp = static_cast<btScalar>(0.5 * kMass * 9.81 * tick);
    joint.m_setting.m_impulseClamp = clamp;
    bullet.world->addConstraint(&joint, true);
    for (int i = 0; i < 15; ++i) bullet.world->stepSimulation(btScalar(tick), 0);
    EXPECT_NEAR(cube->linearMomentum().y(), -0.5 * kMass * 9.81 * 15 * tick, 1e-4) << tick;
    EXPECT_EQ(joint.m_setting.m_impulseClamp, clamp);
    bullet.world->removeConstraint(&joint);
  }
}

/// A cube that bears ten times its mass by a joint, and one that hangs.
TEST(SurfaceJoints, theySleepTogetherWithWhatIsJoinedToThem) {
  for (const double tick : {1.0 / 60, 1.0 / 15}) {
    SoftWorld bullet;
    bullet.addPlaneFloor();
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), cubeSettings({0, 0.5 + kRadius, 0}));
    SoftBody* hanging = bullet.addSoft(closedCubeNetwork(), cubeSettings({5, 3, 0}));
    btRigidBody* load = bullet.addBox(vec(0.3, 0.1, 0.3), 10 * kMass, vec(0, 1.5, 0));
    btTransform up = btTransform::getIdentity();
    up.setOrigin(vec(0, 1 - kRadius, 0));
    btFixedConstraint carried(*cube->surfaceObject(), *load, up, btTransform::getIdentity());
    btPoint2PointConstraint held(*hanging->surfaceObject(), vec(0, 0.5, 0));
    bullet.world->addConstraint(&carried, true);
    bullet.world->addConstraint(&held, true);
    double lowestLoad = HUGE_VAL;
    for (double t = 0.0; t < 8.0; t += tick) {
      bullet.world->stepSimulation(btScalar(tick), 0);
      if (t > 1.5) lowestLoad = std::min(lowestLoad, heightOf(*load));
    }
    SCOPED_TRACE(testing::Message() << tick << " s");
    EXPECT_TRUE(cube->sleeping());
    EXPECT_TRUE(hanging->sleeping());
    EXPECT_FALSE(load->isActive());
    // nothing moved while it went to sleep; the springs yield by F / k, some per mille of their length
    EXPECT_NEAR(lowestLoad, heightOf(*load), 1e-3);
    EXPECT_NEAR(heightOf(*load), 1.5, 0.01);
    load->activate(true);
    load->setLinearVelocity(vec(1, 0, 0));
    bullet.world->stepSimulation(btScalar(tick), 0);
    EXPECT_FALSE(cube->sleeping());
    bullet.world->removeConstraint(&carried);
    bullet.world->removeConstraint(&held);
  }
}

/// A cube on an undamped spring, for 10 s: its energy stays. A frame that lags behind the points, or a force
/// of the tick's start, feeds energy into it.
TEST(SurfaceJoints, springsOfConstraintsKeepEnergy) {
  for (const double tick : {1.0 / 240, 1.0 / 60})
    for (const bool angular : {false, true}) {
      SoftWorld bullet(0.0);
      SoftBodySettings s = cubeSettings({0, 0, 0});
      s.linearVelocity = {angular ? 0.0 : 1.0, 0, 0};
      s.angularVelocity = {0, angular ? 3.0 : 0.0, 0};
      SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
      cube->surfaceObject()->setActivationState(DISABLE_DEACTIVATION);
      btGeneric6DofSpring2Constraint spring(*cube->surfaceObject(), btTransform::getIdentity());
      for (int axis = 0; axis < 6; ++axis) {
        spring.setLimit(axis, 1, -1);
        if ((axis >= 3) != angular) continue;
        spring.enableSpring(axis, true);
        spring.setStiffness(axis, 50);
        spring.setDamping(axis, 0);
      }
      spring.setEquilibriumPoint();
      bullet.world->addConstraint(&spring, true);
      const double start = cube->kineticEnergy();
      double most = 0.0;
      for (double t = 0.0; t < 10.0; t += tick) {
        bullet.world->stepSimulation(btScalar(tick), 0);
        if (t > 8.0) most = std::max(most, energyOf(*cube));
      }
      // the peaks between two ticks are up to (omega h)^2 / 8 higher
      EXPECT_NEAR(most, start, 0.02 * start) << tick << " s, angular: " << angular;
      bullet.world->removeConstraint(&spring);
    }
}

/// A frictionless ball spins on a taut bridge of jointed cubes: what the joints do concerns it not.
TEST(SurfaceJoints, jointsBrakeNothingThatIsNotJoined) {
  for (const double tick : {1.0 / 240, 1.0 / 60}) {
    SoftWorld bullet;
    std::vector<std::unique_ptr<btTypedConstraint>> joints;
    const btVector3 left = vec(-0.5, 0, 0), right = vec(0.5, 0, 0), axis = vec(0, 0, 1);
    btRigidBody* last = nullptr;
    for (int i = 0; i < 4; ++i) {
      SoftBodySettings s = cubeSettings({1.0 * i, 0, 0}, 2e4);
      s.friction = 0.0;
      btRigidBody& object = *bullet.addSoft(closedCubeNetwork(), s)->surfaceObject();
      if (last)
        joints.push_back(std::make_unique<btHingeConstraint>(*last, object, right, left, axis, axis));
      else
        joints.push_back(std::make_unique<btHingeConstraint>(object, left, axis));
      last = &object;
    }
    joints.push_back(std::make_unique<btHingeConstraint>(*last, right, axis));
    for (const auto& joint : joints) bullet.world->addConstraint(joint.get(), true);
    btRigidBody* ball =
        bullet.add(std::make_unique<btSphereShape>(btScalar(0.4)), 10.0, vec(1.5, 0.5 + kRadius + 0.4, 0));
    ball->setFriction(0);
    ball->setActivationState(DISABLE_DEACTIVATION);
    ball->setAngularVelocity(vec(0, 10, 0));
    for (double t = 0.0; t < 2.0; t += tick) bullet.world->stepSimulation(btScalar(tick), 0);
    EXPECT_NEAR(double(ball->getAngularVelocity().y()), 10.0, 1e-3) << tick;
    for (const auto& joint : joints) bullet.world->removeConstraint(joint.get());
  }
}

}  // namespace
}  // namespace limber::test
