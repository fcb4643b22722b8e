// SPDX-License-Identifier: Zlib
// What is asked, added, removed or refused beside a body leaves the body's motion as it is.
#include "support/soft_world.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace limber::test {
namespace {

void addCubeFarAway(SoftBodySystem& system) {
  ASSERT_TRUE(system.createBody(closedCubeNetwork(), settingsAt({100, 0, 0})));
}

TEST(Bystanders, aTowedBoxKeepsItsSpeed) {
  enum class Beside { Nothing, NewBody, SavedStates };
  constexpr double kSpeed = 5.0;  // m/s
  for (const Beside beside : {Beside::Nothing, Beside::NewBody, Beside::SavedStates}) {
    SoftWorld bullet(0.0);
    btRigidBody* car = bullet.addBox(vec(0.1, 0.1, 0.1), 0.0, vec(0, 0, 0));
    makeKinematic(*car);
    btRigidBody* box = bullet.addAwakeBox(vec(0.1, 0.1, 0.1), 1.0, vec(-1, 0, 0));
    box->setLinearVelocity(vec(kSpeed, 0, 0));
    SpringSettings hook;
    hook.damping = 100.0;
    ASSERT_TRUE(bullet.system.addSpring({car}, {box}, hook));
    for (int i = 1; i <= 60; ++i) {
      car->getWorldTransform().setOrigin(vec(kSpeed * kTick * i, 0, 0));
      if (beside == Beside::SavedStates) bullet.system.saveState();
      if (beside == Beside::NewBody && i == 30) addCubeFarAway(bullet.system);
      bullet.tick();
      if (i <= 10) continue;  // the hook's first ticks
      ASSERT_NEAR(double(box->getLinearVelocity().x()), kSpeed, 1e-3) << int(beside) << ' ' << i;
    }
  }
}

/// It needs more than the 10 000 substeps that a tick may have.
TEST(Bystanders, aBodyThatIsTooStiffStaysSoftened) {
  SoftWorld bullet;
  SoftBodySettings s = testedSettings();
  s.extensionStiffness = s.compressionStiffness = 1e12;
  s.stepping.stepper = Stepper::Verlet;
  SoftBody* body = bullet.addSoft(ropeNetwork(2), s);
  bullet.simulate(0.2);
  const double softening = body->softening();
  EXPECT_LT(softening, 0.1);
  addCubeFarAway(bullet.system);
  bullet.simulate(0.2);
  EXPECT_EQ(body->softening(), softening);
  EXPECT_EQ(body->restorations(), 0u);
}

/// A spring alone needs more substeps than a tick may have.
TEST(Bystanders, aLinkThatIsTooStiffThrowsNothing) {
  for (const double stiffness : {1e6, 1e8, 1e12}) {
    SoftWorld bullet;
    btRigidBody* box = bullet.addAwakeBox(vec(0.1, 0.1, 0.1), 0.01, vec(0, 0, 0));
    SpringSettings spring;
    spring.stiffness = stiffness;
    ASSERT_TRUE(bullet.system.addSpring({box, vec(2, 0, 0)}, {nullptr, vec(2, 1, 0)}, spring));
    for (int i = 0; i < 60; ++i) {
      bullet.tick();
      // it swings down by at most its distance from the pivot
      ASSERT_LT(double(box->getLinearVelocity().length()), std::sqrt(2 * 9.81 * 3.0)) << stiffness;
    }
  }
}

TEST(Bystanders, aQueryOfForcesBreaksNoSprings) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.elasticLimit.breakStrain = 0.5;
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
  ASSERT_TRUE(cube->pin(0));
  bullet.tick();
  const Eigen::Vector3d start = cube->position(0);
  ASSERT_TRUE(cube->teleportPin(0, vec(start.x() - 3.0, start.y(), start.z())));
  EXPECT_GT(cube->pinForce(0).length(), btScalar(100));
  ASSERT_TRUE(cube->teleportPin(0, vec(start.x(), start.y(), start.z())));
  bullet.tick();
  EXPECT_TRUE(cube->brokenSprings().empty());
}

TEST(Bystanders, aSlackRopeHasNoDamping) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.compressionStiffness = 0.0;
  s.damping = 10.0;
  SoftBody* body = bullet.addSoft(ropeNetwork(1), s);
  ASSERT_TRUE(body->pin(0));
  bullet.tick();
  body->point(1)->getWorldTransform().setOrigin(vec(0.5, 0, 0));
  body->point(1)->setLinearVelocity(vec(2, 0, 0));
  EXPECT_EQ(body->pinForce(0).length(), btScalar(0));
}

TEST(Bystanders, whatHungOnABodyThatGoesFalls) {
  enum class Way { Detach, Destroy, Forget, RemoveAll };
  for (const Way way : {Way::Detach, Way::Destroy, Way::Forget, Way::RemoveAll}) {
    SoftWorld bullet;
    SoftBodySettings s = settingsAt({0, 5, 0});
    s.damping = 20.0;
    SoftBody* body = bullet.addSoft(ropeNetwork(4), s);
    for (std::uint32_t i = 0; i < 4; ++i) ASSERT_TRUE(body->pin(i));
    btRigidBody* box = bullet.addBox(vec(0.2, 0.2, 0.2), 1.0, vec(1, 4, 0));
    ASSERT_TRUE(bullet.system.attach(body, 4u, *box, vec(0, 1, 0)));
    for (int i = 0; i < 3000 && !body->sleeping(); ++i) bullet.tick();
    ASSERT_TRUE(body->sleeping());
    const double height = heightOf(*box);
    switch (way) {
      case Way::Detach:
        EXPECT_TRUE(bullet.system.detach(body, 4u));
        break;
      case Way::Destroy:
        EXPECT_TRUE(bullet.system.destroyBody(body));
        break;
      case Way::Forget:
        bullet.system.forget(*box);
        break;
      case Way::RemoveAll:
        bullet.system.removeAll();
        break;
    }
    bullet.simulate(1.0);
    EXPECT_LT(heightOf(*box), height - 4.0) << int(way);
  }
}

/// The second body is mirrored in the saved state.
TEST(Bystanders, aStateThatIsRefusedChangesNoBody) {
  SoftWorld bullet(0.0);
  std::vector<std::uint8_t> state;
  const auto addTwo = [](SoftBodySystem& system, double side) {
    SoftBodySettings s = testedSettings();
    ASSERT_TRUE(system.createBody(closedCubeNetwork(), s));
    s.position = {3, 0, 0};
    s.scale.x() = side;
    ASSERT_TRUE(system.createBody(closedCubeNetwork(), s));
  };
  {
    SoftBodySystem system(*bullet.world);
    addTwo(system, -1.0);
    system.body(0)->setVelocity(vec(1, 0, 0));
    bullet.simulate(0.5);
    state = system.saveState();
  }
  addTwo(bullet.system, 1.0);
  const Result<void> restored = bullet.system.restoreState(state);
  ASSERT_FALSE(restored);
  EXPECT_NE(restored.error().find("body 1"), std::string::npos) << restored.error();
  EXPECT_EQ(bullet.system.body(0)->centerOfMass().x(), 0.0);
}

}  // namespace
}  // namespace limber::test
