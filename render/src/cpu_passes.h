// SPDX-License-Identifier: Zlib
// Skins, normals and side vectors of tubes on the CPU.
#pragma once

#include "limber/render/shape_desc.h"
#include "limber/render/vec3.h"
#include "row_threads.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber::render {

// --- normals and side vectors ------------------------------------------------------------------------------

/// The triangles of a mesh on the CPU; vertices at the same point (with a skin: place) are one.
struct CpuTriangles {
  std::uint32_t pointCount = 0;
  std::uint32_t normalCount = 0;
  std::vector<std::uint32_t> corners;    ///< 3 points for each triangle.
  std::vector<std::uint32_t> normalsOf;  ///< 3 normals for each triangle; empty: those of the points.
};

/// Instances of one shape; what belongs to them is contiguous.
struct CpuInstances {
  std::size_t count = 0;
  const float* in = nullptr;  ///< count x #points x 3; for normals with a skin count x #places x 3.
  float* out = nullptr;       ///< count x #results x 3; written, never read.
};

/// Computes the normals that mesh_normals.comp computes. `sums` is scratch memory. A thread has whole
/// instances.
void computeMeshNormals(const CpuTriangles& mesh, const CpuInstances& instances, std::vector<Vec3>& sums,
                        RowThreads& threads);

/// Computes the side vectors that tube_frames.comp computes, one for each point.
void computeTubeFrames(std::uint32_t pointCount, const CpuInstances& instances);

// --- skins -------------------------------------------------------------------------------------------------

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

/// Computes the places of all instances in one pass over the weights, so that a large matrix is read from
/// memory once and not once for each instance. `lanes` is scratch memory.
void applySkin(const CpuSkin& skin, const CpuInstances& instances, std::vector<Lanes>& lanes,
               RowThreads& threads);

}  // namespace limber::render
