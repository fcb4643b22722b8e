// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace limber::render {

enum class ColourMap {
  Strain,  ///< Blue over grey to red, as springs are drawn in wireframe mode.
  Share    ///< The colours of shareColour().
};

/// A bar of colours at the lower right of the picture with numbers above it. The texts may have printable
/// characters of ASCII; others are left blank.
struct Legend {
  ColourMap map = ColourMap::Share;
  std::string low, middle, high;
};

/// Returns the legend, in per cent, of springs that have full colour at a strain of `range`.
Legend strainLegend(float range);

}  // namespace limber::render
