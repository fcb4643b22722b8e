// SPDX-License-Identifier: Zlib
// Each contact check must fail in a scene with errors. The checks of positions alone must pass in a new
// scene.
#include "created_scene.h"
#include "scenes/end_checks.h"
#include "scenes/scene.h"

#include <gtest/gtest.h>

namespace limber::scenes {
namespace {

void shift(SoftBody& body, const Eigen::Vector3d& by) {
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    const btVector3 to = toBullet(body.position(i) + by);
    if (body.pinned(i)) {
      EXPECT_TRUE(body.teleportPin(i, to));
      continue;
    }
    body.point(i)->getWorldTransform().setOrigin(to);
    body.point(i)->getInterpolationWorldTransform() = body.point(i)->getWorldTransform();
  }
}

/// Returns the first message of the scene's own checks that contains `part`, or an empty string.
std::string messageWith(const Scene& scene, const char* part) {
  for (const Check& check : scene.endChecks) {
    const std::string text = check(scene);
    if (text.find(part) != std::string::npos) return text;
  }
  return {};
}

TEST(ContactChecks, softBodiesInOneAnotherAreFound) {
  const auto scene = created("stack", 3);
  EXPECT_EQ(checkSoftApart(1e-3)(*scene), "");
  shift(*scene->soft->body(2), {0, -0.2, 0});
  EXPECT_NE(checkSoftApart(1e-3)(*scene), "");
  EXPECT_EQ(checkSoftApart(0.3)(*scene), "");
}

TEST(ContactChecks, rigidBodiesInSoftOnesAreFound) {
  const auto scene = created("tower-of-jelly", 2);
  EXPECT_EQ(checkRigidApart(1e-3)(*scene), "");
  moveTo(*scene->world->movables[0], {0, 0.35, 0});
  EXPECT_NE(checkRigidApart(1e-3)(*scene).find("moving body 0"), std::string::npos);
}

TEST(ContactChecks, pointsInTheFloorAreFound) {
  const auto scene = created("stack", 1);
  shift(*scene->soft->body(0), {0, -0.1, 0});
  EXPECT_NE(checkRigidApart(1e-3)(*scene).find("static body 0"), std::string::npos);
}

TEST(ContactChecks, whatHasBeenTooDeepIsRemembered) {
  const auto scene = created("marble", 1);
  watchMovablesApart(*scene, 0.02);
  const Check& remembered = scene->endChecks.back();
  scene->afterTick(*scene);
  EXPECT_EQ(remembered(*scene), "");
  const Eigen::Vector3d oldPosition = fromBullet(scene->world->movables[0]->getWorldTransform().getOrigin());
  moveTo(*scene->world->movables[0], {0, 0.9, 0});
  scene->afterTick(*scene);
  moveTo(*scene->world->movables[0], oldPosition);
  scene->afterTick(*scene);
  EXPECT_NE(remembered(*scene).find("in one another"), std::string::npos);
}

TEST(ContactChecks, movingBodiesAreNotCalm) {
  const auto scene = created("tower-of-jelly", 1);
  EXPECT_EQ(checkMovablesCalm(0.01)(*scene), "");
  scene->world->movables[0]->setLinearVelocity(btVector3(1, 0, 0));
  EXPECT_NE(checkMovablesCalm(0.01)(*scene).find("1 m/s"), std::string::npos);
}

TEST(MarbleScene, tellsWhereMarblesAre) {
  const auto scene = created("marble", 2);
  btRigidBody &droppedMarble = *scene->world->movables[0], &shotMarble = *scene->world->movables[1];
  EXPECT_NE(messageWith(*scene, "does not rest on a face"), "");  // still in the air
  const Eigen::Vector3d cube = middleOf(*scene->soft->body(0)), target = middleOf(*scene->soft->body(1));
  moveTo(droppedMarble, cube + Eigen::Vector3d(0.2, 0.57, 0.1));
  EXPECT_EQ(messageWith(*scene, "marble"), "");
  moveTo(droppedMarble, cube + Eigen::Vector3d(0.7, -0.4, 0));
  EXPECT_NE(messageWith(*scene, "does not lie on top"), "");
  moveTo(droppedMarble, cube);
  EXPECT_NE(messageWith(*scene, "marble 0 is inside its cube"), "");
  moveTo(droppedMarble, cube + Eigen::Vector3d(0.2, 0.57, 0.1));
  moveTo(shotMarble, target + Eigen::Vector3d(0, 0, -0.8));
  EXPECT_NE(messageWith(*scene, "marble 1 has passed its cube"), "");
}

TEST(StackScene, tellsWhatHasFallen) {
  const auto scene = created("stack", 4);
  EXPECT_EQ(messageWith(*scene, "cube"), "");
  shift(*scene->soft->body(2), {0.5, 0, 0});
  EXPECT_NE(messageWith(*scene, "cube 2 has slipped aside"), "");
  shift(*scene->soft->body(2), {0, -1, 0});
  EXPECT_NE(messageWith(*scene, "cube 2 does not stand"), "");
}

TEST(TowerScene, tellsWhatHasFallen) {
  const auto scene = created("tower-of-jelly", 3);
  EXPECT_EQ(messageWith(*scene, "storey"), "");
  btRigidBody& plate = *scene->world->movables[1];
  const btTransform built = plate.getWorldTransform();
  plate.getWorldTransform().setRotation(btQuaternion(btVector3(1, 0, 0), btScalar(0.5)));
  EXPECT_NE(messageWith(*scene, "storey 1 is not level"), "");
  plate.setWorldTransform(built);
  moveTo(plate, fromBullet(built.getOrigin()) + Eigen::Vector3d(0.4, 0, 0));
  EXPECT_NE(messageWith(*scene, "storey 1 has slipped aside"), "");
  plate.setWorldTransform(built);
  shift(*scene->soft->body(2), {0, -0.5, 0});
  EXPECT_NE(messageWith(*scene, "storey 2 has come down"), "");
}

TEST(TowerScene, isNudgedOnce) {
  const auto scene = created("tower-of-jelly", 1);
  const btRigidBody& top = *scene->world->movables.back();
  scene->beforeTick(*scene);
  EXPECT_EQ(top.getLinearVelocity().x(), btScalar(0));
  scene->ticks = 4 * kTicksPerSecond;
  scene->beforeTick(*scene);
  EXPECT_GT(top.getLinearVelocity().x(), btScalar(0));
}

TEST(CurtainScene, tellsWhatHasPassedOrComeOff) {
  const auto scene = created("curtain", 1);
  EXPECT_EQ(messageWith(*scene, "curtain 0"), "");
  EXPECT_EQ(messageWith(*scene, "passed"), "");
  moveTo(*scene->world->movables[2], {0.5, 0.2, -0.5});
  EXPECT_NE(messageWith(*scene, "ball 1 has passed through"), "");
  shift(*scene->soft->body(0), {0, -0.1, 0});
  EXPECT_NE(messageWith(*scene, "does not hang from its pins"), "");
}

TEST(CurtainScene, theBoxPushesAndGoesBack) {
  const auto scene = created("curtain", 1);
  const btRigidBody& box = *scene->world->movables[0];
  const auto z = [&] { return double(box.getWorldTransform().getOrigin().z()); };
  const double start = z();
  double lowest = start;
  for (int i = 0; i < 5 * kTicksPerSecond; ++i, ++scene->ticks) {
    scene->beforeTick(*scene);
    lowest = std::min(lowest, z());
  }
  EXPECT_NEAR(lowest, -0.3, 1e-3);
  EXPECT_NEAR(z(), start, 1e-6);
}

TEST(PileScene, tellsWhatIsNotInTheBin) {
  const auto scene = created("pile", 5);
  EXPECT_EQ(messageWith(*scene, "bin"), "");
  EXPECT_EQ(messageWith(*scene, "deep in"), "");
  shift(*scene->soft->body(3), {4, 0, 0});
  EXPECT_NE(messageWith(*scene, "body 3 is not in the bin"), "");
  shift(*scene->soft->body(4), middleOf(*scene->soft->body(0)) - middleOf(*scene->soft->body(4)));
  EXPECT_NE(messageWith(*scene, "deep in"), "");
}

}  // namespace
}  // namespace limber::scenes
