// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

#include "limber/render/legend.h"
#include "limber/render/overlay.h"

namespace limber::render {

/// Pixels from the upper left corner of the picture.
struct BarPlace {
  float left, top, width, height;
};

/// Where legend number `row`, counted from the bottom, has its bar.
BarPlace barPlace(std::size_t row, int pictureWidth, int pictureHeight);

/// Appends the strokes of its numbers: a light rim, then dark on top of it, to be read on any ground.
void addNumbers(Overlay& strokes, const Legend& legend, const BarPlace& bar);

}  // namespace limber::render
