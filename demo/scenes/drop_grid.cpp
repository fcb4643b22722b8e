// SPDX-License-Identifier: Zlib
#include "scenes/drop_grid.h"

namespace limber::scenes {

std::uint32_t gridColumns(std::uint32_t count) {
  std::uint32_t columns = 1;
  while (std::uint64_t(columns) * columns < count) ++columns;
  return columns;
}

std::vector<Placement> dropGrid(const DropGridSettings& settings, Random& random) {
  const std::uint32_t columns = gridColumns(settings.count);
  const std::uint32_t rows = (settings.count + columns - 1) / columns;
  std::vector<Placement> places;
  places.reserve(settings.count);
  for (std::uint32_t i = 0; i < settings.count; ++i) {
    const double column = double(i % columns) - 0.5 * double(columns - 1);
    const double row = double(i / columns) - 0.5 * double(rows - 1);
    const double height = random.between(settings.lowest, settings.highest);
    const Eigen::Vector3d centre(column * settings.spacing, height, row * settings.spacing);
    places.push_back({centre, random.rotation()});
  }
  return places;
}

}  // namespace limber::scenes
