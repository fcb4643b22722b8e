// SPDX-License-Identifier: Zlib
#include "cook/relaxed_body.h"

#include "cook/network_pieces.h"
#include "cook/triangle_geometry.h"

#include <Eigen/Dense>

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

/// Squared distances, summed, after the best rigid motion: with the singular values s of the covariance,
///     sum |x|^2 + |y|^2 - 2 (s0 + s1 +- s2),  minus where the best map would be a reflection.
double squaredDistance(const Points& a, const Points& b) {
  const Points x = a.colwise() - a.rowwise().mean(), y = b.colwise() - b.rowwise().mean();
  const Eigen::Matrix3d covariance = x * y.transpose();
  const Eigen::Vector3d s = Eigen::JacobiSVD<Eigen::Matrix3d>(covariance).singularValues();
  const double sign = covariance.determinant() < 0.0 ? -1.0 : 1.0;
  return std::max(0.0, x.squaredNorm() + y.squaredNorm() - 2.0 * (s[0] + s[1] + sign * s[2]));
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
