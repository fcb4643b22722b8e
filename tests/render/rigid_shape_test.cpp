// SPDX-License-Identifier: Zlib
#include "limber/render/rigid_shape.h"

#include <cmath>
#include <cstddef>

#include "computed_points.h"
#include "test_scene.h"

namespace limber::render::test {
namespace {

class RigidPlaces : public ::testing::TestWithParam<ComputeOn> {};

TEST_P(RigidPlaces, AreTheScenerysPointsMovedByTheFrame) {
  const Scenery ball = makeUvSphere({0.3f, 0.1f, -0.2f}, 0.5f, 6, 9);
  const RigidShape rigid = makeRigid(ball);
  // A quarter turn about y, stretched along z, far from the origin.
  const Frame frame{{100.0f, 50.0f, -200.0f}, {0.0f, 0.0f, -1.0f}, {0.0f, 1.0f, 0.0f}, {2.0f, 0.0f, 0.0f}};
  std::vector<float> points(12);
  writeFrame(rigid.reach, frame, points.data());
  Stage stage(Backend::Auto, smallDesc(GetParam()));
  const InstanceId id = stage.add(stage.renderer().addShape(rigid.shape), points);
  stage.draw();
  const std::vector<float> places = readSkinnedPoints(stage.renderer(), id);
  ASSERT_EQ(places.size(), ball.points.size());
  // Four products of at most 4 x 200 m, each rounded to 24 bits.
  constexpr float kTolerance = 4.0f * 4.0f * 200.0f * 6e-8f;
  for (std::size_t i = 0; i < places.size(); i += 3) {
    EXPECT_NEAR(places[i], 100.0f + 2.0f * ball.points[i + 2], kTolerance);
    EXPECT_NEAR(places[i + 1], 50.0f + ball.points[i + 1], kTolerance);
    EXPECT_NEAR(places[i + 2], -200.0f - ball.points[i], kTolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(ComputeOn, RigidPlaces, ::testing::Values(ComputeOn::Gpu, ComputeOn::Cpu));

TEST(RigidShape, AFrameTakes48Bytes) {
  const RigidShape rigid = makeRigid(makeUvSphere({}, 0.5f, 6, 9));
  Stage stage(Backend::Auto, smallDesc(ComputeOn::Gpu));
  stage.add(stage.renderer().addShape(rigid.shape), std::vector<float>(12));
  stage.draw();
  EXPECT_EQ(stage.renderer().lastFrame().bytesStreamed, 48u);
}

TEST(RigidShape, LooksAsTheSceneryDoes) {
  const Scenery box = makeBox({0.0f, 0.5f, 0.0f}, {0.7f, 0.5f, 0.3f});
  const RigidShape rigid = makeRigid(box);
  std::vector<float> points(12);
  writeFrame(rigid.reach, {}, points.data());
  Stage stage, other;
  stage.add(stage.renderer().addShape(rigid.shape), points);
  other.add(box);
  // The last bit of a coordinate may move an edge by one of the 256 steps in a pixel. Inside no level
  // changes; at the edge a pixel may change sides.
  EXPECT_LE(differingShare(stage.picture(), other.picture(), 2) * kWidth * kHeight, 4.5);
}

}  // namespace
}  // namespace limber::render::test
