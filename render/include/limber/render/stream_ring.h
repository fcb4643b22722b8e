// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace limber::render {

/// Creates fences and waits for them. An interface, so that the ring can be tested without a GPU.
class FenceSource {
 public:
  using Fence = void*;  ///< Never null for a live fence.

  virtual ~FenceSource() = default;
  /// Returns a fence that is signalled when all commands submitted before it are done.
  virtual Fence insert() = 0;
  /// Returns true if the fence is signalled within the timeout. A timeout of zero does not wait.
  virtual bool wait(Fence fence, std::chrono::nanoseconds timeout) = 0;
  virtual void destroy(Fence fence) noexcept = 0;
};

/// Chooses which of three regions of a buffer may be written now. The states of a region are: free -> writing
/// (begin) -> in flight (submit) -> free (its fence passed). The ring does not touch memory; it only rejects
/// calls in a wrong order and waits for fences.
///
/// The checks throw std::logic_error in every build, because a software rasteriser hides a
/// missing fence that a GPU would punish.
class StreamRing {
 public:
  static constexpr std::size_t kRegionCount = 3;
  enum class State : std::uint8_t { Free, Writing, InFlight };

  struct Counters {
    std::uint64_t frames = 0;  ///< Regions submitted.
    std::uint64_t waits = 0;   ///< Times begin() found its region in flight.
    std::uint64_t stalls = 0;  ///< Of these, how often the fence had not yet passed.
  };

  /// `fences` must outlive the ring.
  explicit StreamRing(FenceSource& fences, std::chrono::nanoseconds timeout = std::chrono::seconds(5));
  /// Destroys the fences without waiting.
  ~StreamRing();
  StreamRing(const StreamRing&) = delete;
  StreamRing& operator=(const StreamRing&) = delete;

  /// Opens the next region for writing and returns its index, waiting for its fence if need be.
  /// Throws std::logic_error if a region is already open and std::runtime_error if the fence
  /// does not pass in time (the region then stays in flight).
  std::size_t begin();
  /// Closes the open region after the last command that reads it was issued.
  /// Throws std::logic_error unless a region is open.
  void submit();
  /// Closes the open region unused. Throws std::logic_error unless a region is open.
  void cancel();
  /// Waits until no region is in flight. Throws std::logic_error while a region is open and
  /// std::runtime_error on timeout.
  void drain();

  State state(std::size_t region) const { return regions_.at(region).state; }
  bool writing() const { return regions_[current_].state == State::Writing; }
  const Counters& counters() const { return counters_; }

 private:
  struct Region {
    State state = State::Free;
    FenceSource::Fence fence = nullptr;
  };

  void waitFor(std::size_t region);
  Region& openRegion(const char* caller);

  FenceSource& fences_;
  std::chrono::nanoseconds timeout_;
  std::array<Region, kRegionCount> regions_{};
  std::size_t current_ = kRegionCount - 1;
  Counters counters_;
};

}  // namespace limber::render
