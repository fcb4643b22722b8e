// SPDX-License-Identifier: Zlib
#include "cook/point_spread.h"

#include "solver/linear_algebra.h"

namespace limber {
namespace {

constexpr double kThinSpread = 1e-4;

/// The points about their centre in units of their size, and their principal axes, the thinnest first.
struct Spread {
  double size = 0.0;
  Eigen::Matrix3Xd arms;
  Eigen::Matrix3d axes;
};

Spread principalSpread(const std::vector<Eigen::Vector3d>& points) {
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix3Xd arms(3, count);
  for (Eigen::Index i = 0; i < count; ++i) arms.col(i) = points[static_cast<std::size_t>(i)];
  arms.colwise() -= arms.rowwise().mean().eval();
  const double size = arms.cwiseAbs().maxCoeff();
  if (size > 0.0) arms /= size;
  const Eigen::Matrix3d scatter = arms * arms.transpose();
  return {size, arms, symmetricParts3(scatter).vectors};
}

}  // namespace

NetworkKind spreadOf(const std::vector<Eigen::Vector3d>& points) {
  if (points.size() < 3) return NetworkKind::Rope;
  const Spread s = principalSpread(points);
  const Eigen::Vector3d reach = (s.axes.transpose() * s.arms).cwiseAbs().rowwise().maxCoeff();
  const double thin = kThinSpread * s.arms.colwise().norm().maxCoeff();
  if (reach[1] <= thin) return NetworkKind::Rope;
  return reach[0] <= thin ? NetworkKind::Cloth : NetworkKind::Solid;
}

std::vector<Eigen::Vector3d> flattened(std::vector<Eigen::Vector3d> points, NetworkKind kind) {
  if (points.empty() || kind == NetworkKind::Solid) return points;
  const Spread s = principalSpread(points);
  const Eigen::Index thinAxes = kind == NetworkKind::Rope ? 2 : 1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d arm = s.size * s.arms.col(static_cast<Eigen::Index>(i));
    for (Eigen::Index k = 0; k < thinAxes; ++k) points[i] -= s.axes.col(k).dot(arm) * s.axes.col(k);
  }
  return points;
}

}  // namespace limber
