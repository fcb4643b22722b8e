// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/random.h"

#include <Eigen/Core>

#include <cstddef>

namespace limber::scenes {

/// The i-th of a few colours that go well together, sRGB, 0 to 1; repeats.
Eigen::Vector3f paletteColour(std::size_t i);

/// The same, a little lighter or darker.
Eigen::Vector3f variedColour(std::size_t i, Random& random);

}  // namespace limber::scenes
