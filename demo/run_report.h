// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <limber/soft_body_system.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace limber::demo {

/// Mean and largest of many milliseconds.
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

/// How well the solid bodies have kept their shape, per size of the body.
struct ShapeFigures {
  std::size_t solids = 0;  ///< bodies that have a shape to keep: no ropes, no cloths
  double mean = 0.0;
  double worst = 0.0;
  std::size_t insideOut = 0;
  bool kept() const;
};

/// All that is reported of a run.
struct RunFigures {
  Milliseconds tick;    ///< a step of the whole world by 1/60 s
  TickProfile soft;     ///< the plugin's part of the ticks, summed
  Milliseconds render;  ///< from positions to pixels in memory
  Milliseconds output;  ///< handing the picture on to the writer
  std::size_t gpuBufferBytes = 0;
  std::size_t bytesPerFrame = 0;  ///< of positions, streamed for the last picture
  std::uint64_t ringWaits = 0;    ///< frames that found their region of the ring in flight
  std::uint64_t ringStalls = 0;   ///< of these, those that had to wait for the GPU
  std::string driver;             ///< empty without pictures
  double simulatedSeconds = 0.0;
  double wallSeconds = 0.0;
  double realTimeFactor() const { return wallSeconds > 0.0 ? simulatedSeconds / wallSeconds : 0.0; }
  double tickRealTimeFactor() const { return tick.sum > 0.0 ? 1000.0 * simulatedSeconds / tick.sum : 0.0; }

  std::size_t bodies = 0, points = 0, springs = 0;
  ShapeFigures shape;
  std::uint64_t stateHash = 0;
  std::string endProblem;  ///< empty: the scene ended as it should
};

/// Prints the figures of a run for people, on standard output.
void printTable(const DemoOptions& options, const RunFigures& figures);

/// Writes them to options.statsFile. Returns the reason when that fails, or an empty string.
std::string writeJson(const DemoOptions& options, const RunFigures& figures);

}  // namespace limber::demo
