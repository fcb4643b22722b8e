// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/vec3.h"
#include "row_threads.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber::render {

/// The triangles of a mesh on the CPU; vertices at the same point (with a skin: place) are one.
struct CpuTriangles {
  std::uint32_t pointCount = 0;
  std::uint32_t normalCount = 0;
  std::vector<std::uint32_t> corners;    ///< 3 points for each triangle.
  std::vector<std::uint32_t> normalsOf;  ///< 3 normals for each triangle; empty: those of the points.
};

/// Meshes or tubes of one shape; their points and normals are contiguous.
struct SmoothInstances {
  std::size_t count = 0;
  const float* points = nullptr;  ///< count x #points x 3; with a skin the places.
  float* normals = nullptr;       ///< count x #normals x 3 (of tubes #points); written, never read.
};

/// Computes the normals that mesh_normals.comp computes. `sums` is scratch memory. A thread has whole
/// instances.
void computeMeshNormals(const CpuTriangles& mesh, const SmoothInstances& instances, std::vector<Vec3>& sums,
                        RowThreads& threads);

/// Computes the side vectors that tube_frames.comp computes.
void computeTubeFrames(std::uint32_t pointCount, const SmoothInstances& instances);

}  // namespace limber::render
