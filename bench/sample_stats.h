// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

namespace limber::bench {

// All give 0 where there is no sample.
double sum(const std::vector<double>& samples);
double mean(const std::vector<double>& samples);
double largest(const std::vector<double>& samples);

/// The middle one; of an even number the mean of the two in the middle.
double median(std::vector<double> samples);

/// Half of the range that the middle half of the samples takes.
double halfMiddle(std::vector<double> samples);

}  // namespace limber::bench
