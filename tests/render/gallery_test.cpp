// SPDX-License-Identifier: Zlib
// The gallery's look, tested by what light does.
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "test_scene.h"

namespace limber::render::test {
namespace {

RendererDesc galleryDesc() {
  RendererDesc desc = smallDesc();
  desc.quality = Quality::Gallery;
  return desc;
}

Scenery plate(float height, float halfSize) {
  return makeBox({0.0f, height, 0.0f}, {halfSize, 0.01f * halfSize, halfSize});
}

// Returns the width (m) over which the light of a row of pixels rises from a quarter to three quarters, below
// the edge of a plate at this height.
double edgeOfShadow(float height) {
  RendererDesc desc = galleryDesc();
  desc.width = 640, desc.height = 480;  // an edge of a few centimetres is several pixels wide
  Stage stage(Backend::Auto, desc);
  // from below the plate
  stage.camera.eye = {0.5f, 0.8f * height, 3.0f};
  stage.camera.target = {0.5f, 0.0f, 0.0f};
  stage.light.towards = {0.0f, 1.0f, 0.0f};
  stage.light.sky = stage.light.ground = {0.0f, 0.0f, 0.0f};
  stage.light.shadowRadius = 2.0f;
  stage.add(plate(-0.03f, 3.0f), {{0.4f, 0.4f, 0.4f}, {}, {1.0f, 0.0f, 0.0f, 0.0f}});
  Scenery roof = makeBox({-0.5f, height, 0.0f}, {1.0f, 0.01f, 1.0f});  // its edge is at 0.5
  stage.add(roof);
  const Image image = stage.picture();
  std::vector<double> row;
  for (int x = 0; x < image.width; ++x) {
    row.push_back(std::pow(image.pixel(x, image.height / 2)[1] / 255.0, 2.2));
  }
  const double dark = row[5], lit = row[row.size() - 5];
  int count = 0;
  for (const double value : row) {
    const double share = (value - dark) / (lit - dark);
    count += share > 0.25 && share < 0.75 ? 1 : 0;
  }
  const double metresPerPixel = 2.0 * std::tan(0.35) * std::hypot(3.0, 0.8 * height) / image.height;
  return count * metresPerPixel;
}

// The sun is a disk of tangent 0.07. A quarter of it is hidden 0.404 radii from its middle.
TEST(Gallery, TheEdgeOfAShadowIsAsWideAsTheSunMakesIt) {
  const double low = edgeOfShadow(0.6f), high = edgeOfShadow(1.2f);
  for (const auto& [height, width] : {std::pair(0.6, low), std::pair(1.2, high)}) {
    const double expected = 2.0 * 0.404 * 0.07 * height;
    EXPECT_NEAR(width, expected, 0.2 * expected + 0.005) << height << ", a pixel is 0.5 cm wide";
  }
  EXPECT_GT(high, 1.5 * low);
  EXPECT_LT(edgeOfShadow(0.05f), 0.04);
}

TEST(Gallery, ACornerReceivesLessOfTheSky) {
  Stage stage(Backend::Auto, galleryDesc());
  stage.camera.eye = {0.0f, 1.5f, 3.0f};
  stage.camera.target = {0.0f, 0.3f, 0.0f};
  stage.light.shadows = false;
  stage.light.sun = {};
  stage.light.shadowRadius = 2.0f;
  stage.add(plate(-0.03f, 3.0f), {{0.6f, 0.6f, 0.6f}, {}, {1.0f, 0.0f, 0.0f, 0.0f}});
  const Image open = stage.picture();
  stage.add(makeBox({0.0f, 0.5f, -0.5f}, {3.0f, 0.5f, 0.4f}));  // a wall whose foot is at z = -0.1
  const Image cornered = stage.picture();
  // the rows of places on the floor at z = 0 and z = 0.9
  const int near = 74, far = 104;
  EXPECT_LT(brightness(cornered, kMiddleX, near), 0.93 * brightness(open, kMiddleX, near));
  EXPECT_NEAR(brightness(cornered, kMiddleX, far), brightness(open, kMiddleX, far), 6);
}

// Returns the red of the side that faces away from the sun.
int shadedSideOf(float translucency, float depth) {
  Stage stage(Backend::Auto, galleryDesc());
  stage.camera.eye = {0.0f, 0.0f, 3.0f};
  stage.camera.target = {};
  stage.light.towards = {0.0f, 0.3f, -1.0f};  // from behind
  stage.light.shadowRadius = 2.0f;
  stage.add(makeBox({}, {0.5f, 0.5f, depth}), {{0.9f, 0.3f, 0.2f}, {}, {0.3f, 0.0f, translucency, 0.0f}});
  return *stage.picture().pixel(kMiddleX, kMiddleY);
}

TEST(Gallery, JellyLetsLightThroughByItsThickness) {
  const int opaque = shadedSideOf(0.0f, 0.1f), thin = shadedSideOf(0.3f, 0.1f),
            thick = shadedSideOf(0.3f, 0.8f);
  EXPECT_GT(thin, opaque + 30);
  EXPECT_GT(thin, thick + 30);
}

TEST(Gallery, WhatIsSmallIsAsLitAsWhatIsLarge) {
  const auto draw = [](float scale) {
    Stage stage(Backend::Auto, galleryDesc());
    stage.camera.eye = {2.0f * scale, 1.5f * scale, 3.0f * scale};
    stage.camera.target = {};
    stage.camera.nearPlane = 0.1f * scale;
    stage.camera.farPlane = 100.0f * scale;
    stage.light.shadowRadius = 2.0f * scale;
    stage.add(plate(-0.53f * scale, 3.0f * scale));
    stage.add(makeBox({}, {0.5f * scale, 0.5f * scale, 0.5f * scale}));
    return stage.picture();
  };
  const Image one = draw(1.0f);
  for (const float scale : {0.01f, 100.0f}) {
    const Image other = draw(scale);
    double sum = 0.0;
    for (std::size_t i = 0; i < one.rgba.size(); ++i) {
      sum += std::abs(double(one.rgba[i]) - double(other.rgba[i]));
    }
    EXPECT_LT(sum / static_cast<double>(one.rgba.size()), 1.0) << scale;
  }
}

}  // namespace
}  // namespace limber::render::test
