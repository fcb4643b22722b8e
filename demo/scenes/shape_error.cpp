// SPDX-License-Identifier: Zlib
#include "scenes/shape_error.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cmath>
#include <limits>

namespace limber::scenes {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Eigen::Vector3d meanOf(const Points& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

Eigen::Matrix3d correlation(const Points& rest, const Points& now) {
  const Eigen::Vector3d restMean = meanOf(rest);
  const Eigen::Vector3d nowMean = meanOf(now);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < rest.size(); ++i) sum += (now[i] - nowMean) * (rest[i] - restMean).transpose();
  return sum;
}

double rmsAfter(const Eigen::Matrix3d& rotation, const Points& rest, const Points& now) {
  const Eigen::Vector3d restMean = meanOf(rest);
  const Eigen::Vector3d nowMean = meanOf(now);
  double sum = 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    sum += (now[i] - nowMean - rotation * (rest[i] - restMean)).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(rest.size()));
}

}  // namespace

double sizeOf(const Points& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  return box.sizes().maxCoeff();
}

ShapeError shapeError(const Points& rest, const Points& now) {
  const Eigen::Matrix3d c = correlation(rest, now);
  if (!c.allFinite()) return {std::numeric_limits<double>::infinity(), false};
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(c, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // R = U diag(1, 1, d) V^T with d = det(U V^T) maximises trace(R^T C) over rotations
  const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d signs(1.0, 1.0, handedness);
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return {rmsAfter(rotation, rest, now) / sizeOf(rest), handedness < 0.0};
}

Points restShape(const SoftBody& body) {
  Points rest = body.network().restPoints;
  for (Eigen::Vector3d& p : rest) p = p.cwiseProduct(body.settings().scale);
  return rest;
}

ShapeError shapeError(const SoftBody& body) {
  Points now;
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) now.push_back(body.position(i));
  return shapeError(restShape(body), now);
}

}  // namespace limber::scenes
