// SPDX-License-Identifier: Zlib
#include "legend_layout.h"

#include <algorithm>

#include "stroke_text.h"

namespace limber::render {
namespace {

// Of the picture's height, with the least pixels at which a digit can be read.
constexpr float kTextShare = 0.022f, kMinText = 7.0f;
constexpr float kBarShare = 0.018f, kMinBar = 6.0f;
constexpr float kMarginShare = 0.03f;
constexpr float kBarWidthShare = 0.22f;  // of its width

constexpr Vec3 kRim{0.97f, 0.97f, 0.97f}, kInk{0.1f, 0.1f, 0.12f};

float textHeight(const BarPlace& bar) { return std::max(bar.height * kTextShare / kBarShare, kMinText); }

}  // namespace

BarPlace barPlace(std::size_t row, int pictureWidth, int pictureHeight) {
  const auto width = static_cast<float>(pictureWidth);
  const auto height = static_cast<float>(pictureHeight);
  BarPlace bar{0.0f, 0.0f, kBarWidthShare * width, std::max(kMinBar, kBarShare * height)};
  const float margin = kMarginShare * height;
  const float rowHeight = bar.height + 2.5f * textHeight(bar);
  bar.left = width - margin - bar.width;
  bar.top = height - margin - bar.height - rowHeight * static_cast<float>(row);
  return bar;
}

void addNumbers(Overlay& strokes, const Legend& legend, const BarPlace& bar) {
  const float size = textHeight(bar);
  const float y = bar.top - 1.5f * size;
  const auto write = [&](const std::string& text, float anchor) {
    const float x = bar.left + anchor * (bar.width - textWidth(text, size));
    addText(strokes, text, x, y, size, kRim, 0.45f * size);
    addText(strokes, text, x, y, size, kInk, 0.13f * size);
  };
  write(legend.low, 0.0f);
  write(legend.middle, 0.5f);
  write(legend.high, 1.0f);
}

}  // namespace limber::render
