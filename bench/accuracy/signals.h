// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

namespace limber::bench {

/// A signal sampled once per tick. Between the samples it is the polynomial of degree 5 through the nearest
/// six: at 15 samples a period that is good to 1e-7 of a period.
struct Signal {
  double dt = 0.0;
  std::vector<double> samples;

  double at(double t) const;
  double end() const { return dt * static_cast<double>(samples.size() - 1); }
};

/// Where the signal falls through zero.
std::vector<double> fallsThroughZero(const Signal& signal);

/// Mean distance of its falls through zero; infinite when there are fewer than two.
double period(const Signal& signal);

/// Largest magnitude in [from, to].
double amplitude(const Signal& signal, double from, double to);

/// The first time after `from` at which it passes `level`, or infinity.
double firstReaches(const Signal& signal, double level, double from = 0.0);

/// The slope of log(error) over log(step) by least squares; errors that are not finite and positive are left
/// out. NaN with fewer than two.
double order(const std::vector<double>& steps, const std::vector<double>& errors);

}  // namespace limber::bench
