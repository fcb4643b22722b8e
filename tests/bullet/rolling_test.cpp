// SPDX-License-Identifier: Zlib
// Rolling and spinning friction of rigid bodies whose contacts are solved together with springs.
#include "support/small_meshes.h"
#include "support/soft_world.h"
#include "support/variants.h"

#include <algorithm>
#include <memory>

namespace limber::test {
namespace {

constexpr double kBallRadius = 0.5;

/// Adds a ball of 1 kg on a floor, both with a friction of 1. Only the ball has rolling friction (m).
btRigidBody* addBall(BulletWorld& bullet, double rolling, double spinning) {
  bullet.addBoxFloor()->setFriction(1);
  btRigidBody* ball =
      bullet.add(std::make_unique<btSphereShape>(btScalar(kBallRadius)), 1.0, vec(0, kBallRadius, 0));
  ball->setFriction(1);
  ball->setRollingFriction(btScalar(rolling));
  ball->setSpinningFriction(btScalar(spinning));
  ball->setActivationState(DISABLE_DEACTIVATION);
  return ball;
}

/// Makes Limber step the ball and its contacts, by a spring without force.
void attachLooseSpring(SoftBodySystem& system, btRigidBody* ball) {
  SpringSettings loose;
  loose.stiffness = 0.0;
  ASSERT_TRUE(system.addSpring({ball}, {nullptr, vec(0, 5, 0)}, loose));
}

TEST(RollingFriction, slowsABallAsItsMomentDoes) {
  for (const double speed : {0.5, 2.0})
    for (const double rolling : {0.0, 0.05}) {
      SoftWorld bullet;
      btRigidBody* ball = addBall(bullet, rolling, 0.0);
      attachLooseSpring(bullet.system, ball);
      ball->setLinearVelocity(vec(btScalar(speed), 0, 0));
      ball->setAngularVelocity(vec(0, 0, btScalar(-speed / kBallRadius)));
      bullet.simulate(0.5);
      // a moment of c m g acts on the ball:  (2/5 m r^2 + m r^2) alpha = c m g,  a = alpha r
      const double slower = rolling * kGravity / (1.4 * kBallRadius);
      EXPECT_NEAR(double(ball->getLinearVelocity().x()), speed - 0.5 * slower, 1e-3)
          << speed << ' ' << rolling;
      bullet.simulate(3.0);
      EXPECT_NEAR(double(ball->getLinearVelocity().x()), rolling > 0.0 ? 0.0 : speed, 1e-3) << speed;
    }
}

TEST(RollingFriction, ofASpinAboutTheNormalIsAnother) {
  SoftWorld bullet;
  btRigidBody* ball = addBall(bullet, 0.01, 0.05);
  attachLooseSpring(bullet.system, ball);
  ball->setAngularVelocity(vec(0, 10, 0));
  bullet.simulate(1.0);
  const double slower = 0.05 * kGravity / (0.4 * kBallRadius * kBallRadius);
  EXPECT_NEAR(double(ball->getAngularVelocity().y()), 10.0 - slower, 1e-2);
}

/// Bullet's solver handles the first tick of a contact between a point in the world and an object that was
/// placed there before the tick.
TEST(RollingFriction, ofWhatIsPutIntoPointsTurnsNothing) {
  for (const bool massChanged : {false, true}) {
    SoftWorld bullet(0.0);
    SoftBodySettings s;
    s.collision = Collision::Points;
    SoftBody& cube = *bullet.addSoft(cubeNetwork(), s);
    if (massChanged)
      for (std::uint32_t i = 0; i < 8; ++i) cube.point(i)->setMassProps(btScalar(0.3), btVector3(0, 0, 0));
    btRigidBody* box = bullet.addBox(vec(0.5, 0.5, 0.5), 1.0, vec(0, 0, 0));
    bullet.simulate(0.5);
    btRigidBody* plane = bullet.addPlaneFloor();
    plane->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    plane->forceActivationState(DISABLE_DEACTIVATION);
    plane->setRollingFriction(btScalar(0.2));
    for (int i = 0; i < 5; ++i) {
      plane->getWorldTransform().setRotation(btQuaternion(vec(0, 0, 1), btScalar(0.05 * (i + 1))));
      bullet.tick();
      EXPECT_TRUE(eigen(box->getLinearVelocity()).allFinite()) << i;
      for (const SoftContact& c : cube.contacts()) EXPECT_TRUE(eigen(c.impulse).allFinite()) << i;
      for (std::uint32_t p = 0; p < 8; ++p)
        EXPECT_EQ(cube.point(p)->getAngularVelocity(), btVector3(0, 0, 0));
    }
    EXPECT_EQ(cube.restorations(), 0u);
  }
}

// --- balls -------------------------------------------------------------------------------------------------

/// A level slab of damped rubber, 0.8 x 0.06 x 0.2 m.
SharedNetwork slabNetwork() {
  TriangleMesh box = small_meshes::cube();
  for (Eigen::Vector3d& p : box.positions) p = p.cwiseProduct(Eigen::Vector3d(0.8, 0.06, 0.2));
  return solidNetwork(box, 150);
}

/// Returns the energy, as a share of the kinetic energy at the start, that a ball of 1 kg and its slab have
/// left when it has rolled or slid for 0.3 m (with sanitizers 0.1 m) at 0.1 m/s: 1 less what the slab's
/// dampers have taken.
double energyAfterARoll(const SharedNetwork& network, double friction, double tick) {
  constexpr double kRadius = 0.06, kSpeed = 0.1, kSeconds = kSanitized ? 1.0 : 3.0;
  SoftWorld bullet;
  bullet.addBoxFloor()->setFriction(1);
  Material rubber = Material::rubber();
  rubber.dampingTime = 0.02;
  SoftBodySettings s = *withMaterial(*network, rubber, testedSettings());
  s.position.y() = 0.0322;
  s.pointRadius = 0.002;
  s.sleepingSpeed = 0.0;
  SoftBody& slab = *bullet.addSoft(network, s);
  btRigidBody* ball = bullet.add(std::make_unique<btSphereShape>(btScalar(kRadius)), 1.0,
                                 vec(-0.2, btScalar(0.0644 + kRadius), 0));
  ball->setFriction(btScalar(friction));
  ball->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(1.0, tick);
  ball->setLinearVelocity(vec(btScalar(kSpeed), 0, 0));
  if (friction > 0.0) ball->setAngularVelocity(vec(0, 0, btScalar(-kSpeed / kRadius)));
  bullet.simulate(0.2, tick);
  const auto energy = [&] { return energyOf(*ball, kGravity) + energyOf(slab, kGravity); };
  const double before = energy(), kinetic = kineticEnergyOf(*ball);
  bullet.simulate(kSeconds, tick);
  EXPECT_NEAR(double(ball->getWorldTransform().getOrigin().x()), -0.2 + (0.2 + kSeconds) * kSpeed, 0.03)
      << friction << ' ' << tick;
  return 1.0 + (energy() - before) / kinetic;
}

/// It sank into the next triangle by what it had moved since the last search, and was lifted for nothing.
TEST(Rolling, aBallOnALevelSlabGainsNoEnergy) {
  if (!kSurface) GTEST_SKIP() << "balls roll over the points";
  const SharedNetwork network = slabNetwork();
  struct Case {
    double friction, hertz;
  };
  std::vector<Case> cases =
      variants<Case>({{0.8, 60.0}, {0.8, 30.0}}, {{0.8, 120.0}, {0.0, 60.0}});  // what slides does so alike
  if (kSanitized) cases.resize(1);
  for (const auto [friction, hertz] : cases) {
    SCOPED_TRACE(testing::Message() << "friction " << friction << ", " << hertz << " Hz");
    // of the sum of all energies, 60 J, the single precision of Bullet's positions hides this much
    const double left = energyAfterARoll(network, friction, 1.0 / hertz);
    EXPECT_LT(left, 1.005);
    EXPECT_GT(left, 0.98);
  }
}

// --- wheels ------------------------------------------------------------------------------------------------

/// Returns how far (m) a wheel of 0.4 m gets in two seconds, whose motor keeps 8 rad/s with 300 N m at most.
/// It drives over a soft mat of 0.3 m between x = 2 m and 4 m.
double wayOverAMat(std::unique_ptr<btCollisionShape> wheelShape) {
  SoftWorld bullet;
  bullet.addBoxFloor()->setFriction(1);
  SoftBodySettings s = settingsAt({3, 0.16, 0});
  s.scale = {2, 0.3, 3};
  s.totalMass = 20;
  setSprings(s, 2e4, 20);
  s.friction = 1;
  (void)bullet.addSoft(bracedNetwork(small_meshes::cube(4)), s);
  btRigidBody* wheel = bullet.add(std::move(wheelShape), 70, vec(0.4, 0.42, 0));
  wheel->setFriction(1);
  wheel->setAngularFactor(vec(0, 0, 1));
  wheel->setActivationState(DISABLE_DEACTIVATION);
  wheel->setLinearVelocity(vec(3.2, 0, 0));
  wheel->setAngularVelocity(vec(0, 0, -8));
  for (int i = 0; i < 120; ++i) {
    const double slow = -8.0 - double(wheel->getAngularVelocity().z());
    wheel->applyTorque(vec(0, 0, std::clamp(200.0 * slow, -300.0, 300.0)));
    bullet.tick();
  }
  return double(wheel->getWorldTransform().getOrigin().x()) - 0.4;
}

/// Its rim presses the front edge of the mat flat. A vertex of the rim that was inside near that edge was
/// pushed out of the mat's far side, which hooked the mat to the wheel.
TEST(Rolling, aWheelWithFlatSidesGetsAsFarOverAMatAsARoundOne) {
  if (!kSurface) GTEST_SKIP() << "the rim falls between the points";
  const double round = wayOverAMat(std::make_unique<btCapsuleShapeZ>(btScalar(0.4), btScalar(0.1)));
  EXPECT_GT(round, 5.0);
  EXPECT_NEAR(wayOverAMat(std::make_unique<btCylinderShapeZ>(vec(0.4, 0.4, 0.15))), round, 0.05 * round);
}

}  // namespace
}  // namespace limber::test
