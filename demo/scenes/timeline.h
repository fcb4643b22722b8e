// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

namespace limber::scenes {

constexpr std::int64_t kTicksPerSecond = 60;

/// When pictures are taken of a run of whole ticks. Frame k shows time k / fps: the world after all ticks
/// that fit into it. Integers only, so that no rounding ever adds or drops a tick.
struct Timeline {
  std::int64_t ticks = 0;            ///< of the whole run
  std::int64_t framesPerSecond = 1;  ///< at least 1

  /// Ticks done when frame k is shown.
  std::int64_t ticksBefore(std::int64_t frame) const;
  /// Frames from time 0 to the end of the run, both included.
  std::int64_t frameCount() const;
};

/// The timeline of at least `seconds`.
Timeline timelineOf(double seconds, int framesPerSecond);

}  // namespace limber::scenes
