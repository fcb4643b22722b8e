// SPDX-License-Identifier: Zlib
#include "cpu_skin.h"

#include "shape_layout.h"

#include <algorithm>

namespace limber::render {
namespace {

constexpr std::size_t kRows = CpuSkin::kRows;
using Column = CpuSkin::Column;

std::size_t blockCount(const CpuSkin& skin) { return (skin.placeCount + kRows - 1) / kRows; }

std::vector<Column> blockedWeights(const Skin& skin, std::uint32_t pointCount, std::size_t blocks) {
  std::vector<Column> matrix(blocks * pointCount, Column{});
  for (std::size_t place = 0; place < skin.skinnedPointCount(); ++place) {
    const std::size_t row = place % kRows;
    Column* block = matrix.data() + place / kRows * pointCount;
    for (std::size_t k = skin.first[place]; k < skin.first[place + 1]; ++k) {
      block[skin.points[k]][row / 4][row % 4] += skin.weights[k];
    }
  }
  return matrix;
}

/// The three coordinates of kRows places.
struct BlockSums {
  Column x{}, y{}, z{};
};

// The loops over a column are unrolled: its twelve sums stay in registers.
BlockSums sumDense(const Column* weights, const Lanes* points, std::size_t pointCount) {
  BlockSums sums;
  for (std::size_t k = 0; k < pointCount; ++k) {
    const float x = points[k][0], y = points[k][1], z = points[k][2];
    for (std::size_t i = 0; i < kRows / 4; ++i) {
      sums.x[i] += x * weights[k][i];
      sums.y[i] += y * weights[k][i];
      sums.z[i] += z * weights[k][i];
    }
  }
  return sums;
}

void denseBlock(const CpuSkin& skin, std::size_t block, const Lanes* points, float* places) {
  const BlockSums sums = sumDense(skin.dense.data() + block * skin.pointCount, points, skin.pointCount);
  const std::size_t rows = std::min<std::size_t>(kRows, skin.placeCount - block * kRows);
  for (std::size_t row = 0; row < rows; ++row) {
    places[3 * row] = sums.x[row / 4][row % 4];
    places[3 * row + 1] = sums.y[row / 4][row % 4];
    places[3 * row + 2] = sums.z[row / 4][row % 4];
  }
}

void sparseBlock(const Skin& skin, std::size_t block, const Lanes* points, float* places) {
  const std::size_t first = block * kRows, end = std::min(first + kRows, skin.skinnedPointCount());
  for (std::size_t place = first; place < end; ++place) {
    Lanes sum{};
    for (std::size_t k = skin.first[place]; k < skin.first[place + 1]; ++k) {
      sum += skin.weights[k] * points[skin.points[k]];
    }
    *places++ = sum[0];
    *places++ = sum[1];
    *places++ = sum[2];
  }
}

void padPoints(const float* points, std::size_t count, std::vector<Lanes>& lanes) {
  lanes.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    lanes[i] = Lanes{points[3 * i], points[3 * i + 1], points[3 * i + 2], 0.0f};
  }
}

}  // namespace

std::size_t CpuSkin::operationsPerBlock() const {
  const std::size_t weights = dense.empty() ? sparse.weights.size() / blockCount(*this) : kRows * pointCount;
  return 3 * weights;
}

CpuSkin makeCpuSkin(const Skin& skin, std::uint32_t pointCount) {
  CpuSkin made;
  made.pointCount = pointCount;
  made.placeCount = static_cast<std::uint32_t>(skin.skinnedPointCount());
  if (isDense(skin, pointCount)) {
    made.dense = blockedWeights(skin, pointCount, blockCount(made));
  } else {
    made.sparse = skin;
  }
  return made;
}

void applySkin(const CpuSkin& skin, const SkinnedInstances& instances, std::vector<Lanes>& lanes,
               RowThreads& threads) {
  padPoints(instances.points, instances.count * skin.pointCount, lanes);
  const auto computeBlocks = [&](RowRange blocks, unsigned) {
    for (std::size_t block = blocks.begin; block < blocks.end; ++block) {
      for (std::size_t i = 0; i < instances.count; ++i) {
        const Lanes* points = lanes.data() + i * skin.pointCount;
        float* places = instances.places + 3 * (i * skin.placeCount + block * kRows);
        if (skin.dense.empty()) {
          sparseBlock(skin.sparse, block, points, places);
        } else {
          denseBlock(skin, block, points, places);
        }
      }
    }
  };
  threads.run(blockCount(skin), instances.count * skin.operationsPerBlock(), computeBlocks);
}

}  // namespace limber::render
