// SPDX-License-Identifier: Zlib
#include "scenes/timeline.h"

#include <cmath>

namespace limber::scenes {

std::int64_t Timeline::ticksBefore(std::int64_t frame) const {
  return frame * kTicksPerSecond / framesPerSecond;
}

std::int64_t Timeline::frameCount() const { return ticks * framesPerSecond / kTicksPerSecond + 1; }

Timeline timelineOf(double seconds, int framesPerSecond) {
  // 0.1 s is a hair over 6 ticks in binary: that hair must not become a seventh
  constexpr double kHair = 1e-9;
  const double ticks = std::ceil(seconds * static_cast<double>(kTicksPerSecond) - kHair);
  return {static_cast<std::int64_t>(ticks), framesPerSecond};
}

}  // namespace limber::scenes
