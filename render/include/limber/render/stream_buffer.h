// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/gl_objects.h"
#include "limber/render/stream_ring.h"

#include <chrono>
#include <cstddef>
#include <memory>

namespace limber::render {

/// The part of the buffer that may be written for one frame.
struct StreamFrame {
  float* data = nullptr;       ///< Best written in order, and not read unless it was made readable.
  std::size_t floatCount = 0;  ///< Floats that fit.
  GLintptr byteOffset = 0;     ///< Of `data` from the start of the buffer; a multiple of 256.
};

struct StreamBufferDesc {
  std::size_t floatsPerFrame = 0;  ///< At least 1.
  std::chrono::nanoseconds fenceTimeout = std::chrono::seconds(5);
  bool readable = false;  ///< The open region may also be read.
#ifdef NDEBUG
  bool poison = false;
#else
  bool poison = true;  ///< Fills each region with NaN when it is opened.
#endif
};

/// One buffer of three regions, mapped once for the life of the object (persistent and
/// coherent), so that a writer fills GPU-visible memory with no copy and no map call per frame.
/// Use on the thread of its context only; the memory itself may be written by any thread
/// between beginFrame() and endFrame().
class StreamBuffer {
 public:
  /// `gl` must outlive the object. Throws std::runtime_error if the driver refuses.
  StreamBuffer(const Gl& gl, const StreamBufferDesc& desc);
  ~StreamBuffer();
  StreamBuffer(const StreamBuffer&) = delete;
  StreamBuffer& operator=(const StreamBuffer&) = delete;

  /// Opens the next region, waiting for the GPU if all are busy. Errors as StreamRing::begin.
  StreamFrame beginFrame();
  /// Fences the open region: call after the last command that reads it.
  void endFrame() { ring_.submit(); }
  /// Closes the open region unused.
  void cancelFrame() { ring_.cancel(); }
  /// Waits until the GPU has finished with all regions.
  void drain() { ring_.drain(); }

  GLuint name() const { return buffer_.name(); }
  std::size_t bytes() const { return buffer_.bytes(); }
  std::size_t floatsPerFrame() const { return floatsPerFrame_; }
  const StreamRing::Counters& counters() const { return ring_.counters(); }

 private:
  std::unique_ptr<FenceSource> fences_;
  StreamRing ring_;
  GlBuffer buffer_;
  float* mapped_ = nullptr;
  std::size_t floatsPerFrame_ = 0;
  std::size_t regionBytes_ = 0;
  bool poison_ = false;
};

}  // namespace limber::render
