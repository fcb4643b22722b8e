// SPDX-License-Identifier: Zlib
// The contents of pictures, tested by a few pixels far from any edge.
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "test_scene.h"

namespace limber::render::test {
namespace {

void lookDown(Stage& stage) {
  stage.camera.eye = {0.0f, 6.0f, 0.01f};
  stage.camera.target = {0.0f, 0.0f, 0.0f};
  stage.camera.up = {0.0f, 0.0f, -1.0f};
}

// Returns a square facing up at height y; with its corners in reverse order it faces down.
Scenery square(float halfSize, float y, bool facingUp, bool twoSided) {
  Scenery quad = makeFloor({0.0f, y, 0.0f}, halfSize);
  quad.shape.pattern = Pattern::Plain;
  quad.shape.twoSided = twoSided;
  quad.shape.castsShadow = true;
  if (!facingUp) {
    quad.shape.triangles = {0, 2, 1, 0, 3, 2};
  }
  return quad;
}

TEST(Look, BackgroundIsTheColourAskedForTopDown) {
  Stage stage;
  DrawOptions options;
  options.backgroundTop = {1.0f, 0.5f, 0.0f};
  options.backgroundBottom = {0.0f, 0.5f, 1.0f};
  const Image image = stage.picture(options);
  EXPECT_NEAR(image.pixel(5, 0)[0], 255, 2);
  EXPECT_NEAR(image.pixel(5, 0)[1], 128, 2);
  EXPECT_NEAR(image.pixel(5, 0)[2], 0, 8);
  EXPECT_NEAR(image.pixel(5, kHeight - 1)[0], 0, 8);
  EXPECT_NEAR(image.pixel(5, kHeight - 1)[2], 255, 2);
}

TEST(Look, LightAddsUpLinearly) {
  // 0.5 in linear light is 188 in sRGB; a square that receives half the light must have this value.
  Stage stage;
  lookDown(stage);
  stage.light = {};
  stage.light.towards = {0.0f, 1.0f, 0.0f};
  stage.light.shadows = false;
  stage.light.sun = {0.0f, 0.0f, 0.0f};
  stage.light.sky = {0.5f, 0.5f, 0.5f};
  stage.add(square(1.0f, 0.0f, true, false), {{1.0f, 1.0f, 1.0f}, {}});
  EXPECT_NEAR(stage.picture().pixel(kMiddleX, kMiddleY)[0], 188, 1);
}

TEST(Look, ImageIsNotMirrored) {
  Stage stage;
  stage.camera.eye = {0.0f, 0.0f, 5.0f};
  stage.camera.target = {};
  stage.light.shadows = false;
  const Scenery box = makeBox({}, {0.2f, 0.2f, 0.2f});
  const ShapeId shape = stage.renderer().addShape(box.shape);
  stage.add(shape, moved(box.points, 1.0f, 0.0f, 0.0f), {{1.0f, 0.0f, 0.0f}, {}});
  stage.add(shape, moved(box.points, 0.0f, 1.0f, 0.0f), {{0.0f, 0.0f, 1.0f}, {}});
  const Image image = stage.picture();
  // One metre is 160 / (2 * 5 * tan(0.35) * 4 / 3) pixels to the right.
  const int metre = static_cast<int>(kHeight / (10.0f * std::tan(0.35f)));
  const std::uint8_t* right = image.pixel(kMiddleX + metre, kMiddleY);
  const std::uint8_t* up = image.pixel(kMiddleX, kMiddleY - metre);
  EXPECT_GT(right[0], right[2] + 60);
  EXPECT_GT(up[2], up[0] + 60);
}

TEST(Look, CounterClockwiseIsOutside) {
  Stage empty;
  lookDown(empty);
  const int background = brightness(empty.picture(), kMiddleX, kMiddleY);
  for (const bool facingUp : {true, false}) {
    for (const bool twoSided : {true, false}) {
      Stage stage;
      lookDown(stage);
      stage.add(square(1.0f, 0.0f, facingUp, twoSided), {{0.5f, 0.1f, 0.1f}, {}});
      const bool visible = std::abs(brightness(stage.picture(), kMiddleX, kMiddleY) - background) > 60;
      EXPECT_EQ(visible, facingUp || twoSided) << facingUp << twoSided;
    }
  }
}

TEST(Look, BothSidesOfClothAreLitAlike) {
  // Seen from above with the sun above, a sheet looks the same for both orders of its corners.
  std::array<Image, 2> images;
  for (const bool facingUp : {true, false}) {
    for (const Shading shading : {Shading::Flat, Shading::Smooth}) {
      Stage stage;
      lookDown(stage);
      Scenery sheet = square(1.0f, 0.0f, facingUp, true);
      sheet.shape.shading = shading;
      stage.add(sheet);
      Image& image = images[facingUp ? 1 : 0];
      if (shading == Shading::Flat) {
        image = stage.picture();
      } else {
        EXPECT_LE(largestDifference(image, stage.picture()), 1);
      }
    }
  }
  EXPECT_LE(largestDifference(images[0], images[1]), 1);
}

TEST(Look, APointInShadowIsDarker) {
  Stage stage;
  lookDown(stage);
  stage.light.towards = {1.0f, 1.0f, 0.0f};
  stage.add(makeFloor({}, 4.0f), {{0.9f, 0.9f, 0.9f}, {}});
  stage.add(makeBox({1.0f, 1.0f, 0.0f}, {0.3f, 0.3f, 0.3f}));
  const Image lit = stage.picture();
  // The box is at (1, 1, 0), so with the light at 45 degrees its shadow is at the origin.
  EXPECT_LT(brightness(lit, kMiddleX, kMiddleY), brightness(lit, kMiddleX - 30, kMiddleY) - 100);
  stage.light.shadows = false;
  const Image unshadowed = stage.picture();
  EXPECT_GT(brightness(unshadowed, kMiddleX, kMiddleY), brightness(lit, kMiddleX, kMiddleY) + 100);
  EXPECT_EQ(brightness(unshadowed, kMiddleX - 30, kMiddleY), brightness(lit, kMiddleX - 30, kMiddleY));
}

// Returns the brightness of a square below the eye, without a ball and inside it or below it.
std::pair<int, int> squareUnder(Scenery ball, const Vec3& eye) {
  std::array<int, 2> seen{};
  for (const bool withBall : {false, true}) {
    Stage stage;
    lookDown(stage);
    stage.camera.eye = eye;
    stage.light.towards = {0.05f, 1.0f, 0.0f};
    stage.add(square(0.3f, 0.0f, true, false));
    if (withBall) {
      stage.add(ball);
    }
    seen[withBall ? 1 : 0] = brightness(stage.picture(), kMiddleX, kMiddleY);
  }
  return {seen[0], seen[1]};
}

TEST(Look, TheNearSideOfAClosedSurfaceCastsItsShadow) {
  // The eye is inside the ball, whose back faces are not drawn.
  const auto [lit, shaded] = squareUnder(makeUvSphere({}, 1.0f), {0.0f, 0.7f, 0.01f});
  EXPECT_LT(shaded, 0.8 * lit);
}

TEST(Look, HiddenBackFacesLeaveAClosedSurfaceAsItIs) {
  Scenery ball = makeUvSphere({0.0f, 0.5f, 0.0f}, 0.5f);
  Scenery sheet = square(1.0f, 0.2f, false, true);
  ball.shape.twoSided = true;
  Stage all, hidden;
  for (Stage* stage : {&all, &hidden}) {
    ball.shape.hideBackFaces = sheet.shape.hideBackFaces = stage == &hidden;
    stage->add(ball);
    stage->add(sheet);  // open: its back, which the eye sees, stays
  }
  EXPECT_EQ(all.picture().rgba, hidden.picture().rgba);
  for (Stage* stage : {&all, &hidden}) {
    stage->camera.eye = {0.0f, 0.6f, 0.1f};  // inside the ball
    stage->camera.target = {0.0f, 0.5f, 0.0f};
  }
  EXPECT_NE(all.picture().rgba, hidden.picture().rgba);
}

TEST(Look, AnInsideOutBodyCastsAShadow) {
  Scenery ball = makeUvSphere({0.0f, 2.0f, 0.0f}, 0.5f);
  for (std::size_t i = 0; i < ball.shape.triangles.size(); i += 3) {
    std::swap(ball.shape.triangles[i], ball.shape.triangles[i + 1]);
  }
  const auto [lit, shaded] = squareUnder(ball, {0.0f, 1.2f, 0.01f});
  EXPECT_LT(shaded, 0.8 * lit);
}

TEST(Look, SlantedSurfacesHaveNoShadowAcne) {
  // A single convex body in grazing light: shadows must not darken surfaces that clearly face the sun.
  Stage stage;
  stage.light.towards = {1.0f, 0.15f, 0.2f};
  stage.add(makeBox({0.0f, 0.5f, 0.0f}, {0.8f, 0.5f, 0.8f}));
  const Image shadowed = stage.picture();
  stage.light.shadows = false;
  EXPECT_LE(largestDifference(shadowed, stage.picture()), 1);
}

TEST(Look, TextureColoursTheSurface) {
  Stage stage;
  lookDown(stage);
  const std::array<std::uint8_t, 16> pixels{255, 0, 0, 255, 255, 0, 0, 255, 0, 0, 255, 255, 0, 0, 255, 255};
  const TextureId texture = stage.renderer().addTexture(2, 2, pixels.data());
  Scenery quad = square(1.0f, 0.0f, true, false);
  quad.shape.uvs = {0.0f, 1.0f, 1.0f, 1.0f, 1.0f, 0.0f, 0.0f, 0.0f};
  stage.add(quad, {{1.0f, 1.0f, 1.0f}, texture});
  const Image image = stage.picture();
  // The first texture row has v = 0, which is at the far edge, at the top of the picture.
  const std::uint8_t* top = image.pixel(kMiddleX, kMiddleY - 7);
  const std::uint8_t* bottom = image.pixel(kMiddleX, kMiddleY + 7);
  EXPECT_GT(top[0], top[2] + 80);
  EXPECT_GT(bottom[2], bottom[0] + 80);
}

TEST(Look, StrainIsBlueGreyRed) {
  ShapeDesc spring;
  spring.pointCount = 2;
  spring.lines = {0, 1};
  spring.lineRestLengths = {1.0f};
  DrawOptions options;
  options.mode = DrawMode::Wireframe;
  options.lineWidth = 5.0f;
  options.strainRange = 0.2f;
  options.legend = false;
  std::array<std::array<std::uint8_t, 3>, 3> colours{};
  for (std::size_t i = 0; i < 3; ++i) {
    Stage stage;
    stage.camera.eye = {0.0f, 0.0f, 5.0f};
    stage.camera.target = {};
    const float half = 0.5f * (0.8f + 0.2f * static_cast<float>(i));
    stage.add(stage.renderer().addShape(spring), {-half, 0.0f, 0.0f, half, 0.0f, 0.0f});
    const Image image = stage.picture(options);
    const std::uint8_t* pixel = image.pixel(kMiddleX, kMiddleY);
    colours[i] = {pixel[0], pixel[1], pixel[2]};
  }
  EXPECT_GT(colours[0][2], colours[0][0] + 80) << "compressed";
  EXPECT_NEAR(colours[1][0], colours[1][2], 6) << "at rest";
  EXPECT_GT(colours[2][0], colours[2][2] + 80) << "stretched";
}

TEST(Look, LinesThroughTheEyeStayInThePicture) {
  ShapeDesc spring;
  spring.pointCount = 2;
  spring.lines = {0, 1};
  DrawOptions options;
  options.mode = DrawMode::Wireframe;
  options.legend = false;
  Stage stage;
  stage.camera.eye = {0.0f, 0.3f, 0.0f};
  stage.camera.target = {0.0f, 0.0f, -5.0f};
  const Image empty = stage.picture(options);
  stage.add(stage.renderer().addShape(spring), {0.0f, 0.0f, 5.0f, 0.0f, 0.0f, -5.0f});
  const Image image = stage.picture(options);
  EXPECT_NE(brightness(image, kMiddleX, kHeight - 5), brightness(empty, kMiddleX, kHeight - 5));
  EXPECT_EQ(brightness(image, kMiddleX, 5), brightness(empty, kMiddleX, 5));
}

}  // namespace
}  // namespace limber::render::test
