// SPDX-License-Identifier: Zlib
// Equal bodies share a model. What happens to one of them must not change the others.
#include "support/soft_world.h"

#include <cmath>
#include <functional>
#include <vector>

namespace limber::test {
namespace {

constexpr int kTicks = 60;

/// Returns the hash of the last of `count` equal cubes far from each other, after a second in which `treat`
/// is called for the first cube in each tick.
std::uint64_t hashOfLast(int count, const SoftBodySettings& settings,
                         const std::function<void(SoftBodySystem&, SoftBody&, int tick)>& treat = {}) {
  SoftWorld bullet(0.0);
  const SharedNetwork network = cubeNetwork();
  std::vector<SoftBody*> bodies;
  for (int i = 0; i < count; ++i) {
    SoftBodySettings s = settings;
    s.position = {100.0 * (count - 1 - i), 0, 0};
    s.angularVelocity = {1.0, 2.0, -0.5};
    bodies.push_back(bullet.addSoft(network, s));
  }
  for (int tick = 0; tick < kTicks; ++tick) {
    if (treat && count > 1) treat(bullet.system, *bodies[0], tick);
    bullet.tick();
  }
  return bodies.back()->stateHash();
}

SoftBodySettings yielding() {
  SoftBodySettings s = testedSettings();
  s.elasticLimit.yieldStrain = 0.02;
  s.elasticLimit.breakStrain = 0.5;
  return s;
}

/// Pulls two corners of the cube apart, until its springs are half as long again.
void pull(SoftBodySystem&, SoftBody& body, int tick) {
  for (const std::uint32_t i : {0u, 7u}) {
    EXPECT_TRUE(body.pin(i));
    const Eigen::Vector3d x = body.settings().position + (1.0 + tick / 30.0) * body.network().restPoints[i];
    EXPECT_TRUE(body.movePin(i, vec(x.x(), x.y(), x.z())));
  }
}

TEST(SharedModels, yieldingAndBreakingOfOneBodyLeaveTheOthersAlone) {
  EXPECT_EQ(hashOfLast(3, yielding(), pull), hashOfLast(1, yielding()));
}

TEST(SharedModels, pinsAndMassesOfOneBodyLeaveTheOthersAlone) {
  const std::uint64_t alone = hashOfLast(1, testedSettings());
  EXPECT_EQ(hashOfLast(9, testedSettings(), pull), alone);
  const auto makeHeavier = [](SoftBodySystem&, SoftBody& body, int tick) {
    if (tick == 10) body.point(3)->setMassProps(btScalar(5), btVector3(0, 0, 0));
  };
  EXPECT_EQ(hashOfLast(9, testedSettings(), makeHeavier), alone);
}

/// Returns the hash of a cube that has fallen on the floor, beside which others are created far away.
std::uint64_t hashBesideNewBodies(bool create) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBodySettings s;
  s.position = {0, 2.03, 0};
  s.extensionStiffness = s.compressionStiffness = 1000.0;
  // one substep fewer than it needs: its energy is limited from tick to tick
  s.stepping.maxSubsteps = 5;
  const SoftBody* body = bullet.addSoft(closedCubeNetwork(), s);
  for (int tick = 0; tick < 100; ++tick) {
    s.position = {-20.0 - 5.0 * tick, 100.0, 0};
    if (create && tick % 10 == 0) (void)bullet.addSoft(cubeNetwork(), s);
    bullet.tick();
  }
  return body->stateHash();
}

TEST(SharedModels, creationOfBodiesFarAwayChangesNoBitOfAnother) {
  EXPECT_EQ(hashBesideNewBodies(true), hashBesideNewBodies(false));
}

TEST(SharedModels, outliveTheBodyThatWasFirst) {
  const auto destroy = [](SoftBodySystem& system, SoftBody& body, int tick) {
    if (tick != 10) return;
    EXPECT_TRUE(system.destroyBody(&body));
  };
  EXPECT_EQ(hashOfLast(2, testedSettings(), destroy), hashOfLast(1, testedSettings()));
}

TEST(SharedModels, differWhereSettingsDo) {
  SoftWorld bullet(0.0);
  const SharedNetwork network = cubeNetwork();
  std::vector<double> energies;
  for (const double stiffness : {100.0, 200.0}) {
    for (const double scale : {1.0, 2.0}) {
      SoftBodySettings s = testedSettings();
      s.extensionStiffness = s.compressionStiffness = stiffness;
      s.volumeModulus = 0.0;
      s.scale.setConstant(scale);
      SoftBody& body = *bullet.addSoft(network, s);
      for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
        const Eigen::Vector3d x = 1.1 * scale * network->restPoints[i];
        body.point(i)->getWorldTransform().setOrigin(vec(x.x(), x.y(), x.z()));
      }
      energies.push_back(body.elasticEnergy());
    }
  }
  // k e^2 / 2: twice the stiffness twice the energy, twice the size four times; positions are floats
  EXPECT_NEAR(energies[1] / energies[0], 4.0, 1e-4);
  EXPECT_NEAR(energies[2] / energies[0], 2.0, 1e-4);
  EXPECT_NEAR(energies[3] / energies[0], 8.0, 2e-4);
}

// --- handles -----------------------------------------------------------------------------------------------

TEST(Handles, areNullWhenTheirObjectsAreGone) {
  BulletWorld bullet;
  Handle<SoftBody> kept, destroyed;
  Handle<SpringConstraint> spring, springOnPoint;
  EXPECT_FALSE(kept);
  {
    SoftBodySystem system(*bullet.world);
    kept = (*system.createBody(cubeNetwork()))->handle();
    destroyed = (*system.createBody(cubeNetwork()))->handle();
    spring = (*system.addSpring({kept->point(0)}, {nullptr, vec(0, 5, 0)}))->handle();
    springOnPoint = (*system.addSpring({destroyed->point(0)}, {nullptr, vec(0, 5, 0)}))->handle();
    ASSERT_TRUE(kept && destroyed && spring && springOnPoint);
    EXPECT_EQ(kept.get(), system.body(0));
    EXPECT_TRUE(system.destroyBody(destroyed.get()));
    EXPECT_FALSE(destroyed);
    EXPECT_EQ(destroyed.get(), nullptr);
    EXPECT_FALSE(springOnPoint) << "it goes with its point";
    EXPECT_TRUE(kept && spring);
    EXPECT_TRUE(system.removeSpring(spring.get()));
    EXPECT_FALSE(spring);
  }
  EXPECT_FALSE(kept);
}

TEST(Handles, staleAndForeignPointersAreErrors) {
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world), other(*bullet.world);
  SoftBody* body = *system.createBody(cubeNetwork());
  SoftBody* stale = *system.createBody(cubeNetwork());
  btRigidBody* box = bullet.addBox(vec(0.1, 0.1, 0.1), 1.0, vec(0, 5, 0));
  EXPECT_TRUE(system.destroyBody(stale));
  EXPECT_EQ(system.destroyBody(stale).error(), "the soft body is not, or no longer, one of this system");
  EXPECT_EQ(other.destroyBody(body).error(), "the soft body is not, or no longer, one of this system");
  EXPECT_EQ(system.destroyBody(nullptr).error(), "the soft body is not, or no longer, one of this system");
  EXPECT_EQ(system.attach(stale, 0, *box).error(), "the soft body is not, or no longer, in this world");
  EXPECT_EQ(system.detach(stale, 0).error(), "the soft body is not, or no longer, in this world");
  EXPECT_EQ(system.detach(body, 0).error(), "point 0 is not attached");
  EXPECT_TRUE(other.attach(body, 0, *box)) << "systems of one world";
  EXPECT_TRUE(other.detach(body, 0));
  EXPECT_EQ(system.removeSpring(nullptr).error(), "the spring is not, or no longer, one of this system");
  EXPECT_EQ(system.bodyCount(), 1u);
  EXPECT_EQ(system.body(1), nullptr);
}

TEST(Handles, pointsOutOfRangeAreErrors) {
  SoftWorld bullet;
  SoftBody& body = *bullet.addSoft(cubeNetwork(), SoftBodySettings());
  EXPECT_EQ(body.point(8), nullptr);
  EXPECT_TRUE(body.position(8).hasNaN());
  EXPECT_TRUE(body.velocity(8).hasNaN());
  EXPECT_FALSE(body.pinned(8));
  EXPECT_EQ(body.pin(8).error(), "there is no point 8: the body has 8 points");
  EXPECT_EQ(body.movePin(8, vec(0, 0, 0)).error(), "there is no point 8: the body has 8 points");
  EXPECT_EQ(body.unpin(8).error(), "there is no point 8: the body has 8 points");
  EXPECT_EQ(body.movePin(7, vec(0, 0, 0)).error(), "point 7 is not pinned");
  EXPECT_EQ(body.unpin(7).error(), "point 7 is not pinned");
  EXPECT_TRUE(body.pin(7));
  EXPECT_TRUE(body.pin(7)) << "again";
  EXPECT_EQ(body.movePin(7, vec(0, std::nan(""), 0)).error(), "the target of point 7 is not finite");
  EXPECT_TRUE(body.unpin(7));
  EXPECT_EQ(bullet.system.attach(&body, 8, *bullet.addBox(vec(1, 1, 1), 1.0, vec(9, 9, 9))).error(),
            "there is no point 8");
}

}  // namespace
}  // namespace limber::test
