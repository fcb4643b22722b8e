// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/image.h"
#include "pixel_area.h"

namespace limber::render {

/// Fills an area of `target` with the whole of `source`: each pixel is the mean of those under it, in
/// linear light, or the nearest where there is none. Opaque.
void drawScaled(const Image& source, Image& target, const PixelArea& area);

}  // namespace limber::render
