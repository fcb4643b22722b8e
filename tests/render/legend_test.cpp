// SPDX-License-Identifier: Zlib
#include "limber/render/legend.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "limber/render/text.h"
#include "overlay_lines.h"
#include "test_scene.h"

namespace limber::render::test {
namespace {

RendererDesc largeDesc() {
  RendererDesc desc = smallDesc();
  desc.width = 640;
  desc.height = 360;
  return desc;
}

int darkPixels(const Image& image, int x0, int y0, int x1, int y1) {
  int count = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      count += brightness(image, x, y) < 200;
    }
  }
  return count;
}

TEST(Legend, HasTheColoursOfTheMapFromEndToEnd) {
  Stage stage(Backend::Auto, largeDesc());
  DrawOptions options;
  options.legends = {{ColourMap::Share, "0", "", "5 m/s"}};
  const Image image = stage.picture(options);
  const BarRectangle bar = barRectangle(0, 640, 360);
  const int y = static_cast<int>(bar.top + 0.3f * bar.height);
  for (const float fraction : {0.02f, 0.33f, 0.6f, 0.98f}) {
    const float x = std::floor(bar.left + fraction * bar.width);
    const Vec3 colour = shareColour((x + 0.5f - bar.left) / bar.width);
    const std::uint8_t* pixel = image.pixel(static_cast<int>(x), y);
    EXPECT_NEAR(pixel[0], 255.0f * colour.x, 2.0f) << fraction;
    EXPECT_NEAR(pixel[1], 255.0f * colour.y, 2.0f) << fraction;
    EXPECT_NEAR(pixel[2], 255.0f * colour.z, 2.0f) << fraction;
  }
}

TEST(Legend, NumbersStandAboveItsEnds) {
  Stage stage(Backend::Auto, largeDesc());
  DrawOptions options;
  options.legends = {{ColourMap::Share, "1", "", ""}};
  const BarRectangle bar = barRectangle(0, 640, 360);
  const int left = static_cast<int>(bar.left), right = static_cast<int>(bar.left + bar.width);
  const int top = static_cast<int>(bar.top);
  const Image low = stage.picture(options);
  EXPECT_GT(darkPixels(low, left - 2, top - 14, left + 12, top), 3);
  EXPECT_EQ(darkPixels(low, right - 12, top - 14, right + 2, top), 0);
  options.legends = {{ColourMap::Share, "", "", "1"}};
  const Image high = stage.picture(options);
  EXPECT_EQ(darkPixels(high, left - 2, top - 14, left + 12, top), 0);
  EXPECT_GT(darkPixels(high, right - 12, top - 14, right + 2, top), 3);
}

TEST(Legend, SeveralStandOneAboveTheOther) {
  const BarRectangle first = barRectangle(0, 640, 360), second = barRectangle(1, 640, 360);
  EXPECT_LT(second.top + second.height, first.top - 10.0f) << "with room for numbers";
  EXPECT_EQ(first.left, second.left);
}

TEST(Legend, StrainIsInPerCent) {
  const Legend legend = strainLegend(0.03f);
  EXPECT_EQ(legend.low, "-3%");
  EXPECT_EQ(legend.high, "+3%");
  EXPECT_EQ(strainLegend(0.005f).high, "+0.5%");
}

TEST(Text, EveryCharacterIsDrawnWithinItsPlace) {
  for (const char c : std::string("0123456789-+.%/msAZ")) {
    Overlay strokes;
    addText(strokes, std::string(1, c), 10.0f, 20.0f, 12.0f, {}, 0.0f);
    EXPECT_FALSE(strokes.empty()) << c;
    for (const OverlayLine& line : strokes) {
      for (const Vec3 end : {line.from, line.to}) {
        EXPECT_GE(end.x, 10.0f) << c;
        EXPECT_LE(end.x, 10.0f + textWidth(std::string(1, c)) * 12.0f / kTextHeight + 1e-4f) << c;
        EXPECT_GE(end.y, 20.0f) << c;
        EXPECT_LE(end.y, 32.001f) << c;
      }
    }
  }
}

TEST(Text, NoTwoCharactersLookAlike) {
  const std::string all = "0123456789-+.%/abcdefghijkmnopqrstuvwxyzABCDEFGHJKLMNPQRTUVWXYZ";
  const auto strokesOf = [](char c) {
    Overlay strokes;
    addText(strokes, std::string(1, c), 0.0f, 0.0f, 6.0f, {}, 1.0f);
    std::string text;
    for (const OverlayLine& line : strokes) {
      for (const float x : {line.from.x, line.from.y, line.to.x, line.to.y}) {
        text += std::to_string(x) + " ";
      }
    }
    return text;
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_NE(strokesOf(all[i]), strokesOf(all[k])) << all[i] << " " << all[k];
    }
  }
}

TEST(Text, TheUnknownIsBlank) {
  Overlay strokes;
  addText(strokes, "\n\xc3\x7f", 0.0f, 0.0f, 6.0f, {}, 1.0f);
  EXPECT_TRUE(strokes.empty());
}

}  // namespace
}  // namespace limber::render::test
