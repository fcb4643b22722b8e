// SPDX-License-Identifier: Zlib
#include "limber/render/stream_ring.h"

#include <stdexcept>
#include <string>

namespace limber::render {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

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
    const auto start = steady_clock::now();
    if (!fences_.wait(region.fence, timeout_)) {
      const double seconds = std::chrono::duration<double>(timeout_).count();
      throw std::runtime_error("stream ring: the GPU still uses region " + std::to_string(index) + " after " +
                               std::to_string(seconds) + " s");
    }
    counters_.stalled += steady_clock::now() - start;
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

}  // namespace limber::render
