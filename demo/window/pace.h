// SPDX-License-Identifier: Zlib
#pragma once

namespace limber::demo {

/// How many ticks a frame has, so that a scene runs at the speed of the clock, or slower.
class Pace {
 public:
  bool paused = false;
  double speed = 1.0;  ///< simulated seconds a second, above 0 to 1

  /// Asks for one tick while paused.
  void step() { ++steps_; }

  /// Returns the number of ticks of a frame after so many seconds. A machine that is too slow for the speed
  /// gets few ticks a frame, so that it stays usable.
  int ticksDue(double seconds);

  /// Returns the position between the last two ticks: 0 to 1.
  double tickFraction() const { return paused ? 1.0 : remainder_; }

 private:
  int steps_ = 0;
  double remainder_ = 1.0;  // ticks
};

/// Returns the next slower speed, or full speed after the slowest.
double slowerThan(double speed);

}  // namespace limber::demo
