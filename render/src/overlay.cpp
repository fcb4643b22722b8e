// SPDX-License-Identifier: Zlib
#include "limber/render/overlay.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mat4.h"
#include "srgb.h"

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
  for (const Vec3 arm : {Vec3{size, 0.0f, 0.0f}, Vec3{0.0f, size, 0.0f}, Vec3{0.0f, 0.0f, size}}) {
    overlay.push_back({at - arm, at + arm, colour, width});
  }
}

// In Oklab (Ottosson 2020, "A perceptual color space for image processing") the lightness rises in equal
// steps from 0.33 to 0.92 while the hue turns at an even chroma.
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

}  // namespace limber::render
