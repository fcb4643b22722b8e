// SPDX-License-Identifier: Zlib
#include "window/pace.h"

#include "scenes/scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace limber::demo {

int Pace::ticksDue(double seconds) {
  constexpr double kMaxTicks = 4.0;  // a frame
  if (paused) return std::exchange(steps_, 0);
  steps_ = 0;
  const double ticks = seconds * speed * static_cast<double>(scenes::kTicksPerSecond);
  remainder_ += std::clamp(ticks, 0.0, kMaxTicks);
  const double due = std::floor(remainder_);
  remainder_ -= due;
  return static_cast<int>(due);
}

double slowerThan(double speed) {
  constexpr double kSlowest = 0.05, kShare = 0.25;
  return speed * kShare < kSlowest ? 1.0 : speed * kShare;
}

}  // namespace limber::demo
