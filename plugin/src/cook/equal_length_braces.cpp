// SPDX-License-Identifier: Zlib
#include "cook/equal_length_braces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace limber {
namespace {

/// Lengths that differ by less than this part are equal: far above the rounding of the floats that mesh files
/// hold, far below the differences that a modeller makes on purpose.
constexpr double kEqualLength = 1e-5;

struct Interval {
  double low;
  double high;
};

/// The squared distances that equal the length of some edge, as disjoint ascending intervals.
std::vector<Interval> squaredLengths(const std::vector<Eigen::Vector3d>& points,
                                     const std::vector<Edge>& edges) {
  std::vector<double> lengths;
  lengths.reserve(edges.size());
  for (const Edge& edge : edges) lengths.push_back((points[edge[0]] - points[edge[1]]).norm());
  std::sort(lengths.begin(), lengths.end());

  std::vector<Interval> intervals;
  for (const double length : lengths) {
    const double low = length * (1.0 - kEqualLength), high = length * (1.0 + kEqualLength);
    if (!intervals.empty() && low * low <= intervals.back().high) {
      intervals.back().high = high * high;
    } else {
      intervals.push_back({low * low, high * high});
    }
  }
  return intervals;
}

bool contains(const std::vector<Interval>& intervals, double value) {
  const auto next = std::lower_bound(intervals.begin(), intervals.end(), value,
                                     [](const Interval& interval, double v) { return interval.high < v; });
  return next != intervals.end() && next->low <= value;
}

/// The points sorted along the axis in which the body is longest: there a window of the longest edge is
/// shortest.
std::vector<std::uint32_t> sortAlongLongestAxis(const std::vector<Eigen::Vector3d>& points,
                                                Eigen::Index& axis) {
  Eigen::Vector3d low = points.front(), high = points.front();
  for (const Eigen::Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  (high - low).maxCoeff(&axis);
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return points[i][axis] != points[j][axis] ? points[i][axis] < points[j][axis] : i < j;
  });
  return order;
}

}  // namespace

std::vector<Edge> findEqualLengthPairs(const std::vector<Eigen::Vector3d>& points,
                                       const std::vector<Edge>& edges) {
  std::vector<Edge> pairs;
  if (edges.empty()) return pairs;
  const std::vector<Interval> lengths = squaredLengths(points, edges);
  const double reach = std::sqrt(lengths.back().high);
  Eigen::Index axis = 0;
  const std::vector<std::uint32_t> order = sortAlongLongestAxis(points, axis);

  for (std::size_t i = 0; i < order.size(); ++i) {
    const Eigen::Vector3d& p = points[order[i]];
    for (std::size_t j = i + 1; j < order.size() && points[order[j]][axis] - p[axis] <= reach; ++j) {
      if (!contains(lengths, (points[order[j]] - p).squaredNorm())) continue;
      const Edge pair{std::min(order[i], order[j]), std::max(order[i], order[j])};
      if (!std::binary_search(edges.begin(), edges.end(), pair)) pairs.push_back(pair);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace limber
