// SPDX-License-Identifier: Zlib
#include "scenes/timeline.h"

#include <cmath>

namespace limber::scenes {

std::int64_t Timeline::ticksFor(std::int64_t frame) const {
  return (frame * kTicksPerSecond + framesPerSecond - 1) / framesPerSecond;
}

double Timeline::tickFraction(std::int64_t frame) const {
  const std::int64_t over = ticksFor(frame) * framesPerSecond - frame * kTicksPerSecond;
  return 1.0 - static_cast<double>(over) / static_cast<double>(framesPerSecond);
}

std::int64_t Timeline::frameCount() const { return ticks * framesPerSecond / kTicksPerSecond + 1; }

Timeline timelineOf(double seconds, int framesPerSecond) {
  // 0.1 s is a hair over 6 ticks in binary: that hair must not become a seventh
  constexpr double kHair = 1e-9;
  const double ticks = std::ceil(seconds * static_cast<double>(kTicksPerSecond) - kHair);
  return {static_cast<std::int64_t>(ticks), framesPerSecond};
}

}  // namespace limber::scenes
