// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/shape_desc.h"
#include "row_threads.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber::render {

/// Four floats in one register of the processor.
using Lanes = float __attribute__((vector_size(16)));

/// The weights of a skin for the CPU. Dense: the matrix in blocks of kRows places; a block holds the weights
/// of point 0 on its places, then those of point 1, and so on. Sparse: as in Skin.
struct CpuSkin {
  static constexpr std::size_t kRows = 16;
  using Column = std::array<Lanes, kRows / 4>;

  std::uint32_t pointCount = 0;
  std::uint32_t placeCount = 0;  ///< 0: no skin.
  std::vector<Column> dense;     ///< #blocks x #points; the last block is filled up with zeros.
  Skin sparse;                   ///< Empty if `dense` is not.

  /// Multiplications for one instance and kRows places.
  std::size_t operationsPerBlock() const;
};

CpuSkin makeCpuSkin(const Skin& skin, std::uint32_t pointCount);

/// Instances of one shape; their points and places are contiguous.
struct SkinnedInstances {
  std::size_t count = 0;
  const float* points = nullptr;  ///< count x #points x 3.
  float* places = nullptr;        ///< count x #places x 3; written, never read.
};

/// Computes the places of all instances in one pass over the weights, so that a large matrix is read from
/// memory once and not once for each instance. `lanes` is scratch memory.
void applySkin(const CpuSkin& skin, const SkinnedInstances& instances, std::vector<Lanes>& lanes,
               RowThreads& threads);

}  // namespace limber::render
