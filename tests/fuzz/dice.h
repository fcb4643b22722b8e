// SPDX-License-Identifier: Zlib
#pragma once

#include "mesh/random.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <string>

namespace limber::fuzz {

/// Random numbers with three digits, so that printed stories are short.
class Dice {
 public:
  /// Mixes the seed: SplitMix64 counts its state up, so near seeds would give shifted copies of one sequence.
  explicit Dice(std::uint64_t seed) : random_(Random(seed).next()) {}

  int below(int count) { return static_cast<int>(random_.below(static_cast<std::size_t>(count))); }
  int between(int low, int high) { return low + below(high - low + 1); }
  bool chance(double probability) { return random_.uniform() < probability; }
  double number(double low, double high) { return rounded(low + (high - low) * random_.uniform()); }
  /// Uniform in the logarithm: each decade is equally likely.
  double decades(double low, double high) { return rounded(low * std::pow(high / low, random_.uniform())); }
  Eigen::Vector3d ball(double radius) { return rounded(radius * random_.inBall()); }
  Eigen::Vector3d box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    const double x = number(low.x(), high.x()), y = number(low.y(), high.y());
    return {x, y, number(low.z(), high.z())};
  }
  template <class T>
  T of(std::initializer_list<T> values) {
    return values.begin()[below(static_cast<int>(values.size()))];
  }

  static double rounded(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.3g", value);
    return std::strtod(text, nullptr);
  }
  static Eigen::Vector3d rounded(const Eigen::Vector3d& v) {
    return {rounded(v.x()), rounded(v.y()), rounded(v.z())};
  }

 private:
  Random random_;
};

}  // namespace limber::fuzz
