// SPDX-License-Identifier: Zlib
#pragma once

#include <chrono>

namespace limber::render {

/// Milliseconds since construction or since the last call of lap().
class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace limber::render
