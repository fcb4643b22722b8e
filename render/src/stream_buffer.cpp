// SPDX-License-Identifier: Zlib
#include "limber/render/stream_buffer.h"

#include "limber/render/gl_functions.h"
#include "limber/render/stream_ring.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace limber::render {

using std::chrono::nanoseconds;

StreamRing::StreamRing(FenceSource& fences, nanoseconds timeout) : fences_(fences), timeout_(timeout) {}

StreamRing::~StreamRing() {
  for (Region& region : regions_) {
    if (region.fence != nullptr) {
      fences_.destroy(region.fence);
    }
  }
}

std::size_t StreamRing::begin() {
  if (writing()) {
    throw std::logic_error("stream ring: begin() while region " + std::to_string(current_) +
                           " is being written; submit() or cancel() it first");
  }
  const std::size_t next = (current_ + 1) % kRegionCount;
  if (regions_[next].state == State::InFlight) {
    ++counters_.waits;
    waitFor(next);
  }
  regions_[next].state = State::Writing;
  current_ = next;
  return next;
}

void StreamRing::submit() {
  Region& region = openRegion("submit");
  region.state = State::Free;  // also if there is no context for a fence
  region.fence = fences_.insert();
  region.state = State::InFlight;
  ++counters_.frames;
}

void StreamRing::cancel() { openRegion("cancel").state = State::Free; }

void StreamRing::drain() {
  if (writing()) {
    throw std::logic_error("stream ring: drain() while region " + std::to_string(current_) +
                           " is being written");
  }
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    if (regions_[i].state == State::InFlight) {
      waitFor(i);
    }
  }
}

void StreamRing::waitFor(std::size_t index) {
  Region& region = regions_[index];
  if (!fences_.wait(region.fence, nanoseconds::zero())) {
    ++counters_.stalls;
    if (!fences_.wait(region.fence, timeout_)) {
      const double seconds = std::chrono::duration<double>(timeout_).count();
      throw std::runtime_error("stream ring: the GPU still uses region " + std::to_string(index) + " after " +
                               std::to_string(seconds) + " s");
    }
  }
  fences_.destroy(region.fence);
  region = Region{};
}

StreamRing::Region& StreamRing::openRegion(const char* caller) {
  if (!writing()) {
    throw std::logic_error(std::string("stream ring: ") + caller + "() without begin()");
  }
  return regions_[current_];
}

namespace {

/// The ring's fences as OpenGL sync objects.
class GlFences final : public FenceSource {
 public:
  explicit GlFences(const Gl& gl) : gl_(gl) {}

  Fence insert() override {
    const GLsync sync = gl_.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (sync == nullptr) {
      throw std::runtime_error("glFenceSync failed: the OpenGL context is lost or not current");
    }
    return sync;
  }

  bool wait(Fence fence, std::chrono::nanoseconds timeout) override {
    // Without the flush, the fence could stay in an unsent command buffer for ever.
    const GLenum result = gl_.ClientWaitSync(static_cast<GLsync>(fence), GL_SYNC_FLUSH_COMMANDS_BIT,
                                             static_cast<GLuint64>(timeout.count()));
    if (result == GL_WAIT_FAILED) {
      throw std::runtime_error("glClientWaitSync failed: the OpenGL context is lost or not current");
    }
    return result != GL_TIMEOUT_EXPIRED;
  }

  void destroy(Fence fence) noexcept override { gl_.DeleteSync(static_cast<GLsync>(fence)); }

 private:
  const Gl& gl_;
};

// The largest offset alignment of storage buffers that a driver may require.
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
  const GLbitfield flags = kMapFlags | (desc.readable ? GL_MAP_READ_BIT : 0u);
  buffer_ = makeBuffer(gl, bytes, nullptr, flags);
  mapped_ =
      static_cast<float*>(gl.MapNamedBufferRange(buffer_.name(), 0, static_cast<GLsizeiptr>(bytes), flags));
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

}  // namespace limber::render
