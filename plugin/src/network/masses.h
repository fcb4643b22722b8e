// SPDX-License-Identifier: Zlib
// Declares the moments of solids and the distribution of a body's mass over its points.
#pragma once

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

/// If the volume is 0, centre and second moments are not finite.
SolidMoments solidMoments(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& surface);

/// Returns the mass fractions of the points by `rule`, sum 1. Area limits them to the range from a fifth to
/// ten times the mean. Moments computes the fractions nearest to Area's that have the centre and inertia of
/// the solid. They are at least a fifth of the mean and, for points of the surface, at most ten times the
/// mean. If there are none, it computes the fractions with the smallest error of the inertia: masses that lie
/// on a round surface alone always have more inertia than the solid, which only points inside can correct. In
/// Area and Moments, points of no triangle count as mean ones. For a surface that is not closed, Moments
/// returns Area's fractions.
std::vector<double> massFractions(MassRule rule, const std::vector<Eigen::Vector3d>& points,
                                  const std::vector<Triangle>& surface);

/// Mass, first moments (3), second moments (6), about the solid's centre in units of its radius of gyration.
using MomentVector = Eigen::Matrix<double, 10, 1>;

/// The quadratic programme that MassRule::Moments solves:
///     min  1/2 sum (x_i - w_i)^2 / w_i   with  sum x_i A_i = t,  l_i <= x_i <= m_i
struct MassProgramme {
  std::vector<MomentVector> rows;    ///< A, #points: the moments of a mass of 1 at a point
  MomentVector target;               ///< t, the solid's moments
  std::vector<double> desired;       ///< w, #points: Area's fractions
  std::vector<double> minFractions;  ///< l, #points
  std::vector<double> maxFractions;  ///< m, #points
};
MassProgramme massProgramme(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& surface,
                            const SolidMoments& solid);

/// The solution of a programme. If there is none, the fractions with the smallest error of the moments; the
/// first moments count far more than the second.
struct MassMatch {
  std::vector<double> fractions;  ///< x, #points, sum 1
  MomentVector multipliers;       ///< of the equations; they grow without limit if there is no solution
  MomentVector misfit;            ///< sum x_i A_i - t, before the fractions were divided by their sum
};
MassMatch matchMoments(const MassProgramme& programme);

/// Weights of the squared misfits are the inverse of these.
MomentVector momentRegularisation();

/// Misfits below this count as zero.
constexpr double kExactMoments = 1e-10;

}  // namespace limber
