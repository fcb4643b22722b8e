// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/sparse_factor.h"
#include "solver/springs.h"
#include "solver/volumes.h"

#include <memory>
#include <vector>

namespace limber {

/// The matrix of the local/global iterations of the implicit midpoint rule and its factor
/// (Liu, Bargteil, O'Brien, Kavan 2013, equation 14, for substeps h of the midpoint rule):
///
///     A = M + sum over springs (h^2/4 k + h/2 c (1 + beta)) (e_a - e_b)(e_a - e_b)^T,  #points x #points,
///
/// and over the tetrahedra, whose volumes' change  sum g_i . u_i = sum g_i . (u_i - u_j)  has for any corner
/// j a square of at most  sum_(i not j) |g_i|^2  times  sum_i |u_i - u_j|^2:  the mean over the four of
///
///     h^2/4 K/V0 sum_(i not j) |g_i|^2  sum_i (e_i - e_j)(e_i - e_j)^T,   g at rest;
///
/// an upper bound in all directions of the stiffness and damping, so that iterating with it converges. The
/// same for x, y and z and whatever the deformation: all bodies of a network with equal springs and masses
/// share it. Rows and columns of held points are those of the unit matrix.
struct SharedFactor {
  Eigen::SparseMatrix<double> matrix;  ///< A
  SparseFactor factor;

  /// Solves A x = b in place for all three coordinates; `scratch` is 3 x #points.
  void solve(Points& b, Points& scratch) const;
};

/// What a body's shape is kept by.
struct ElasticParts {
  const SpringArrays& springs;
  const TetrahedronVolumes* tetrahedra = nullptr;  ///< may be nullptr
};

/// A for substeps of h seconds.
Eigen::SparseMatrix<double> midpointMatrix(const ElasticParts& parts, const Points& inverseMass, double h);

/// Factors that bodies use, each made once. Allocates when a matrix is new.
class SharedFactors {
 public:
  std::shared_ptr<const SharedFactor> get(Eigen::SparseMatrix<double> matrix);

 private:
  std::vector<std::weak_ptr<const SharedFactor>> known_;
};

}  // namespace limber
