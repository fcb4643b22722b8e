// SPDX-License-Identifier: Zlib
#include "solver/kept_volume_bound.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Of the shortest edge at rest: motion against each other that is no change of shape. It makes the bound
/// of a cube half a per cent larger.
constexpr double kSlack = 2e-4;

/// m, how far a point has moved against the others since the shape was kept, and may move in the tick.
double shapeChange(const Points& kept, const PointState& state, double tick) {
  const Vector3d moved = (state.position - kept).rowwise().mean();
  const Vector3d velocity = state.velocity.rowwise().mean();
  double change = 0.0, speed = 0.0;
  for (Eigen::Index i = 0; i < kept.cols(); ++i) {
    change = std::max(change, (state.position.col(i) - kept.col(i) - moved).squaredNorm());
    speed = std::max(speed, (state.velocity.col(i) - velocity).squaredNorm());
  }
  return std::sqrt(change) + tick * std::sqrt(speed);
}

}  // namespace

double keptVolumeBoundSquared(VolumeArrays& v, const PointState& state, double tick) {
  if (v.empty()) return 0.0;
  const double slack = kSlack * v.shortestEdge;
  if (v.kept.value > 0.0 && shapeChange(v.kept.shape, state, tick) <= slack) return v.kept.value;
  const double bound = volumeFrequencyBoundSquared(v, state, tick, slack);
  v.kept.shape = state.position;
  v.kept.value = v.restless ? 0.0 : bound;
  return bound;
}

}  // namespace limber
