// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <functional>

namespace limber {

/// A symmetric matrix as what it does to a vector.
using SymmetricOperator = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

/// The largest eigenvalue (algebraically) of a symmetric matrix of `size` rows, by Lanczos iteration with
/// full orthogonalisation from a seeded start, to a residual of `tolerance` times the eigenvalue; its error
/// is about the square of that (Parlett 1998, chapter 11). 0 for no rows.
double largestEigenvalue(const SymmetricOperator& multiply, Eigen::Index size, double tolerance = 1e-5);

}  // namespace limber
