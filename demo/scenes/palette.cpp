// SPDX-License-Identifier: Zlib
#include "scenes/palette.h"

#include <array>

namespace limber::scenes {

Eigen::Vector3f paletteColour(std::size_t i) {
  static const std::array<Eigen::Vector3f, 8> kColours = {{
      {0.91f, 0.38f, 0.30f},  // coral
      {0.16f, 0.62f, 0.60f},  // teal
      {0.96f, 0.72f, 0.24f},  // amber
      {0.24f, 0.42f, 0.66f},  // blue
      {0.93f, 0.56f, 0.32f},  // orange
      {0.50f, 0.70f, 0.36f},  // leaf
      {0.56f, 0.42f, 0.70f},  // violet
      {0.88f, 0.52f, 0.62f},  // rose
  }};
  return kColours[i % kColours.size()];
}

Eigen::Vector3f variedColour(std::size_t i, Random& random) {
  const float factor = static_cast<float>(random.between(0.90, 1.08));
  return (paletteColour(i) * factor).cwiseMin(1.0f);
}

}  // namespace limber::scenes
