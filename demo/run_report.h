// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <limber/soft_body_system.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace limber::demo {

/// Mean and maximum of many durations, ms.
struct Milliseconds {
  double sum = 0.0;
  double max = 0.0;
  std::size_t count = 0;

  void add(double ms) {
    sum += ms;
    max = std::max(max, ms);
    ++count;
  }
  double mean() const { return count ? sum / static_cast<double>(count) : 0.0; }
};

/// Errors of the solid bodies' shapes, relative to the size of the body.
struct ShapeFigures {
  std::size_t solids = 0;  ///< number of solid bodies, without ropes and cloths
  double mean = 0.0;
  double worst = 0.0;
  std::size_t insideOut = 0;
};

/// All results of a run.
struct RunFigures {
  Milliseconds tick;    ///< one step of the whole world, 1/60 s
  TickProfile soft;     ///< sum of the plugin's part of the ticks
  Milliseconds render;  ///< from positions to pixels in memory
  Milliseconds output;  ///< passing the picture to the writer
  std::size_t gpuBufferBytes = 0;
  std::size_t bytesPerFrame = 0;  ///< of positions, streamed for the last picture
  std::uint64_t ringWaits = 0;    ///< frames whose region of the ring was in flight
  std::uint64_t ringStalls = 0;   ///< of these, frames that waited for the GPU
  std::string driver;             ///< empty without pictures
  double simulatedSeconds = 0.0;
  double wallSeconds = 0.0;
  double realTimeFactor() const { return wallSeconds > 0.0 ? simulatedSeconds / wallSeconds : 0.0; }
  double tickRealTimeFactor() const { return tick.sum > 0.0 ? 1000.0 * simulatedSeconds / tick.sum : 0.0; }

  std::size_t bodies = 0, points = 0, springs = 0;
  ShapeFigures shape;
  std::uint64_t stateHash = 0;
  std::string endProblem;  ///< empty: the end checks passed
};

/// Prints the figures of a run as text on standard output.
void printTable(const DemoOptions& options, const RunFigures& figures);

/// Writes the figures as JSON to options.statsFile. Returns the reason of a failure, or an empty string.
std::string writeJson(const DemoOptions& options, const RunFigures& figures);

}  // namespace limber::demo
