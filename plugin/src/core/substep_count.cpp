// SPDX-License-Identifier: Zlib
#include "core/substep_count.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Of Verlet's stability limit omega dt = 2. The bound on omega is exact only for a single spring; there this
/// share still keeps the discrete oscillation away from the limit, where its amplitude grows without bound.
constexpr double kLargestPhaseStep = 0.9 * 2.0;

}  // namespace

double frequencyBoundSquared(const SpringArrays& springs, const Points& inverseMass,
                             std::vector<double>& stiffnessSums) {
  stiffnessSums.assign(static_cast<std::size_t>(inverseMass.cols()), 0.0);
  const auto stiffness = [&](std::size_t s) {
    return std::max(springs.extensionStiffness[s], springs.compressionStiffness[s]);
  };
  for (std::size_t s = 0; s < springs.size(); ++s) {
    stiffnessSums[springs.a[s]] += stiffness(s);
    stiffnessSums[springs.b[s]] += stiffness(s);
  }
  double bound = 0.0;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto rowPart = [&](std::uint32_t i) { return inverseMass.col(i).maxCoeff() * stiffnessSums[i]; };
    bound = std::max(bound, rowPart(springs.a[s]) + rowPart(springs.b[s]));
  }
  return bound;
}

int substepCount(double frequencySquared, double tick, const Stepping& settings) {
  const double phase = std::sqrt(frequencySquared) * tick;
  const double largestStep = std::min(kLargestPhaseStep, std::sqrt(24.0 * settings.periodTolerance));
  const double needed = std::ceil(phase / largestStep);
  return std::max(settings.atLeast, static_cast<int>(std::min(needed, 1e9)));
}

}  // namespace limber
