// SPDX-License-Identifier: Zlib
#include "limber/render/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "limber/render/light.h"
#include "mat4.h"

namespace limber::render {
namespace {

// Bounds of a box in the picture, in normalised device coordinates.
struct Shown {
  float lowX = 2.0f, highX = -2.0f, lowY = 2.0f, highY = -2.0f;
  float largest() const { return std::max({-lowX, highX, -lowY, highY}); }
};

Shown shownOf(const Camera& camera, Vec3 min, Vec3 max, float aspect) {
  const Mat4 matrix = perspective(camera.verticalFieldOfView, aspect, camera.nearPlane, camera.farPlane) *
                      lookAlong(camera.eye, unitOr(camera.target - camera.eye, {}), camera.up);
  Shown shown;
  for (int i = 0; i < 8; ++i) {
    const std::array<float, 4> p{(i & 1) != 0 ? max.x : min.x, (i & 2) != 0 ? max.y : min.y,
                                 (i & 4) != 0 ? max.z : min.z, 1.0f};
    std::array<float, 4> clip{};
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t k = 0; k < 4; ++k) {
        clip[row] += matrix.at(row, k) * p[k];
      }
    }
    EXPECT_GT(clip[3], 0.0f);
    EXPECT_GE(clip[2], 0.0f) << "cut by the near plane";
    EXPECT_LE(clip[2], clip[3]) << "cut by the far plane";
    shown.lowX = std::min(shown.lowX, clip[0] / clip[3]);
    shown.highX = std::max(shown.highX, clip[0] / clip[3]);
    shown.lowY = std::min(shown.lowY, clip[1] / clip[3]);
    shown.highY = std::max(shown.highY, clip[1] / clip[3]);
  }
  return shown;
}

TEST(Camera, FrameBoxFillsThePictureWithEqualRoomOnOppositeSides) {
  const Vec3 min{-3.0f, 0.5f, -1.0f};
  const Vec3 max{5.0f, 1.5f, 2.0f};
  for (const Vec3 direction :
       {Vec3{0.0f, 0.0f, 1.0f}, Vec3{1.0f, 0.7f, 0.3f}, Vec3{0.0f, 1.0f, 0.0f}, Vec3{0.0f, -3.0f, 0.0f}}) {
    for (const float aspect : {0.5f, 1.0f, 1.78f}) {
      const Shown shown = shownOf(frameBox(min, max, direction, aspect), min, max, aspect);
      EXPECT_LE(shown.largest(), 1.0f);
      EXPECT_GE(shown.largest(), 0.9f);
      EXPECT_NEAR(-shown.lowX, shown.highX, 1e-3f);
      EXPECT_NEAR(-shown.lowY, shown.highY, 1e-3f);
    }
  }
}

TEST(Camera, AnOrbitSeesAllOfTheBoxFromEverySideAtOneDistance) {
  const Vec3 low{-1.0f, 0.0f, -3.0f}, high{2.0f, 1.0f, 1.0f};
  const Camera first = orbitBox(low, high, {1.0f, 0.5f, 0.2f}, 1.7f, 0.0f);
  const float distance = length(first.eye - 0.5f * (low + high));
  for (int i = 0; i < 12; ++i) {
    const Camera camera = orbitBox(low, high, {1.0f, 0.5f, 0.2f}, 1.7f, 0.5236f * static_cast<float>(i));
    EXPECT_LE(shownOf(camera, low, high, 1.7f).largest(), 1.0f) << i;
    EXPECT_NEAR(length(camera.eye - 0.5f * (low + high)), distance, 1e-4f);
  }
}

TEST(Camera, FrameBoxOfAPointIsStillAView) {
  const Camera camera = frameBox({1.0f, 1.0f, 1.0f}, {1.0f, 1.0f, 1.0f}, {0.0f, 0.0f, 1.0f}, 1.0f);
  EXPECT_GT(camera.eye.z, 1.0f);
  EXPECT_GT(camera.nearPlane, 0.0f);
  EXPECT_GT(camera.farPlane, camera.nearPlane);
}

TEST(LightBox, CoversTheCorners) {
  const Light light = lightBox({-1.0f, 0.0f, -2.0f}, {3.0f, 4.0f, 2.0f});
  EXPECT_FLOAT_EQ(light.shadowCentre.y, 2.0f);
  EXPECT_GE(light.shadowRadius, std::sqrt(12.0f));
}

}  // namespace
}  // namespace limber::render
