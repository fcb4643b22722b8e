// SPDX-License-Identifier: Zlib
#include "sample_stats.h"

#include <algorithm>
#include <numeric>

namespace limber::bench {

double sum(const std::vector<double>& samples) {
  return std::accumulate(samples.begin(), samples.end(), 0.0);
}

double mean(const std::vector<double>& samples) {
  return samples.empty() ? 0.0 : sum(samples) / static_cast<double>(samples.size());
}

double largest(const std::vector<double>& samples) {
  return samples.empty() ? 0.0 : *std::max_element(samples.begin(), samples.end());
}

double median(std::vector<double> samples) {
  if (samples.empty()) return 0.0;
  std::sort(samples.begin(), samples.end());
  const std::size_t upper = samples.size() / 2, lower = (samples.size() - 1) / 2;
  return 0.5 * (samples[lower] + samples[upper]);
}

double halfMiddle(std::vector<double> samples) {
  if (samples.empty()) return 0.0;
  std::sort(samples.begin(), samples.end());
  const std::size_t quarter = samples.size() / 4;
  return 0.5 * (samples[samples.size() - 1 - quarter] - samples[quarter]);
}

}  // namespace limber::bench
