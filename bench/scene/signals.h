// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

namespace limber::bench {

/// A signal sampled once per tick. Between the samples it is the polynomial of degree 5 through the nearest
/// six samples. With 15 samples per period, the error is 1e-7 of a period.
struct Signal {
  double dt = 0.0;
  std::vector<double> samples;

  double at(double t) const;
  double end() const { return dt * static_cast<double>(samples.size() - 1); }
};

/// Returns the times at which the signal falls through zero.
std::vector<double> fallsThroughZero(const Signal& signal);

/// Returns the mean time between its falls through zero; infinite if there are fewer than two.
double period(const Signal& signal);

/// Returns the largest magnitude in [from, to].
double amplitude(const Signal& signal, double from, double to);

/// Returns the first time after `from` at which the signal crosses `level`, or infinity.
double firstReaches(const Signal& signal, double level, double from = 0.0);

}  // namespace limber::bench
