// SPDX-License-Identifier: Zlib
#include "limber/render/overlay.h"

#include <cmath>
#include <cstdint>

#include "test_scene.h"

namespace limber::render::test {
namespace {

// Looks along -z from 5 m.
void lookAhead(Stage& stage) {
  stage.camera.eye = {0.0f, 0.0f, 5.0f};
  stage.camera.target = {};
  stage.light.shadows = false;
}

Image pictureWith(Stage& stage, const Overlay& overlay, const DrawOptions& options = {}) {
  stage.overlay = overlay;
  return stage.picture(options);
}

OverlayLine horizontalLine(float z, Vec3 colour) { return {{-3.0f, 0.0f, z}, {3.0f, 0.0f, z}, colour, 4.0f}; }

TEST(Overlay, LinesHaveTheirOwnColourAndWidth) {
  Stage stage;
  lookAhead(stage);
  const Image image = pictureWith(stage, {horizontalLine(0.0f, {1.0f, 0.5f, 0.0f})});
  const std::uint8_t* pixel = image.pixel(kMiddleX, kMiddleY);
  EXPECT_NEAR(pixel[0], 255, 1);
  EXPECT_NEAR(pixel[1], 128, 1);
  EXPECT_NEAR(pixel[2], 0, 1);
  EXPECT_EQ(pixel[3], 255);
  int rows = 0;
  for (int y = 0; y < kHeight; ++y) {
    rows += image.pixel(kMiddleX, y)[2] < 100;
  }
  EXPECT_EQ(rows, 4);
}

TEST(Overlay, WhatIsHiddenIsFaint) {
  Stage stage;
  lookAhead(stage);
  stage.add(makeBox({}, {0.5f, 0.5f, 0.5f}), {{1.0f, 1.0f, 1.0f}, {}});
  const Image box = stage.picture();
  const Image before = pictureWith(stage, {horizontalLine(1.0f, {1.0f, 0.0f, 0.0f})});
  const Image behind = pictureWith(stage, {horizontalLine(-1.0f, {1.0f, 0.0f, 0.0f})});
  DrawOptions visibleOnly;
  visibleOnly.hiddenOverlay = 0.0f;
  const Image hidden = pictureWith(stage, {horizontalLine(-1.0f, {1.0f, 0.0f, 0.0f})}, visibleOnly);
  const int white = box.pixel(kMiddleX, kMiddleY)[1];
  EXPECT_EQ(before.pixel(kMiddleX, kMiddleY)[1], 0);
  EXPECT_GT(behind.pixel(kMiddleX, kMiddleY)[1], white / 2);
  EXPECT_LT(behind.pixel(kMiddleX, kMiddleY)[1], white - 10);
  EXPECT_EQ(hidden.pixel(kMiddleX, kMiddleY)[1], white);
  EXPECT_EQ(hidden.pixel(5, kMiddleY)[1], 0) << "beside the box nothing hides it";
}

TEST(Overlay, LiesOnTopOfTheSurfaceItTouches) {
  Stage stage;
  lookAhead(stage);
  stage.add(makeBox({}, {0.5f, 0.5f, 0.5f}));
  const Image image = pictureWith(stage, {horizontalLine(0.5f, {0.0f, 0.0f, 1.0f})});
  for (int x = kMiddleX - 10; x <= kMiddleX + 10; ++x) {
    EXPECT_EQ(image.pixel(x, kMiddleY)[0], 0) << x;
  }
}

TEST(Overlay, ChangesNothingOnceItIsGone) {
  Stage stage;
  populate(stage);
  const Image reference = stage.picture();
  Overlay arrows;
  addArrow(arrows, {}, {1.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, stage.camera.eye);
  addCross(arrows, {0.5f, 0.5f, 0.5f}, 0.1f, {0.0f, 0.0f, 1.0f});
  EXPECT_EQ(arrows.size(), 6u);
  EXPECT_NE(pictureWith(stage, arrows).rgba, reference.rgba);
  EXPECT_EQ(pictureWith(stage, {}).rgba, reference.rgba);
}

TEST(ShareColour, RisesInLightnessFromEndToEnd) {
  const auto luminance = [](Vec3 c) {
    const auto linear = [](float s) { return std::pow(s, 2.2f); };
    return 0.2126f * linear(c.x) + 0.7152f * linear(c.y) + 0.0722f * linear(c.z);
  };
  for (int i = 0; i < 20; ++i) {
    EXPECT_LT(luminance(shareColour(0.05f * static_cast<float>(i))),
              luminance(shareColour(0.05f * static_cast<float>(i + 1))));
  }
  EXPECT_EQ(luminance(shareColour(-1.0f)), luminance(shareColour(0.0f)));
  EXPECT_EQ(luminance(shareColour(7.0f)), luminance(shareColour(1.0f)));
}

}  // namespace
}  // namespace limber::render::test
