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

/// Reads three floats for each skinned point of the shape, from point number `first` of the buffer on.
std::vector<float> read(const Gl& gl, const GlBuffer& buffer, std::uint32_t first, const GpuShape& shape) {
  std::vector<float> values(std::size_t{3} * shape.skinnedPointCount);
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl.GetNamedBufferSubData(buffer.name(), static_cast<GLintptr>(3 * sizeof(float) * first),
                           static_cast<GLsizeiptr>(values.size() * sizeof(float)), values.data());
  return values;
}

}  // namespace

std::vector<float> readNormals(Renderer& renderer, InstanceId instance) {
  const Parts& parts = RendererAccess::parts(renderer);
  const FrameLayout::Slice& slice = sliceOf(parts, instance);
  const GpuShape& shape = parts.shapes[parts.instances.shapeOf(instance)];
  if (!shape.needsNormals()) {
    throw std::runtime_error("the instance is not smooth");
  }
  return read(parts.gl, parts.normals, slice.firstNormal, shape);
}

std::vector<float> readSkinnedPoints(Renderer& renderer, InstanceId instance) {
  const Parts& parts = RendererAccess::parts(renderer);
  const FrameLayout::Slice& slice = sliceOf(parts, instance);
  const GpuShape& shape = parts.shapes[parts.instances.shapeOf(instance)];
  if (!shape.skinned()) {
    throw std::runtime_error("the instance has no skin");
  }
  return read(parts.gl, parts.places, slice.firstPlace, shape);
}

}  // namespace limber::render::test
