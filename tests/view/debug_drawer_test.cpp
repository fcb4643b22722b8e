// SPDX-License-Identifier: Zlib
#include <limber/view/debug_drawer.h>

#include "support/bullet_world.h"
#include "support/networks.h"

#include <limber/soft_body_system.h>

#include <gtest/gtest.h>

namespace limber::view {
namespace {

using test::BulletWorld;
using test::vec;

TEST(DebugDrawer, RigidAndSoftBodiesConstraintsAndContactsBecomeLines) {
  BulletWorld bullet;
  SoftBodySystem system(*bullet.world);
  bullet.addBoxFloor();
  btRigidBody* box = bullet.addBox(vec(0.5, 0.5, 0.5), 1.0, vec(3, 0.5, 0));
  btPoint2PointConstraint hook(*box, vec(0, 0.5, 0));
  bullet.world->addConstraint(&hook);
  SoftBodySettings s;
  s.position = {0, 0.6, 0};
  ASSERT_TRUE(system.createBody(test::closedCubeNetwork(), s));
  bullet.simulate(1.0);

  DebugDrawer drawer;
  bullet.world->setDebugDrawer(&drawer);
  const auto lineCount = [&](int mode) {
    drawer.setDebugMode(mode);
    drawer.overlay.clear();
    bullet.world->debugDrawWorld();
    return drawer.overlay.size();
  };
  EXPECT_EQ(lineCount(btIDebugDraw::DBG_NoDebug), 0u);
  EXPECT_GE(lineCount(btIDebugDraw::DBG_DrawWireframe), 24u + 2u * 12u) << "springs, and the boxes' edges";
  EXPECT_GT(lineCount(btIDebugDraw::DBG_DrawConstraints), 0u);
  EXPECT_GT(lineCount(btIDebugDraw::DBG_DrawContactPoints), 0u);
  EXPECT_GE(lineCount(btIDebugDraw::DBG_DrawAabb), 3u * 12u);
  bullet.world->setDebugDrawer(nullptr);
  bullet.world->removeConstraint(&hook);
}

TEST(DebugDrawer, ContactsAreACrossAndTheirNormal) {
  DebugDrawer drawer;
  drawer.drawContactPoint(vec(1, 2, 3), vec(0, 1, 0), 0, 0, vec(1, 0, 0));
  ASSERT_EQ(drawer.overlay.size(), 4u);
  EXPECT_FLOAT_EQ(drawer.overlay[0].to.y, 2.0f + drawer.contactSize);
  EXPECT_FLOAT_EQ(drawer.overlay[0].colour.x, 1.0f);
}

TEST(DebugDrawer, WarningsGoToTheHandler) {
  DebugDrawer drawer;
  std::string warning;
  drawer.onWarning = [&](const std::string& text) { warning = text; };
  drawer.reportErrorWarning("oh");
  EXPECT_EQ(warning, "oh");
}

}  // namespace
}  // namespace limber::view
