// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/soft_body_system.h>

#include <cstdint>
#include <string>

namespace limber::bench {

enum class Mode {
  Bare,  ///< as many loose Bullet spheres as the cubes have points: no springs, no plugin, no pictures
  None,  ///< soft cubes without a renderer
  Shaded,
  Wireframe
};
const char* nameOf(Mode mode);
bool isDrawn(Mode mode);

/// What was measured at one count in one mode. Times are milliseconds of wall time unless said; means,
/// medians and maxima are over samples, one per tenth of a simulated second.
struct ScalingRow {
  Mode mode = Mode::None;
  std::uint32_t bodies = 0;
  std::size_t points = 0, springs = 0;

  double tickMean = 0.0, tickMedian = 0.0, tickMax = 0.0;
  double tickWorst = 0.0;    ///< of all ticks, sampled or not
  double tickCpuMean = 0.0;  ///< processor time of the sampled ticks
  TickProfile own;           ///< the plugin's part of the sampled ticks, means
  double renderMean = 0.0, renderMax = 0.0;
  std::size_t gpuBytes = 0;  ///< of buffers, without textures and render targets
  std::string driver;        ///< of OpenGL; empty without a renderer

  double realTime =
      0.0;  ///< simulated seconds per second, with a frame after each tick where there are frames
  double contacts = 0.0;     ///< mean number of touching pairs
  double asleepShare = 0.0;  ///< mean share of bodies asleep
  double simulatedSeconds = 0.0;
  bool complete = false;   ///< false: given up early, because too slow
  int repeats = 1;         ///< runs measured, of which this is the middle one
  bool repeatable = true;  ///< all runs ended in the same state, bit for bit
  std::uint64_t hash = 0;  ///< of the last state
};

double microsecondsPerPoint(const ScalingRow& row);

/// One line for people.
std::string describe(const ScalingRow& row);

}  // namespace limber::bench
