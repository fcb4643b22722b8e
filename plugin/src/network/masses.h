// SPDX-License-Identifier: Zlib
// Declares the moments of solids and the distribution of a body's mass over its points.
#pragma once

#include <limber/mesh.h>
#include <limber/network_builder.h>

#include <Eigen/Core>

#include <vector>

namespace limber {

/// Moments of the inside of a closed surface, filled evenly with a mass of 1.
struct SolidMoments {
  double volume = 0.0;                               ///< m^3, negative if the surface faces inward
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< m^2, about the centre
};

/// #points is the number of columns. If the volume is 0, centre and second moments are not finite.
SolidMoments solidMoments(const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                          const std::vector<Triangle>& surface);

/// Mass fractions of the points of a body, and the errors of their moments.
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

/// Computes the shares by `rule`. Area limits them to the range from a fifth to ten times the mean share.
/// Moments computes the shares nearest to Area's that have the centre and inertia of the solid. They are at
/// least a fifth of the mean share and, for points of the surface, at most ten times the mean share. If there
/// are none, it computes the shares with the smallest error of the inertia: masses that lie on a round
/// surface alone always have more inertia than the solid, which only points inside can correct. In Area and
/// Moments, points of no triangle count as mean ones. For a surface that is not closed, Moments returns
/// Area's shares.
MassFractions shareMass(MassRule rule, const std::vector<Eigen::Vector3d>& points,
                        const std::vector<Triangle>& surface);

}  // namespace limber
