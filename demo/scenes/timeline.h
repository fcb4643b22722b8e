// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

namespace limber::scenes {

constexpr std::int64_t kTicksPerSecond = 60;

/// When pictures are taken of a run of whole ticks. Frame k shows time k / fps: the world after the first
/// tick that does not end before it, or, if that ends later, between this tick and the one before. Integers
/// only, so that no rounding ever adds or drops a tick.
struct Timeline {
  std::int64_t ticks = 0;            ///< of the whole run
  std::int64_t framesPerSecond = 1;  ///< at least 1

  /// Ticks to do before frame k is drawn.
  std::int64_t ticksFor(std::int64_t frame) const;
  /// Where in the last of them frame k lies: above 0, and 1 at its end.
  double tickFraction(std::int64_t frame) const;
  /// Frames from time 0 to the end of the run, both included.
  std::int64_t frameCount() const;
};

/// The timeline of at least `seconds`.
Timeline timelineOf(double seconds, int framesPerSecond);

}  // namespace limber::scenes
