// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh.h>
#include <limber/network_builder.h>

#include <Eigen/Core>

#include <vector>

/// Mass fractions of the points of a body, and the errors of their moments, for tests and bench.
namespace limber::test {

struct MassFractions {
  std::vector<double> shares;  ///< #points, above 0, sum 1

  // Relative to the uniform solid inside the surface; NaN if the surface is not closed.
  double centreError = 0.0;   ///< distance of the centres of mass over the size of the body
  double inertiaError = 0.0;  ///< Frobenius norm of the inertia tensors' difference over the solid's

  /// For MassRule::Moments: a proven lower bound of the distance of the moments of any shares from the
  /// solid's. They are the mass and the first and second moments about the solid's centre, in units of its
  /// radius of gyration. Above 0 there is no solution.
  double leastMisfit = 0.0;         ///< with shares within the bounds
  double leastMisfitAnyMass = 0.0;  ///< with any shares of 0 or more: caused by the points, not by the bounds
};

MassFractions shareMass(MassRule rule, const std::vector<Eigen::Vector3d>& points,
                        const std::vector<Triangle>& surface);

}  // namespace limber::test
