// SPDX-License-Identifier: Zlib
#include "cook/energy_descent.h"

#include "solver/springs.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace limber {
namespace {

constexpr std::size_t kMemory = 8;       // pairs of steps and changes of the force
constexpr std::size_t kArrivedEach = 8;  // iterations between two questions whether it has arrived
constexpr double kSufficient = 1e-4;     // Armijo's share of the decrease that the slope promises
constexpr int kMostHalvings = 30;

/// A step and by how much the gradient changed over it.
struct DescentPair {
  Points step, change;
  double curvature = 0.0;  ///< step . change, above 0
};

/// The two-loop recursion: minus the inverse Hessian that the pairs make, times the gradient.
Points direction(const std::vector<DescentPair>& pairs, const Points& gradient) {
  Points d = -gradient;
  std::vector<double> share(pairs.size());
  for (std::size_t i = pairs.size(); i-- > 0;) {
    share[i] = dot(pairs[i].step, d) / pairs[i].curvature;
    d -= share[i] * pairs[i].change;
  }
  if (!pairs.empty()) d *= pairs.back().curvature / pairs.back().change.squaredNorm();
  for (std::size_t i = 0; i < pairs.size(); ++i)
    d += (share[i] - dot(pairs[i].change, d) / pairs[i].curvature) * pairs[i].step;
  return d;
}

void remember(std::vector<DescentPair>& pairs, Points step, Points change) {
  const double curvature = dot(step, change);
  if (curvature <= 1e-12 * std::sqrt(step.squaredNorm() * change.squaredNorm())) return;
  if (pairs.size() == kMemory) pairs.erase(pairs.begin());
  pairs.push_back({std::move(step), std::move(change), curvature});
}

Points gradientAt(SteppedBody& body) {
  computeElasticForces(body);
  return -body.points->force;
}

/// Halves the step until the energy falls enough; 0 if it never does.
double search(SteppedBody& body, const Points& from, const Points& d, double slope, double& energy) {
  double step = 1.0;
  for (int i = 0; i < kMostHalvings; ++i, step *= 0.5) {
    body.points->position = from + step * d;
    const double there = elasticEnergy(body, body.points->position);
    if (there > energy + kSufficient * step * slope) continue;
    energy = there;
    return step;
  }
  body.points->position = from;
  return 0.0;
}

}  // namespace

void descend(SteppedBody& body, double leastForce, std::size_t iterations,
             const std::function<bool(const Points&)>& arrived) {
  std::vector<DescentPair> pairs;
  Points gradient = gradientAt(body);
  double energy = elasticEnergy(body, body.points->position);
  for (std::size_t i = 0; i < iterations; ++i) {
    if (gradient.cwiseAbs().maxCoeff() < leastForce) return;
    if (i % kArrivedEach == 0 && arrived(body.points->position)) return;
    Points d = direction(pairs, gradient);
    double slope = dot(d, gradient);
    if (slope >= 0.0) pairs.clear(), d = -gradient, slope = -gradient.squaredNorm();
    const Points from = body.points->position;
    if (search(body, from, d, slope, energy) == 0.0) {
      if (pairs.empty()) return;  // as low as rounding lets it
      pairs.clear();
      continue;
    }
    const Points earlier = gradient;
    gradient = gradientAt(body);
    remember(pairs, body.points->position - from, gradient - earlier);
  }
}

}  // namespace limber
