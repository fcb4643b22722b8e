// SPDX-License-Identifier: Zlib
#include "computed_points.h"

#include <cstddef>
#include <stdexcept>

#include "renderer_parts.h"

namespace limber::render::test {
namespace {

using Parts = RendererAccess::Parts;

const FrameLayout::Slice& sliceOf(const Parts& parts, InstanceId instance) {
  const FrameLayout::Slice* slice = parts.layout.find(instance);
  if (slice == nullptr) {
    throw std::runtime_error("the instance was not in the last frame");
  }
  return *slice;
}

const GpuShape& shapeOf(const Parts& parts, InstanceId instance) {
  return parts.shapes[parts.instances.shapeOf(instance)];
}

/// Reads so many points, three floats each, from the first point of the range on.
std::vector<float> read(const Parts& parts, std::size_t count, const PointRange& range) {
  const Gl& gl = parts.gl;
  std::vector<float> values(3 * count);
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  const GLintptr offset = range.byteOffset + static_cast<GLintptr>(3 * sizeof(float) * range.first);
  gl.GetNamedBufferSubData(range.buffer, offset, static_cast<GLsizeiptr>(values.size() * sizeof(float)),
                           values.data());
  return values;
}

}  // namespace

std::vector<float> readNormals(Renderer& renderer, InstanceId instance) {
  const Parts& parts = RendererAccess::parts(renderer);
  const std::uint32_t first = sliceOf(parts, instance).firstNormal;
  if (!shapeOf(parts, instance).needsNormals()) {
    throw std::runtime_error("the instance is not smooth");
  }
  return read(parts, shapeOf(parts, instance).normalCount, parts.normalRange().from(first));
}

std::vector<float> readSkinnedPoints(Renderer& renderer, InstanceId instance) {
  const Parts& parts = RendererAccess::parts(renderer);
  const std::uint32_t first = sliceOf(parts, instance).firstPlace;
  if (!shapeOf(parts, instance).skinned()) {
    throw std::runtime_error("the instance has no skin");
  }
  return read(parts, shapeOf(parts, instance).skinnedPointCount, parts.placeRange().from(first));
}

}  // namespace limber::render::test
