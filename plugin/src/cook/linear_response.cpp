// SPDX-License-Identifier: Zlib
#include "cook/linear_response.h"

#include "solver/linear_algebra.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Triplets = std::vector<Eigen::Triplet<double>>;

/// Of the largest diagonal entry, added to the diagonal: rigid motions, which the forces do not excite, would
/// make the matrix singular. The softest modes of solids have 1e-5 of it and more.
constexpr double kShift = 1e-10;

MatrixXd scaledPoints(const ElasticBody& body) {
  MatrixXd points(3, static_cast<Index>(body.network.restPoints.size()));
  for (Index i = 0; i < points.cols(); ++i)
    points.col(i) = body.network.restPoints[static_cast<std::size_t>(i)].cwiseProduct(body.scale);
  return points;
}

/// The lower half of the block of points i and j, or all of it below the diagonal.
void addBlock(Triplets& triplets, Index i, Index j, const Matrix3d& block) {
  for (Index r = 0; r < 3; ++r)
    for (Index c = 0; c < 3; ++c)
      if (3 * i + r >= 3 * j + c) triplets.emplace_back(3 * i + r, 3 * j + c, block(r, c));
}

/// Springs without tension: k n n^T along their directions n.
void addSprings(const ElasticBody& body, const MatrixXd& points, Triplets& triplets) {
  for (const NetworkSpring& s : body.network.springs) {
    const Index a = s.a, b = s.b;
    const Vector3d n = (points.col(b) - points.col(a)).normalized();
    const Matrix3d block = body.stiffness * s.stiffnessScale * n * n.transpose();
    addBlock(triplets, a, a, block);
    addBlock(triplets, b, b, block);
    addBlock(triplets, b, a, -block);
  }
}

/// At rest the volume term K/2 (V - V0)^2 / V0 of a tetrahedron has the Hessian K/V0 g g^T, g the gradient
/// of its volume: a third of the opposite face's area vector for each corner, pointing at it.
void addTetrahedra(const ElasticBody& body, const MatrixXd& points, Triplets& triplets) {
  for (const Tetrahedron& t : body.network.tetrahedra) {
    const Vector3d a = points.col(t[0]), b = points.col(t[1]) - a, c = points.col(t[2]) - a,
                   d = points.col(t[3]) - a;
    std::array<Vector3d, 4> g{Vector3d::Zero(), c.cross(d) / 6.0, d.cross(b) / 6.0, b.cross(c) / 6.0};
    g[0] = -(g[1] + g[2] + g[3]);
    const double factor = body.volumeModulus / std::abs(b.dot(g[1]));
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        if (t[i] >= t[j]) addBlock(triplets, t[i], t[j], factor * g[i] * g[j].transpose());
  }
}

/// The same for the whole inside of the surface.
MatrixXd surfaceGradient(const ElasticBody& body, const MatrixXd& points) {
  MatrixXd gradient = MatrixXd::Zero(points.size(), 1);
  for (const Triangle& t : body.network.surface) {
    const Vector3d a = points.col(t[0]), b = points.col(t[1]), c = points.col(t[2]);
    for (const std::uint32_t corner : t) gradient.block<3, 1>(3 * corner, 0) += (b - a).cross(c - a) / 6.0;
  }
  // the volume is a homogeneous function of third degree (Euler)
  const double volume = std::abs(gradient.col(0).dot(points.reshaped())) / 3.0;
  return gradient * std::sqrt(body.volumeModulus / volume);
}

}  // namespace

LinearResponse::LinearResponse(const ElasticBody& body) : points_(scaledPoints(body)) {
  Triplets triplets;
  addSprings(body, points_, triplets);
  if (body.volumeModulus > 0.0) addTetrahedra(body, points_, triplets);
  Eigen::SparseMatrix<double> stiffness(points_.size(), points_.size());
  stiffness.setFromTriplets(triplets.begin(), triplets.end());
  const double shift = kShift * stiffness.diagonal().maxCoeff();
  for (Index i = 0; i < points_.size(); ++i) stiffness.coeffRef(i, i) += shift;
  factor_ = factorise(stiffness);
  if (body.volumeModulus <= 0.0 || !body.network.tetrahedra.empty()) return;
  volumeGradient_ = surfaceGradient(body, points_);
  volumeAnswer_ = solve(factor_, volumeGradient_);
}

/// With a term of rank one by the formula of Sherman and Morrison, which keeps the matrix sparse.
MatrixXd LinearResponse::displacements(const MatrixXd& forces) const {
  MatrixXd u = solve(factor_, forces);
  if (volumeGradient_.size() == 0) return u;
  const double own = volumeGradient_.col(0).dot(volumeAnswer_.col(0));
  return u - product(volumeAnswer_, transposedProduct(volumeGradient_, u)) / (1.0 + own);
}

}  // namespace limber
