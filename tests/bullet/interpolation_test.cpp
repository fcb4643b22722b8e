// SPDX-License-Identifier: Zlib
// Positions between ticks, for rendering at any frame rate.
#include "support/soft_world.h"

#include <cmath>

namespace limber::test {
namespace {

/// m: rounding of float coordinates of a few metres.
constexpr double kRounding = 2e-6;

struct InterpolationTest : ::testing::Test {
  BulletWorld bullet{0.0};
  SoftBodySystem system{*bullet.world};

  SoftBody* pair() {
    Result<SoftBody*> body = system.createBody(pairNetwork(), testedSettings());
    EXPECT_TRUE(body) << body.error();
    return *body;
  }
  static Eigen::Vector3d at(const SoftBody& body, std::uint32_t i, double fraction) {
    std::vector<float> xyz(std::size_t{3} * body.pointCount());
    body.writePositions(xyz.data(), fraction);
    return Eigen::Map<Eigen::Vector3f>(xyz.data() + std::size_t{3} * i).cast<double>();
  }
};

void move(SoftBody& body, const btVector3& velocity) {
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) body.point(i)->setLinearVelocity(velocity);
}

TEST_F(InterpolationTest, goesWithTheMotionStatesOfRigidBodies) {
  for (const bool latency : {true, false}) {
    bullet.world->setLatencyMotionStateInterpolation(latency);
    SoftBody* body = pair();
    move(*body, vec(3, 1, 0));
    btDefaultMotionState motion(btTransform(btQuaternion::getIdentity(), vec(0, 50, 0)));
    btRigidBody* rigid = bullet.addBox(vec(0.1, 0.1, 0.1), 1.0, vec(0, 50, 0));
    rigid->setMotionState(&motion);
    rigid->setLinearVelocity(vec(3, 1, 0));
    const Eigen::Vector3d start = body->position(0);
    for (int frame = 0; frame < 100; ++frame) {
      bullet.world->stepSimulation(btScalar(1.0 / 144.0), 5, btScalar(1.0 / 60.0));
      const Eigen::Vector3d displacement = at(*body, 0, system.tickFraction()) - start;
      const btVector3 rigidDisplacement = motion.m_graphicsWorldTrans.getOrigin() - vec(0, 50, 0);
      // at a height of 50 m a float has an error of 4e-6 m, and a hundred of them add up
      ASSERT_NEAR(displacement.x(), double(rigidDisplacement.x()), 2e-4)
          << "frame " << frame << " latency " << latency;
      ASSERT_NEAR(displacement.y(), double(rigidDisplacement.y()), 2e-4)
          << "frame " << frame << " latency " << latency;
    }
    system.destroyBody(body);
    bullet.world->removeRigidBody(rigid);
  }
}

TEST_F(InterpolationTest, liesOnTheWayFromTickToTick) {
  SoftBody* body = pair();
  body->point(1)->getWorldTransform().setOrigin(vec(1.2, 0, 0));
  for (int tick = 0; tick < 5; ++tick) {
    const Eigen::Vector3d before = body->position(1);
    bullet.tick();
    const Eigen::Vector3d after = body->position(1);
    ASSERT_GT((after - before).norm(), 1e-4);
    for (const double fraction : {0.0, 0.3, 1.0, 1.5})
      EXPECT_LT((at(*body, 1, fraction) - (before + fraction * (after - before))).norm(), kRounding);
  }
}

TEST_F(InterpolationTest, aBodyThatWasNeverSteppedIsWhereItIs) {
  SoftBody* body = pair();
  EXPECT_LT((at(*body, 1, 0.0) - body->position(1)).norm(), kRounding);
}

TEST_F(InterpolationTest, whatIsMovedByHandLeavesNoSmear) {
  SoftBody* body = pair();
  move(*body, vec(6, 0, 0));
  bullet.tick();
  const Eigen::Vector3d before = at(*body, 0, 0.5);
  for (std::uint32_t i = 0; i < 2; ++i) {
    btTransform& pose = body->point(i)->getWorldTransform();
    pose.setOrigin(pose.getOrigin() + vec(0, 8, 0));
  }
  EXPECT_LT((at(*body, 0, 0.5) - before - Eigen::Vector3d(0, 8, 0)).norm(), kRounding);
  bullet.tick();
  EXPECT_GT(at(*body, 0, 0.0).y(), 7.9) << "the next tick begins where it was put";
}

TEST_F(InterpolationTest, aPinGoesToItsTargetInTheNextTick) {
  SoftBody* body = pair();
  body->pin(0);
  bullet.tick();
  const Eigen::Vector3d start = body->position(0);
  body->movePin(0, vec(start.x(), 0.3, 0));
  EXPECT_LT((at(*body, 0, 0.5) - start).norm(), kRounding) << "it has not gone yet";
  bullet.tick();
  EXPECT_LT((at(*body, 0, 0.5) - start - Eigen::Vector3d(0, 0.15, 0)).norm(), kRounding);
}

TEST_F(InterpolationTest, sleepingBodiesStandStill) {
  bullet.world->setGravity(vec(0, -9.81, 0));
  bullet.addBoxFloor();
  SoftBody* body = *system.createBody(closedCubeNetwork(), settingsAt({0, 0.7, 0}));
  bullet.simulate(8.0);
  ASSERT_TRUE(body->sleeping());
  EXPECT_EQ(at(*body, 3, 0.0), at(*body, 3, 1.0));
}

TEST_F(InterpolationTest, skinsFollow) {
  const TriangleMesh mesh = {{{-0.5, -0.5, -0.5}, {0.5, -0.5, -0.5}, {0, 0.5, -0.5}, {0, 0, 0.5}},
                             {},
                             {},
                             {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  const Result<SharedNetwork> network = withSkin(*closedCubeNetwork(), mesh);
  ASSERT_TRUE(network) << network.error();
  SoftBody* body = *system.createBody(*network, testedSettings());
  move(*body, vec(0, 6, 0));
  bullet.tick();
  std::vector<float> half(std::size_t{3} * body->skinnedPointCount()), now = half;
  body->writeSkinnedPositions(half.data(), 0.5);
  body->writeSkinnedPositions(now.data());
  for (std::size_t i = 0; i < now.size(); ++i)
    EXPECT_NEAR(now[i] - half[i], i % 3 == 1 ? 0.05 : 0.0, 1e-5) << "6 m/s is 5 cm in half a tick";
}

TEST_F(InterpolationTest, ticksOfVariableLengthShowTheLastOne) {
  SoftBody* body = pair();
  EXPECT_EQ(system.tickFraction(), 1.0);
  bullet.tick(0.013);
  EXPECT_EQ(system.tickFraction(), 1.0);
  EXPECT_EQ(body->pointCount(), 2u);
}

}  // namespace
}  // namespace limber::test
