// SPDX-License-Identifier: Zlib
#include "cook/stiffness_matrix.h"

#include "solver/linear_algebra.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Relative to the largest distance from the centre; points nearer to a line than this are on it: meshes come
/// in single precision.
constexpr double kOnLine = 1e-6;

}  // namespace

SparseMatrix rigidityMatrix(const SpringNetwork& network) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(6 * network.springs.size());
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const NetworkSpring& spring = network.springs[s];
    const Eigen::Vector3d d = network.restPoints[spring.b] - network.restPoints[spring.a];
    const Eigen::Vector3d row = std::sqrt(spring.stiffnessScale) * d.stableNormalized();
    if (row.isZero(0.0)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      entries.emplace_back(static_cast<int>(s), 3 * static_cast<int>(spring.a) + axis, -row[axis]);
      entries.emplace_back(static_cast<int>(s), 3 * static_cast<int>(spring.b) + axis, row[axis]);
    }
  }
  SparseMatrix rigidity(static_cast<Eigen::Index>(network.springs.size()),
                        3 * static_cast<Eigen::Index>(network.restPoints.size()));
  rigidity.setFromTriplets(entries.begin(), entries.end());
  return rigidity;
}

SparseMatrix stiffnessMatrix(const SparseMatrix& rigidity) {
  const SparseMatrix transposed = rigidity.transpose();
  return transposed * rigidity;
}

Eigen::MatrixXd rigidMotions(const std::vector<Eigen::Vector3d>& points) {
  const auto count = static_cast<Eigen::Index>(points.size());
  if (points.empty()) return Eigen::MatrixXd(0, 0);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) centre += p / static_cast<double>(count);
  Eigen::Matrix3Xd arms(3, count);
  for (Eigen::Index i = 0; i < count; ++i) arms.col(i) = points[static_cast<std::size_t>(i)] - centre;
  const double size = arms.cwiseAbs().maxCoeff();
  if (size > 0.0) arms /= size;

  // About the principal axes of the points the rotations are orthogonal to each other, and that about the
  // line of points on a line is the last one, and zero.
  const Eigen::Matrix3d scatter = arms * arms.transpose();
  const Eigen::Matrix3d axes = symmetricParts3(scatter).vectors;
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(3 * count, 6);
  Eigen::Index columns = 3;
  for (Eigen::Index i = 0; i < count; ++i)
    motions.block<3, 3>(3 * i, 0) = Eigen::Matrix3d::Identity() / std::sqrt(static_cast<double>(count));
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d about = axes.col(axis);
    auto rotation = motions.col(columns);
    double reach = 0.0;
    for (Eigen::Index i = 0; i < count; ++i) {
      rotation.segment<3>(3 * i) = about.cross(Eigen::Vector3d(arms.col(i)));
      reach = std::max(reach, rotation.segment<3>(3 * i).norm());
    }
    if (reach < kOnLine) continue;
    rotation.normalize();
    ++columns;
  }
  return motions.leftCols(columns);
}

}  // namespace limber
