// SPDX-License-Identifier: Zlib
// The method of Bullet's example browser must give the same picture; otherwise the bench's comparison is not
// valid.
#include <stdexcept>

#include "baseline_picture.h"

namespace limber::render::test {
namespace {

// Both shade with the same normals up to float rounding (1e-5 for flat ones, which are differences between
// pixels). This changes a colour by far less than a level, but may change the rounding of a channel.
constexpr int kRounding = 1;
// At the edge of a shadow it may also change a depth comparison, worth a sixteenth of the sunlight.
constexpr double kFlippedFraction = 1e-3;

struct PathPictures {
  Image ring, unshared;
};

PathPictures drawBoth(bool shadows) {
  Stage stage;
  populateMeshes(stage);
  stage.light.shadows = shadows;
  const Image ring = stage.picture();
  return {ring, pictureAs(*bench::makeUnsharedBodies(stage.renderer()), stage)};
}

TEST(UnsharedPath, PictureIsThatOfTheRing) {
  const PathPictures pictures = drawBoth(false);
  EXPECT_LE(largestDifference(pictures.ring, pictures.unshared), kRounding);
}

TEST(UnsharedPath, PictureIsThatOfTheRingWithShadows) {
  const PathPictures pictures = drawBoth(true);
  EXPECT_LE(differingShare(pictures.ring, pictures.unshared, kRounding), kFlippedFraction);
}

TEST(UnsharedPath, FollowsWhatMoves) {
  Stage stage;
  Scenery ball = makeUvSphere({}, 0.5f);
  const ShapeId shape = stage.renderer().addShape(ball.shape);
  stage.add(shape, ball.points);
  const auto unshared = bench::makeUnsharedBodies(stage.renderer());
  const Image before = pictureAs(*unshared, stage);
  stage.add(shape, moved(ball.points, 0.8f, 0.4f, 0.3f));
  const Image after = pictureAs(*unshared, stage);
  EXPECT_GT(largestDifference(before, after), 50);
  EXPECT_LE(largestDifference(after, stage.picture()), kRounding);
}

TEST(UnsharedPath, UploadsThreeVerticesPerTriangleAndDrawsEachBodyByItself) {
  Stage stage;
  const Scenery box = makeBox({}, {0.3f, 0.3f, 0.3f});
  const ShapeId shape = stage.renderer().addShape(box.shape);
  for (int i = 0; i < 5; ++i) stage.add(shape, moved(box.points, 0.5f * static_cast<float>(i), 0.5f, 0.0f));
  const auto unshared = bench::makeUnsharedBodies(stage.renderer());
  drawAs(*unshared, stage);
  const FrameStats& stats = stage.renderer().lastFrame();
  EXPECT_EQ(stats.bytesStreamed, 5u * 12u * 3u * 36u);
  EXPECT_EQ(stats.shapeDrawCalls, 2u * 5u) << "shadows, then colours";
  EXPECT_EQ(stats.dispatches, 0u);
  constexpr std::size_t kVertices = 5 * 36;
  EXPECT_EQ(unshared->bytes(), kVertices * (36 + 4)) << "vertices and indices";
}

TEST(UnsharedPath, RefusesTubesAndLines) {
  Stage stage;
  stage.add(springBox(0.3f));
  DrawOptions wireframe;
  wireframe.mode = DrawMode::Wireframe;
  const auto unshared = bench::makeUnsharedBodies(stage.renderer());
  EXPECT_THROW(drawAs(*unshared, stage, wireframe), std::runtime_error);
  EXPECT_NO_THROW(drawAs(*unshared, stage)) << "the frame is still open";
  stage.add(rope(5));
  EXPECT_THROW(drawAs(*unshared, stage), std::runtime_error);
  EXPECT_NO_THROW(stage.draw());
}

}  // namespace
}  // namespace limber::render::test
