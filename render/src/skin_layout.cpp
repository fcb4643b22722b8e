// SPDX-License-Identifier: Zlib
#include "skin_layout.h"

#include <cstddef>
#include <cstring>

namespace limber::render {

bool isDense(const Skin& skin, std::uint32_t pointCount) {
  return 2 * skin.weights.size() >= skin.placeCount() * pointCount;
}

std::vector<float> denseWeights(const Skin& skin, std::uint32_t pointCount) {
  const std::size_t places = skin.placeCount();
  std::vector<float> matrix(places * pointCount, 0.0f);
  for (std::size_t p = 0; p < places; ++p) {
    for (std::size_t k = skin.first[p]; k < skin.first[p + 1]; ++k) {
      matrix[skin.points[k] * places + p] += skin.weights[k];
    }
  }
  return matrix;
}

std::vector<std::uint32_t> sparseWeights(const Skin& skin) {
  std::vector<std::uint32_t> pairs;
  pairs.reserve(2 * skin.weights.size());
  for (std::size_t k = 0; k < skin.weights.size(); ++k) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &skin.weights[k], sizeof bits);
    pairs.insert(pairs.end(), {skin.points[k], bits});
  }
  return pairs;
}

}  // namespace limber::render
