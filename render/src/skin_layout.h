// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <vector>

#include "limber/render/shape_desc.h"

namespace limber::render {

/// Whether a full matrix takes less memory: 4 bytes for each place and point against 8 for each weight.
bool isDense(const Skin& skin, std::uint32_t pointCount);

/// #points x #places: the weight of point k on place p at k * #places + p.
std::vector<float> denseWeights(const Skin& skin, std::uint32_t pointCount);

/// 2 x #weights: point and the weight's bits, in the order of the skin.
std::vector<std::uint32_t> sparseWeights(const Skin& skin);

}  // namespace limber::render
