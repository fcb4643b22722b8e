// SPDX-License-Identifier: Zlib
#pragma once

#include "cpu_normals.h"
#include "cpu_skin.h"
#include "gpu_shape.h"
#include "instance_table.h"

#include <vector>

namespace limber::render {

/// Computes skins, normals and side vectors of tubes on the CPU. With a software rasteriser this is several
/// times faster than its compute shaders, which run on the same processor.
class CpuPasses {
 public:
  explicit CpuPasses(unsigned threads) : threads_(threads) {}

  /// The number of points, places and normals of a frame. They follow one another in this order.
  static std::size_t streamedPoints(const FrameLayout& layout);
  static std::uint32_t firstPlace(const FrameLayout& layout);
  static std::uint32_t firstNormal(const FrameLayout& layout);

  /// `stream` has streamedPoints() x 3 floats. Reads the points and writes the rest.
  void compute(const FrameLayout& layout, const ShapeTable& shapes, float* stream);

 private:
  RowThreads threads_;
  std::vector<Lanes> lanes_;  // These two are scratch memory.
  std::vector<Vec3> sums_;
};

}  // namespace limber::render
