// SPDX-License-Identifier: Zlib
#include "cook/point_spread.h"

#include <Eigen/Eigenvalues>

namespace limber {
namespace {

constexpr double kThin = 1e-4;

}  // namespace

NetworkKind spreadOf(const std::vector<Eigen::Vector3d>& points) {
  const auto count = static_cast<Eigen::Index>(points.size());
  if (count < 3) return NetworkKind::Rope;
  Eigen::Matrix3Xd arms(3, count);
  for (Eigen::Index i = 0; i < count; ++i) arms.col(i) = points[static_cast<std::size_t>(i)];
  arms.colwise() -= arms.rowwise().mean().eval();
  const double size = arms.cwiseAbs().maxCoeff();
  if (size > 0.0) arms /= size;
  const Eigen::Matrix3d scatter = arms * arms.transpose();
  const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors();
  const Eigen::Vector3d reach = (axes.transpose() * arms).cwiseAbs().rowwise().maxCoeff();  // thinnest first
  const double thin = kThin * arms.colwise().norm().maxCoeff();
  if (reach[1] <= thin) return NetworkKind::Rope;
  return reach[0] <= thin ? NetworkKind::Cloth : NetworkKind::Solid;
}

}  // namespace limber
