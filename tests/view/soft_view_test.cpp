// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>
#include <limber/view/soft_view.h>

#include "support/bullet_world.h"
#include "support/networks.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <exception>
#include <limits>

#include "computed_points.h"
#include "test_scene.h"

namespace limber::view {
namespace {

using test::BulletWorld;

struct SoftViewTest : ::testing::Test {
  BulletWorld bullet{0.0};
  SoftBodySystem system{*bullet.world};
  // on the GPU only points are streamed
  render::test::Stage stage{render::Backend::Auto, render::test::smallDesc(render::ComputeOn::Gpu)};
  SharedNetwork cube = test::closedCubeNetwork();

  SoftBody* add(const SharedNetwork& network, double x, double size = 1.0) {
    SoftBodySettings s;
    s.position = {x, 0, 0};
    s.scale = Eigen::Vector3d::Constant(size);
    const Result<SoftBody*> body = system.createBody(network, s);
    EXPECT_TRUE(body) << body.error();
    return *body;
  }
  void draw(const SoftView& view) {
    render::FrameWriter frame = stage.renderer().beginFrame();
    view.write(frame);
    stage.renderer().draw(frame, stage.camera, stage.light);
  }
};

TEST_F(SoftViewTest, BodiesOfOneNetworkAreDrawnTogetherFromTheirPoints) {
  for (int i = 0; i < 4; ++i) add(cube, 2.0 * i);
  add(cube, -3.0, 0.5);
  stage.light.shadows = false;
  const SoftView view(stage.renderer(), system);
  EXPECT_EQ(view.pointCount(), 5u * 8u);
  draw(view);
  EXPECT_EQ(stage.renderer().lastFrame().bytesStreamed, 5u * 8u * 12u);
  EXPECT_EQ(stage.renderer().lastFrame().shapeDrawCalls, 2u) << "strain needs the rest lengths of each size";
}

TEST_F(SoftViewTest, BodiesComeAndGo) {
  SoftBody* first = add(cube, 0.0);
  SoftView view(stage.renderer(), system);
  add(test::tetrahedronNetwork(), 2.0);
  view.update();
  EXPECT_EQ(stage.renderer().instanceCount(), 2u);
  draw(view);
  system.destroyBody(first);
  draw(view);
  view.update();
  EXPECT_EQ(stage.renderer().instanceCount(), 1u);
  system.removeAll();
  view.update();
  EXPECT_EQ(stage.renderer().instanceCount(), 0u);
  EXPECT_EQ(stage.renderer().gpuMemory().shapes, 0u);
  draw(view);
}

TEST_F(SoftViewTest, ABodyInTheMemoryOfAnOldOneIsANewOne) {
  // the allocator may return the same address again or not; the view must be correct in both cases
  int looks = 0;
  SoftView view(stage.renderer(), system, [&](const SoftBody&) {
    ++looks;
    return SoftLook{};
  });
  for (int i = 0; i < 20; ++i) {
    SoftBody* body = add(i / 2 % 2 == 0 ? cube : test::tetrahedronNetwork(), 0.0);
    view.update();
    EXPECT_EQ(view.pointCount(), body->pointCount());
    EXPECT_EQ(looks, i + 1);
    draw(view);
    system.destroyBody(body);
  }
}

TEST_F(SoftViewTest, ALookThatIsRefusedLeavesNothingBehind) {
  SoftBody* first = add(cube, 0.0);
  float red = 0.5f;
  SoftView view(stage.renderer(), system, [&](const SoftBody&) {
    SoftLook look;
    look.instance.colour = {red, 0.5f, 0.5f};
    return look;
  });
  // the new body may have the memory of the first one
  system.destroyBody(first);
  add(cube, 0.0);
  red = std::numeric_limits<float>::infinity();
  EXPECT_THROW(view.update(), std::exception);
  red = 0.5f;
  view.update();
  EXPECT_EQ(stage.renderer().instanceCount(), 1u);
}

TEST_F(SoftViewTest, BodiesThatHideTheirBackFacesHaveAShapeOfTheirOwn) {
  const SoftBody* hides = add(cube, 0.0);
  add(cube, 2.0);
  stage.light.shadows = false;
  const SoftView view(stage.renderer(), system, [&](const SoftBody& body) {
    SoftLook look;
    look.hideBackFaces = &body == hides;
    return look;
  });
  draw(view);
  EXPECT_EQ(stage.renderer().lastFrame().shapeDrawCalls, 2u);
}

TEST_F(SoftViewTest, AMirroredBodyShowsItsOutside) {
  SoftBodySettings s;
  s.scale = {-1, 1, 1};
  ASSERT_TRUE(system.createBody(cube, s));
  const auto pictureOf = [&](bool hidesBackFaces) {
    const SoftView view(stage.renderer(), system, [&](const SoftBody&) {
      SoftLook look;
      look.hideBackFaces = hidesBackFaces;
      return look;
    });
    draw(view);
    return stage.renderer().readPixels();
  };
  EXPECT_EQ(pictureOf(true).rgba, pictureOf(false).rgba);
}

TEST_F(SoftViewTest, MayEndWhileAFrameIsOpen) {
  add(cube, 0.0);
  {
    const render::FrameWriter frame = [&] {
      const SoftView view(stage.renderer(), system);
      return stage.renderer().beginFrame();
    }();
    EXPECT_EQ(stage.renderer().instanceCount(), 0u);
  }
  EXPECT_EQ(stage.renderer().gpuMemory().shapes, 0u);
}

TEST_F(SoftViewTest, TheLookIsAskedOnceForEachBody) {
  add(cube, 0.0);
  int calls = 0;
  SoftView view(stage.renderer(), system, [&](const SoftBody&) {
    ++calls;
    return SoftLook{};
  });
  view.update();
  view.update();
  EXPECT_EQ(calls, 1);
}

/// A ball of 12 points whose skin has 162 places.
SharedNetwork skinnedBall(SkinKind kind) {
  const Result<SharedNetwork> coarse = buildNetwork(small_meshes::icosphere(0), {});
  SkinSettings settings;
  settings.kind = kind;
  settings.neighbours = 4;
  const Result<SharedNetwork> skinned = withSkin(**coarse, small_meshes::icosphere(2), settings);
  EXPECT_TRUE(skinned) << skinned.error();
  return *skinned;
}

TEST_F(SoftViewTest, BothProcessorsPutTheVerticesWhereTheBodySaysTheyAre) {
  for (const SkinKind kind : {SkinKind::Dense, SkinKind::Sparse}) {
    SoftBody* body = add(skinnedBall(kind), 1.0);
    body->pin(0);
    body->movePin(0, btVector3(1.5f, 0.7f, -0.4f));
    bullet.tick();
    std::vector<float> points(3 * body->pointCount()), expected(3 * body->skinnedPointCount());
    body->writePositions(points.data());
    body->writeSkinnedPositions(expected.data());
    for (const render::ComputeOn computeOn : {render::ComputeOn::Cpu, render::ComputeOn::Gpu}) {
      render::test::Stage own(render::Backend::Auto, render::test::smallDesc(computeOn));
      const render::ShapeDesc shape = shapeOf(*body, render::Shading::Smooth);
      const render::InstanceId id = own.add(own.renderer().addShape(shape), points);
      own.draw();
      const std::vector<float> places = render::test::readSkinnedPoints(own.renderer(), id);
      ASSERT_EQ(places.size(), expected.size());
      // sums of a dozen products of numbers below 4, each rounded to 24 bits
      for (std::size_t i = 0; i < places.size(); ++i) ASSERT_NEAR(places[i], expected[i], 3e-6);
    }
  }
}

TEST_F(SoftViewTest, EdgesAreSharpWhereTheBodyAtRestBendsMore) {
  const SoftBody* box = add(cube, 1.0);
  SoftLook look;
  EXPECT_EQ(normalCount(shapeOf(*box, look)), 8u);
  look.sharpAngle = 0.75f;
  EXPECT_EQ(normalCount(shapeOf(*box, look)), 24u);
  look.sharpAngle = 2.0f;
  EXPECT_EQ(normalCount(shapeOf(*box, look)), 8u);
  const SoftBody* ball = add(skinnedBall(SkinKind::Dense), 3.0);
  look.sharpAngle = 0.75f;
  EXPECT_EQ(normalCount(shapeOf(*ball, look)), ball->skinnedPointCount());
}

}  // namespace
}  // namespace limber::view
