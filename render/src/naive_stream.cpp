// SPDX-License-Identifier: Zlib
#include "naive_stream.h"

namespace limber::render {

float* NaiveStream::begin(const FrameLayout& layout) {
  staging_.resize(3 * layout.pointCount);
  return staging_.data();
}

GLuint NaiveStream::bufferFor(std::size_t instance, std::size_t bytes) {
  if (instance >= buffers_.size()) {
    buffers_.resize(instance + 1);
  }
  if (buffers_[instance].bytes() != bytes) {
    buffers_[instance] = makeBuffer(gl_, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
  }
  return buffers_[instance].name();
}

void NaiveStream::upload(const FrameLayout& layout, const ShapeTable& shapes, const GlBuffer& places,
                         std::vector<DrawItem>& items) {
  items.clear();
  for (const InstanceGroup& group : layout.groups) {
    const GpuShape& shape = shapes[group.shape];
    const std::size_t bytes = 3 * sizeof(float) * shape.pointCount;
    for (std::uint32_t i = 0; i < group.instanceCount; ++i) {
      const std::uint32_t skipped = i * shape.pointCount;
      const GLuint buffer = bufferFor(group.firstInstance + i, bytes);
      gl_.NamedBufferSubData(buffer, 0, static_cast<GLsizeiptr>(bytes),
                             staging_.data() + 3 * std::size_t{group.firstPoint + skipped});
      const PointRange points{buffer, 0, static_cast<GLsizeiptr>(bytes), 0};
      const PointRange skinned{places.name(), 0, static_cast<GLsizeiptr>(places.bytes()),
                               group.firstPlace + i * shape.placeCount};
      items.push_back({&shape, group.firstInstance + i, 1, group.firstNormal + i * shape.placeCount, points,
                       shape.skinned() ? skinned : points, group.textured});
    }
  }
}

std::size_t NaiveStream::bytes() const {
  std::size_t sum = 0;
  for (const GlBuffer& buffer : buffers_) {
    sum += buffer.bytes();
  }
  return sum;
}

}  // namespace limber::render
