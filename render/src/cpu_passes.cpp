// SPDX-License-Identifier: Zlib
// Computes skins, normals and side vectors of tubes on the CPU.

#include "cpu_passes.h"

#include "mat4.h"
#include "shape_layout.h"

#include <algorithm>
#include <cmath>

namespace limber::render {

// --- normals and side vectors ------------------------------------------------------------------------------

namespace {

constexpr Vec3 kUp{0.0f, 1.0f, 0.0f};

Vec3 pointAt(const float* points, std::size_t index) {
  const float* p = points + 3 * index;
  return {p[0], p[1], p[2]};
}

void write(Vec3 v, float* to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

void addTo(Vec3& sum, Vec3 v) { sum = sum + v; }

void sumCrossProducts(const CpuTriangles& mesh, const float* points, Vec3* sums) {
  std::fill_n(sums, mesh.normalCount, Vec3{});
  const std::vector<std::uint32_t>& normals = mesh.normalsOf.empty() ? mesh.corners : mesh.normalsOf;
  for (std::size_t t = 0; t < mesh.corners.size(); t += 3) {
    const std::uint32_t* corner = mesh.corners.data() + t;
    const std::uint32_t* own = normals.data() + t;
    const Vec3 a = pointAt(points, corner[0]);
    const Vec3 normal = cross(pointAt(points, corner[1]) - a, pointAt(points, corner[2]) - a);
    addTo(sums[own[0]], normal);
    addTo(sums[own[1]], normal);
    addTo(sums[own[2]], normal);
  }
}

void writeUnit(const Vec3* sums, std::size_t count, float* normals) {
  for (std::size_t i = 0; i < count; ++i) {
    const float lengthSquared = dot(sums[i], sums[i]);
    write(lengthSquared > 0.0f ? (1.0f / std::sqrt(lengthSquared)) * sums[i] : kUp, normals + 3 * i);
  }
}

/// Returns the axis most nearly perpendicular to the tangent, made perpendicular.
Vec3 acrossFrom(Vec3 tangent) {
  const Vec3 size{std::abs(tangent.x), std::abs(tangent.y), std::abs(tangent.z)};
  const bool isX = size.x <= size.y && size.x <= size.z;
  const Vec3 axis = isX ? Vec3{1.0f, 0.0f, 0.0f} : size.y <= size.z ? kUp : Vec3{0.0f, 0.0f, 1.0f};
  return unitOr(axis - dot(axis, tangent) * tangent, axis);
}

void tubeFrames(const float* points, std::size_t count, float* sides) {
  Vec3 tangent = unitOr(pointAt(points, 1) - pointAt(points, 0), kUp);
  Vec3 side = acrossFrom(tangent);
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 before = pointAt(points, k == 0 ? 0 : k - 1);
    const Vec3 after = pointAt(points, std::min(k + 1, count - 1));
    tangent = unitOr(after - before, tangent);
    side = unitOr(side - dot(side, tangent) * tangent, acrossFrom(tangent));
    write(side, sides + 3 * k);
  }
}

}  // namespace

void computeMeshNormals(const CpuTriangles& mesh, const CpuInstances& instances, std::vector<Vec3>& sums,
                        RowThreads& threads) {
  constexpr std::size_t kOperationsPerCorner = 10;
  sums.resize(std::size_t{threads.threads()} * mesh.normalCount);
  const auto compute = [&](RowRange range, unsigned part) {
    Vec3* own = sums.data() + std::size_t{part} * mesh.normalCount;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      sumCrossProducts(mesh, instances.in + 3 * i * mesh.pointCount, own);
      writeUnit(own, mesh.normalCount, instances.out + 3 * i * mesh.normalCount);
    }
  };
  threads.run(instances.count, kOperationsPerCorner * mesh.corners.size(), compute);
}

void computeTubeFrames(std::uint32_t pointCount, const CpuInstances& instances) {
  for (std::size_t i = 0; i < instances.count; ++i) {
    const std::size_t first = 3 * i * pointCount;
    tubeFrames(instances.in + first, pointCount, instances.out + first);
  }
}

// --- skins -------------------------------------------------------------------------------------------------

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

void applySkin(const CpuSkin& skin, const CpuInstances& instances, std::vector<Lanes>& lanes,
               RowThreads& threads) {
  padPoints(instances.in, instances.count * skin.pointCount, lanes);
  const auto computeBlocks = [&](RowRange blocks, unsigned) {
    for (std::size_t block = blocks.begin; block < blocks.end; ++block) {
      for (std::size_t i = 0; i < instances.count; ++i) {
        const Lanes* points = lanes.data() + i * skin.pointCount;
        float* places = instances.out + 3 * (i * skin.placeCount + block * kRows);
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
