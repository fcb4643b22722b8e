// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace limber::render {

enum class ColourMap {
  Strain,  ///< Blue over grey to red, as springs are drawn in wireframe mode.
  Share    ///< As shareColour().
};

/// A bar of colours at the lower right of the picture with numbers above it. The texts may have digits, + - .
/// % / m s and spaces; anything else is left blank.
struct Legend {
  ColourMap map = ColourMap::Share;
  std::string low, middle, high;
};

/// Of springs that are drawn in full colour at a strain of `range`: per cent.
Legend strainLegend(float range);

}  // namespace limber::render
