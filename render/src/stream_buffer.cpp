// SPDX-License-Identifier: Zlib
#include "limber/render/stream_buffer.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "gl_fences.h"

namespace limber::render {
namespace {

// The largest offset alignment that OpenGL lets a driver ask for storage buffers.
constexpr std::size_t kRegionAlignment = 256;
constexpr GLbitfield kMapFlags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;

std::size_t roundUp(std::size_t bytes) {
  return (bytes + kRegionAlignment - 1) / kRegionAlignment * kRegionAlignment;
}

}  // namespace

StreamBuffer::StreamBuffer(const Gl& gl, const StreamBufferDesc& desc)
    : fences_(std::make_unique<GlFences>(gl)),
      ring_(*fences_, desc.fenceTimeout),
      floatsPerFrame_(std::max<std::size_t>(desc.floatsPerFrame, 1)),
      regionBytes_(roundUp(floatsPerFrame_ * sizeof(float))),
      poison_(desc.poison) {
  const std::size_t bytes = regionBytes_ * StreamRing::kRegionCount;
  buffer_ = makeBuffer(gl, bytes, nullptr, kMapFlags);
  mapped_ = static_cast<float*>(
      gl.MapNamedBufferRange(buffer_.name(), 0, static_cast<GLsizeiptr>(bytes), kMapFlags));
  if (mapped_ == nullptr) {
    throw std::runtime_error("the driver refused to map a stream buffer of " + std::to_string(bytes) +
                             " bytes");
  }
}

// Deleting a mapped buffer unmaps it.
StreamBuffer::~StreamBuffer() = default;

StreamFrame StreamBuffer::beginFrame() {
  const std::size_t offset = ring_.begin() * regionBytes_;
  StreamFrame frame{mapped_ + offset / sizeof(float), floatsPerFrame_, static_cast<GLintptr>(offset)};
  if (poison_) {
    std::fill_n(frame.data, frame.floatCount, std::numeric_limits<float>::quiet_NaN());
  }
  return frame;
}

void StreamBuffer::endFrame(std::size_t bytesWritten) {
  ring_.submit();
  bytesLastFrame_ = bytesWritten;
}

}  // namespace limber::render
