// SPDX-License-Identifier: Zlib
#include "cook/relaxed_body.h"

#include "cook/network_pieces.h"
#include "cook/triangle_geometry.h"
#include "solver/linear_algebra.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace limber {
namespace {

SoftBodySettings unitSettings(double size) {
  SoftBodySettings settings;
  settings.scale.setConstant(size > 0.0 ? 1.0 / size : 1.0);
  settings.extensionStiffness = settings.compressionStiffness = 1.0;
  settings.damping = 0.0;
  return settings;
}

Points restPointsOf(const SpringNetwork& network) {
  Points rest(3, static_cast<Eigen::Index>(network.restPoints.size()));
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    rest.col(i) = network.restPoints[static_cast<std::size_t>(i)];
  return rest;
}

/// The most that the trace of a rotation times C can be: the largest eigenvalue of a symmetric matrix whose
/// eigenvector is the rotation's quaternion (B. Horn, "Closed-form solution of absolute orientation using unit
/// quaternions", 1987).
double largestTrace(const Eigen::Matrix3d& c) {
  const Eigen::Vector3d twist(c(1, 2) - c(2, 1), c(2, 0) - c(0, 2), c(0, 1) - c(1, 0));
  Eigen::MatrixXd m(4, 4);
  m(0, 0) = c.trace();
  m.block<3, 1>(1, 0) = twist;
  m.block<1, 3>(0, 1) = twist.transpose();
  m.block<3, 3>(1, 1) = c + c.transpose() - c.trace() * Eigen::Matrix3d::Identity();
  return symmetricValues(m)[3];
}

/// Squared distances, summed, after the best rigid motion:  sum |x|^2 + |y|^2 - 2 x . R y.
double squaredDistance(const Points& a, const Points& b) {
  const Points x = a.colwise() - a.rowwise().mean(), y = b.colwise() - b.rowwise().mean();
  const Eigen::Matrix3d covariance = x * y.transpose();
  return std::max(0.0, x.squaredNorm() + y.squaredNorm() - 2.0 * largestTrace(covariance));
}

}  // namespace

RelaxedBody::RelaxedBody(const SpringNetwork& network) : rest(restPointsOf(network)) {
  const SoftBodySettings settings = unitSettings(extent(rest));
  rest *= settings.scale.x();
  terms = BodyTerms(network, settings);
  pieces = findPieces(network);
}

double distanceToRest(const RelaxedBody& body, const Points& x) {
  if (!x.allFinite()) return std::numeric_limits<double>::infinity();
  double sum = 0.0;
  for (const std::vector<Eigen::Index>& piece : body.pieces)
    sum += squaredDistance(body.rest(Eigen::all, piece), x(Eigen::all, piece));
  return std::sqrt(sum / static_cast<double>(x.cols()));
}

}  // namespace limber
