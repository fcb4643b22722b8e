// SPDX-License-Identifier: Zlib
#pragma once

#include <cmath>

namespace limber::render {

/// IEC 61966-2-1, both ways; 0 to 1.
inline float srgbToLinear(float s) {
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}
inline float linearToSrgb(float l) {
  return l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1.0f / 2.4f) - 0.055f;
}

}  // namespace limber::render
