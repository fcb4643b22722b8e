// SPDX-License-Identifier: Zlib
#include "scaling/scaling_row.h"

#include <cstdio>

namespace limber::bench {

const char* nameOf(Mode mode) {
  switch (mode) {
    case Mode::Bare:
      return "bare";
    case Mode::None:
      return "none";
    case Mode::Shaded:
      return "shaded";
    case Mode::Wireframe:
      return "wireframe";
  }
  return "";
}

bool isDrawn(Mode mode) { return mode == Mode::Shaded || mode == Mode::Wireframe; }

double microsecondsPerPoint(const ScalingRow& row) {
  return row.points ? 1e3 * row.tickMean / static_cast<double>(row.points) : 0.0;
}

std::string describe(const ScalingRow& row) {
  char frame[40] = "";
  if (isDrawn(row.mode)) std::snprintf(frame, sizeof frame, ", frame %.2f ms", row.renderMean);
  char text[160];
  std::snprintf(text, sizeof text, "%-9s %5u cubes: tick %.3f ms%s, %.2f x real time%s", nameOf(row.mode),
                row.bodies, row.tickMean, frame, row.realTime, row.complete ? "" : " (given up)");
  return text;
}

}  // namespace limber::bench
