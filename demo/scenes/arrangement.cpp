// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"

#include <array>
#include <cmath>

namespace limber::scenes {

Eigen::Quaterniond Random::rotation() {
  constexpr double kTwoPi = 6.283185307179586;
  const double u = unit();
  const double a = kTwoPi * unit();
  const double b = kTwoPi * unit();
  const double r = std::sqrt(1.0 - u);
  const double s = std::sqrt(u);
  return Eigen::Quaterniond(s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b)).normalized();
}

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

DropGridSettings dropGridOf(std::uint32_t count, double size, double radius) {
  return {count, 2.5 * radius, 1.5 * radius, 1.5 * radius + 2.0 * size};
}

std::uint32_t gridColumns(std::uint32_t count) {
  std::uint32_t columns = 1;
  while (std::uint64_t(columns) * columns < count) ++columns;
  return columns;
}

std::vector<Placement> dropGrid(const DropGridSettings& settings, Random& random) {
  const std::uint32_t columns = gridColumns(settings.count);
  const std::uint32_t rows = (settings.count + columns - 1) / columns;
  std::vector<Placement> placements;
  placements.reserve(settings.count);
  for (std::uint32_t i = 0; i < settings.count; ++i) {
    const double column = double(i % columns) - 0.5 * double(columns - 1);
    const double row = double(i / columns) - 0.5 * double(rows - 1);
    const double height = random.between(settings.lowest, settings.highest);
    const Eigen::Vector3d centre(column * settings.spacing, height, row * settings.spacing);
    placements.push_back({centre, random.rotation()});
  }
  return placements;
}

}  // namespace limber::scenes
