// SPDX-License-Identifier: Zlib
#include "limber/render/legend.h"

#include <array>
#include <cstdio>

namespace limber::render {

Legend strainLegend(float range) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g%%", 100.0 * double{range});
  return {ColourMap::Strain, std::string("-") + text.data(), "0", std::string("+") + text.data()};
}

}  // namespace limber::render
