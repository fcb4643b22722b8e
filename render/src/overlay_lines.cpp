// SPDX-License-Identifier: Zlib
// Makes arrows, crosses, legends and texts for the lines over pictures.

#include "overlay_lines.h"

#include "limber/render/legend.h"
#include "limber/render/overlay.h"
#include "limber/render/text.h"
#include "mat4.h"
#include "pixels.h"

#include <stb_easy_font.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

namespace limber::render {

void addArrow(Overlay& overlay, Vec3 from, Vec3 to, Vec3 colour, Vec3 eye, float width) {
  overlay.push_back({from, to, colour, width});
  const Vec3 along = to - from;
  const Vec3 across = unitOr(cross(along, eye - to), {1.0f, 0.0f, 0.0f});
  const float head = 0.2f * length(along);
  const Vec3 neck = to - 0.2f * along;
  for (const float side : {-0.5f, 0.5f}) {
    overlay.push_back({to, neck + (side * head) * across, colour, width});
  }
}

void addCross(Overlay& overlay, Vec3 at, float size, Vec3 colour, float width) {
  for (const Vec3 halfLine : {Vec3{size, 0.0f, 0.0f}, Vec3{0.0f, size, 0.0f}, Vec3{0.0f, 0.0f, size}}) {
    overlay.push_back({at - halfLine, at + halfLine, colour, width});
  }
}

// In Oklab (Ottosson 2020, "A perceptual color space for image processing") the lightness rises linearly from
// 0.33 to 0.92, and the hue changes at constant chroma.
Vec3 shareColour(float share) {
  const float t = std::clamp(share, 0.0f, 1.0f);
  const float lightness = 0.33f + 0.59f * t;
  const float hue = 4.9f - 3.0f * t;
  const float a = 0.13f * std::cos(hue), b = 0.13f * std::sin(hue);
  const std::array<float, 3> root{lightness + 0.3963377774f * a + 0.2158037573f * b,
                                  lightness - 0.1055613458f * a - 0.0638541728f * b,
                                  lightness - 0.0894841775f * a - 1.2914855480f * b};
  const float l = root[0] * root[0] * root[0];
  const float m = root[1] * root[1] * root[1];
  const float s = root[2] * root[2] * root[2];
  const auto encode = [](float linear) { return linearToSrgb(std::clamp(linear, 0.0f, 1.0f)); };
  return {encode(4.0767416621f * l - 3.3077115913f * m + 0.2309699292f * s),
          encode(-1.2684380046f * l + 2.6097574011f * m - 0.3413193965f * s),
          encode(-0.0041960863f * l - 0.7034186147f * m + 1.7076147010f * s)};
}

namespace {

float colourBits(Vec3 colour) {
  const auto byte = [](float share) {
    return static_cast<std::uint32_t>(std::lround(255.0f * std::clamp(share, 0.0f, 1.0f)));
  };
  // The highest byte stays 0: with all bits set the word could be a NaN, and moving it as a float might
  // change it.
  const std::uint32_t word = byte(colour.x) | byte(colour.y) << 8u | byte(colour.z) << 16u;
  float bits = 0.0f;
  std::memcpy(&bits, &word, sizeof bits);
  return bits;
}

}  // namespace

void OverlayLines::upload(const Overlay& overlay) {
  count_ = static_cast<GLsizei>(overlay.size());
  if (overlay.empty()) {
    return;
  }
  staging_.clear();
  for (const OverlayLine& line : overlay) {
    staging_.push_back({line.from.x, line.from.y, line.from.z, colourBits(line.colour), line.to.x, line.to.y,
                        line.to.z, line.width});
  }
  const std::size_t bytes = staging_.size() * sizeof(Packed);
  if (buffer_.bytes() < bytes) {
    buffer_ = makeBuffer(gl_, bytes + bytes / 2, nullptr, GL_DYNAMIC_STORAGE_BIT);
  }
  gl_.NamedBufferSubData(buffer_.name(), 0, static_cast<GLsizeiptr>(bytes), staging_.data());
}

void addText(Overlay& strokes, std::string_view text, float x, float y, float height, Vec3 colour,
             float rim) {
  const float unit = height / kTextHeight;
  for (const TextBar& bar : textBars(text)) {
    const float left = x + unit * bar.left - rim, top = y + unit * bar.top - rim;
    const float width = unit * bar.width + 2.0f * rim, tall = unit * bar.height + 2.0f * rim;
    if (width > tall) {
      const float middle = top + 0.5f * tall;
      strokes.push_back({{left, middle, 0.0f}, {left + width, middle, 0.0f}, colour, tall});
    } else {
      const float middle = left + 0.5f * width;
      strokes.push_back({{middle, top, 0.0f}, {middle, top + tall, 0.0f}, colour, width});
    }
  }
}

Legend strainLegend(float range) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g%%", 100.0 * double{range});
  return {ColourMap::Strain, std::string("-") + text.data(), "0", std::string("+") + text.data()};
}

namespace {

// Fractions of the picture's height, and the smallest readable sizes in pixels.
constexpr float kTextFraction = 0.022f, kMinText = 7.0f;
constexpr float kBarFraction = 0.018f, kMinBar = 6.0f;
constexpr float kMarginFraction = 0.03f;
constexpr float kBarWidthFraction = 0.22f;  // of the picture's width

constexpr Vec3 kRim{0.97f, 0.97f, 0.97f}, kInk{0.1f, 0.1f, 0.12f};

float textHeight(const BarRectangle& bar) {
  return std::max(bar.height * kTextFraction / kBarFraction, kMinText);
}

}  // namespace

BarRectangle barRectangle(std::size_t row, int pictureWidth, int pictureHeight) {
  const auto width = static_cast<float>(pictureWidth);
  const auto height = static_cast<float>(pictureHeight);
  BarRectangle bar{0.0f, 0.0f, kBarWidthFraction * width, std::max(kMinBar, kBarFraction * height)};
  const float margin = kMarginFraction * height;
  const float rowHeight = bar.height + 2.5f * textHeight(bar);
  bar.left = width - margin - bar.width;
  bar.top = height - margin - bar.height - rowHeight * static_cast<float>(row);
  return bar;
}

void addNumbers(Overlay& strokes, const Legend& legend, const BarRectangle& bar) {
  const float size = textHeight(bar);
  const float y = bar.top - 1.5f * size;
  const auto write = [&](const std::string& text, float anchor) {
    const float x = bar.left + anchor * (bar.width - textWidth(text) * size / kTextHeight);
    addText(strokes, text, x, y, size, kRim, 0.15f * size);
    addText(strokes, text, x, y, size, kInk, 0.0f);
  };
  write(legend.low, 0.0f);
  write(legend.middle, 0.5f);
  write(legend.high, 1.0f);
}

// --- texts -------------------------------------------------------------------------------------------------

namespace {

/// A corner of a bar as stb_easy_font.h writes it: four for each bar, clockwise from the upper left one.
struct Corner {
  float x, y, z;
  std::array<std::uint8_t, 4> colour;
};

/// The font has the characters from blank to tilde; it takes no const.
std::string printable(std::string_view text) {
  std::string line(text);
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c < ' ' || c > '~'; }, ' ');
  return line;
}

}  // namespace

std::vector<TextBar> textBars(std::string_view text) {
  constexpr std::size_t kMaxBars = 16;  // of a letter
  std::string line = printable(text);
  std::vector<Corner> corners(4 * kMaxBars * line.size());
  const int count = stb_easy_font_print(0.0f, 0.0f, line.data(), nullptr, corners.data(),
                                        static_cast<int>(corners.size() * sizeof(Corner)));
  std::vector<TextBar> bars;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const Corner &first = corners[4 * i], &opposite = corners[4 * i + 2];
    bars.push_back({first.x, first.y, opposite.x - first.x, opposite.y - first.y});
  }
  return bars;
}

float textWidth(std::string_view text) {
  float width = 0.0f;
  for (const TextBar& bar : textBars(text)) {
    width = std::max(width, bar.left + bar.width);
  }
  return width;
}

}  // namespace limber::render
