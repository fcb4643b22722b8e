// SPDX-License-Identifier: Zlib
#include <limber/view/rigid_view.h>

#include "support/bullet_world.h"
#include "support/networks.h"

#include <limber/render/gl_context.h>
#include <limber/soft_body_system.h>

#include <gtest/gtest.h>

#include <exception>
#include <limits>

#include "test_scene.h"

namespace limber::view {
namespace {

using test::BulletWorld;
using test::vec;

struct RigidViewTest : ::testing::Test {
  BulletWorld bullet{0.0};
  // on the GPU only points are streamed
  render::test::Stage stage{render::Backend::Auto, render::test::smallDesc(render::ComputeOn::Gpu)};

  void draw(const RigidView& view, double tickFraction = 1.0) {
    render::FrameWriter frame = stage.renderer().beginFrame();
    view.write(frame, tickFraction);
    stage.renderer().draw(frame, stage.camera, stage.light);
  }
  btRigidBody* addSphere(double radius, const btVector3& at) {
    return bullet.add(std::make_unique<btSphereShape>(btScalar(radius)), 1.0, at);
  }
  btRigidBody* addCylinder(const btVector3& at) {
    return bullet.add(std::make_unique<btCylinderShape>(vec(0.3, 0.4, 0.3)), 1.0, at);
  }
};

TEST_F(RigidViewTest, ShapesAreSharedAndFewBytesStreamed) {
  for (int i = 0; i < 5; ++i) {
    bullet.addBox(vec(0.1 + 0.1 * i, 0.2, 0.3), 1.0, vec(i, 0, 0));
    addSphere(0.1 + 0.1 * i, vec(i, 2, 0));
  }
  addCylinder(vec(0, 4, 0));
  stage.light.shadows = false;
  const RigidView view(stage.renderer(), *bullet.world);
  EXPECT_EQ(view.objectCount(), 11u);
  draw(view);
  EXPECT_EQ(stage.renderer().lastFrame().bytesStreamed, 11u * 48u);
  EXPECT_EQ(stage.renderer().lastFrame().shapeDrawCalls, 3u);
}

TEST_F(RigidViewTest, LooksLikeTheBodyInItsPlace) {
  btRigidBody* box = bullet.addBox(vec(0.3, 0.2, 0.1), 1.0, vec(0.4, 0.6, -0.2));
  box->getWorldTransform().setRotation(btQuaternion(btVector3(0, 1, 0), btScalar(1.5707963)));
  stage.light.shadows = false;
  const auto red = [](const btCollisionObject&) { return render::InstanceLook{{0.9f, 0.2f, 0.2f}, {}}; };
  const RigidView view(stage.renderer(), *bullet.world, red);
  draw(view);
  const render::Image actual = stage.renderer().readPixels();

  render::test::Stage other;
  other.light.shadows = false;
  other.add(render::makeBox({0.4f, 0.6f, -0.2f}, {0.1f, 0.2f, 0.3f}), {{0.9f, 0.2f, 0.2f}, {}});
  const render::Image expected = other.picture();
  // rounding may put an edge on the other side of a pixel's centre
  std::size_t different = 0;
  for (std::size_t i = 0; i < actual.rgba.size(); i += 4)
    different += std::abs(actual.rgba[i] - expected.rgba[i]) > 2;
  EXPECT_LE(different, 6u);
}

TEST_F(RigidViewTest, BodiesComeAndGo) {
  btRigidBody* first = addSphere(0.5, vec(0, 0, 0));
  RigidView view(stage.renderer(), *bullet.world);
  btRigidBody* second = addCylinder(vec(2, 0, 0));
  draw(view);
  EXPECT_EQ(view.objectCount(), 1u) << "until the next update";
  view.update();
  EXPECT_EQ(view.objectCount(), 2u);
  const std::size_t bytes = stage.renderer().gpuMemory().shapes;
  bullet.world->removeRigidBody(second);
  draw(view);
  view.update();
  EXPECT_EQ(view.objectCount(), 1u);
  EXPECT_LT(stage.renderer().gpuMemory().shapes, bytes) << "the cylinder's shape went with it";
  bullet.world->removeRigidBody(first);
  view.update();
  EXPECT_EQ(stage.renderer().instanceCount(), 0u);
}

TEST_F(RigidViewTest, ANewShapeOfABodyIsSeen) {
  btRigidBody* body = addSphere(0.5, vec(0, 0, 0));
  RigidView view(stage.renderer(), *bullet.world);
  draw(view);
  const render::Image sphere = stage.renderer().readPixels();
  btCylinderShape cylinder(vec(0.2, 0.9, 0.2));
  btCollisionShape* old = body->getCollisionShape();
  body->setCollisionShape(&cylinder);
  view.update();
  draw(view);
  EXPECT_EQ(view.objectCount(), 1u);
  EXPECT_NE(stage.renderer().readPixels().rgba, sphere.rgba);
  body->setCollisionShape(old);
}

TEST_F(RigidViewTest, AnObjectInTheMemoryOfAnOldOneIsANewOne) {
  btRigidBody* body = addSphere(0.5, vec(0, 0, 0));
  int looks = 0;
  RigidView view(stage.renderer(), *bullet.world, [&](const btCollisionObject&) {
    ++looks;
    return render::InstanceLook{};
  });
  view.update();
  EXPECT_EQ(looks, 1);
  bullet.world->removeRigidBody(body);
  bullet.world->addRigidBody(body);
  view.update();
  EXPECT_EQ(looks, 2);
  EXPECT_EQ(stage.renderer().instanceCount(), 1u);
}

TEST_F(RigidViewTest, ALookThatIsRefusedLeavesNothingBehind) {
  addSphere(0.5, vec(0, 0, 0));
  float red = 0.5f;
  RigidView view(stage.renderer(), *bullet.world, [&](const btCollisionObject&) {
    return render::InstanceLook{{red, 0.5f, 0.5f}, {}};
  });
  const std::size_t bytes = stage.renderer().gpuMemory().shapes;
  addCylinder(vec(2, 0, 0));
  red = std::numeric_limits<float>::infinity();
  EXPECT_THROW(view.update(), std::exception);
  EXPECT_EQ(stage.renderer().gpuMemory().shapes, bytes);
  EXPECT_EQ(stage.renderer().instanceCount(), 1u);
  red = 0.5f;
  view.update();
  EXPECT_EQ(stage.renderer().instanceCount(), 2u);
}

TEST_F(RigidViewTest, GhostsEmptyShapesAndPartsOfSoftBodiesAreLeftOut) {
  addSphere(0.5, vec(0, 5, 0));
  btRigidBody* ghost = addSphere(0.5, vec(0, 7, 0));
  ghost->setCollisionFlags(ghost->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  bullet.add(std::make_unique<btEmptyShape>(), 0.0, vec(0, 0, 0));
  SoftBodySystem system(*bullet.world);
  for (const Collision representation : {Collision::Points, Collision::Surface}) {
    SoftBodySettings s;
    s.collision = representation;
    ASSERT_TRUE(system.createBody(test::closedCubeNetwork(), s));
  }
  bullet.tick();
  const RigidView view(stage.renderer(), *bullet.world);
  EXPECT_EQ(view.objectCount(), 1u);
}

TEST_F(RigidViewTest, FollowsBulletBetweenTicks) {
  btRigidBody* body = addSphere(0.2, vec(0, 0, 0));
  body->setLinearVelocity(vec(6, 0, 0));
  body->setActivationState(DISABLE_DEACTIVATION);
  bullet.tick();
  stage.light.shadows = false;
  RigidView view(stage.renderer(), *bullet.world);
  draw(view, 0.5);
  const render::Image half = stage.renderer().readPixels();
  body->getWorldTransform().setOrigin(vec(0.05, 0, 0));
  draw(view, 1.0);
  EXPECT_LE(render::test::largestDifference(half, stage.renderer().readPixels()), 2)
      << "half of a tick at 6 m/s";
}

}  // namespace
}  // namespace limber::view
