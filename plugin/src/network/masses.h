// SPDX-License-Identifier: Zlib
// Declares the moments of solids and how the mass of a body is shared among its points.
#pragma once

#include <limber/network_builder.h>
#include <limber/triangle_mesh.h>

#include <Eigen/Core>

#include <vector>

namespace limber {

/// Of what a closed surface encloses, filled evenly with a mass of 1.
struct SolidMoments {
  double volume = 0.0;                               ///< m^3, below 0 where the surface faces inward
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< m^2, about the centre
};

/// #points is the number of columns. Neither centre nor second moments are finite where the volume is 0.
SolidMoments solidMoments(const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                          const std::vector<Triangle>& surface);

/// Each point's share of the mass of a body, and how well they stand for the solid.
struct MassFractions {
  std::vector<double> shares;  ///< #points, above 0, sum 1

  // Against the uniform solid inside the surface; NaN if the surface is not closed.
  double centreError = 0.0;   ///< distance of the centres of mass over the size of the body
  double inertiaError = 0.0;  ///< Frobenius norm of the inertia tensors' difference over the solid's

  /// For Moments, of the mass, first and second moments about the solid's centre in units of its radius of
  /// gyration: proven distance from the solid's below which no shares come. Above 0 there is no solution.
  double leastMisfit = 0.0;         ///< with shares within the bounds
  double leastMisfitAnyMass = 0.0;  ///< with any shares of 0 or more: for want of points, not of range
};

/// Shares by `rule`. Area bounds them to a fifth and ten times the mean share. Moments takes the shares
/// nearest to Area's, of at least a fifth of the mean share, and at most ten for points of the surface, that
/// have the centre and inertia of the solid, or, where there are none, those whose inertia errs least: masses
/// that lie on a round surface alone have more inertia than the solid however they are shared; it takes
/// points inside to match it. Points of no triangle count as mean ones for Area and Moments. A surface that
/// is not closed has Area's shares for Moments.
MassFractions shareMass(MassRule rule, const std::vector<Eigen::Vector3d>& points,
                        const std::vector<Triangle>& surface);

}  // namespace limber
