// SPDX-License-Identifier: Zlib
#include "cpu_passes.h"

#include <cstddef>

namespace limber::render {

std::uint32_t CpuPasses::firstPlace(const FrameLayout& layout) {
  return static_cast<std::uint32_t>(layout.pointCount);
}

std::uint32_t CpuPasses::firstNormal(const FrameLayout& layout) {
  return static_cast<std::uint32_t>(layout.pointCount + layout.skinnedPointCount);
}

std::size_t CpuPasses::streamedPoints(const FrameLayout& layout) {
  return layout.pointCount + layout.skinnedPointCount + layout.normalCount;
}

void CpuPasses::compute(const FrameLayout& layout, const ShapeTable& shapes, float* stream) {
  for (const InstanceGroup& group : layout.groups) {
    const GpuShape& shape = shapes[group.shape];
    const float* points = stream + 3 * std::size_t{group.firstPoint};
    if (shape.skinned()) {
      float* places = stream + 3 * (std::size_t{firstPlace(layout)} + group.firstPlace);
      applySkin(shape.cpu.skin, {group.instanceCount, points, places}, lanes_, threads_);
      points = places;
    }
    if (!shape.needsNormals()) {
      continue;
    }
    float* normals = stream + 3 * (std::size_t{firstNormal(layout)} + group.firstNormal);
    const SmoothInstances instances{group.instanceCount, points, normals};
    if (shape.tube) {
      computeTubeFrames(shape.pointCount, instances);
    } else {
      computeMeshNormals(shape.cpu.triangles, instances, sums_, threads_);
    }
  }
}

}  // namespace limber::render
