// SPDX-License-Identifier: Zlib
#include "scene/signals.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limber::bench {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr long kStencil = 6;

/// Returns the time between `low` and `high` at which the signal crosses the level, by bisection.
double crossingTime(const Signal& signal, double level, double low, double high) {
  const bool below = signal.at(low) < level;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    ((signal.at(middle) < level) == below ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double Signal::at(double t) const {
  const auto count = static_cast<long>(samples.size());
  const long points = std::min(kStencil, count);
  const long first = std::clamp(static_cast<long>(std::floor(t / dt)) - kStencil / 2 + 1, 0l, count - points);
  double sum = 0.0;
  for (long i = first; i < first + points; ++i) {
    double weight = 1.0;
    for (long j = first; j < first + points; ++j)
      if (j != i) weight *= (t / dt - static_cast<double>(j)) / static_cast<double>(i - j);
    sum += weight * samples[static_cast<std::size_t>(i)];
  }
  return sum;
}

std::vector<double> fallsThroughZero(const Signal& signal) {
  std::vector<double> falls;
  for (std::size_t i = 1; i < signal.samples.size(); ++i)
    if (signal.samples[i - 1] > 0 && signal.samples[i] <= 0)
      falls.push_back(crossingTime(signal, 0.0, signal.dt * static_cast<double>(i - 1),
                                   signal.dt * static_cast<double>(i)));
  return falls;
}

double period(const Signal& signal) {
  const std::vector<double> falls = fallsThroughZero(signal);
  if (falls.size() < 2) return kNever;
  return (falls.back() - falls.front()) / static_cast<double>(falls.size() - 1);
}

double amplitude(const Signal& signal, double from, double to) {
  double largest = 0.0;
  const double step = signal.dt / 32;
  for (double t = std::max(from, 0.0); t <= std::min(to, signal.end()); t += step)
    largest = std::max(largest, std::abs(signal.at(t)));
  return largest;
}

double firstReaches(const Signal& signal, double level, double from) {
  const auto first = static_cast<std::size_t>(std::ceil(from / signal.dt));
  for (std::size_t i = first + 1; i < signal.samples.size(); ++i)
    if ((signal.samples[i - 1] < level) != (signal.samples[i] < level))
      return crossingTime(signal, level, signal.dt * static_cast<double>(i - 1),
                          signal.dt * static_cast<double>(i));
  return kNever;
}

}  // namespace limber::bench
