// SPDX-License-Identifier: Zlib
#include "support/mass_errors.h"

#include "mesh/surface.h"
#include "network/masses.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limber::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Returns the smallest distance, along a direction, by which the moments of all shares within the bounds lie
/// beyond the target's. These moments fill a convex body. A plane with the body on one side and the target on
/// the other proves (Farkas' lemma) that no shares have the target's moments. The check needs one sum.
double separation(const MassProgramme& p, const MomentVector& direction) {
  double distance = -p.target.dot(direction);
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    const double along = p.rows[i].dot(direction);
    distance += along * (along > 0.0 ? p.minFractions[i] : p.maxFractions[i]);
  }
  return distance / direction.norm();
}

/// Returns a proven misfit. The multipliers of a problem without solution grow along a separating direction,
/// and the remaining weighted misfit points along one too.
double provenMisfit(const MassProgramme& p, const MassMatch& match) {
  if (match.misfit.cwiseAbs().maxCoeff() <= kExactMoments) return 0.0;
  const MomentVector weighted = match.misfit.cwiseQuotient(momentRegularisation());
  double proven = 0.0;
  for (const MomentVector& direction : {MomentVector(-match.multipliers), weighted})
    if (direction.norm() > 0.0) proven = std::max(proven, separation(p, direction));
  return proven;
}

Matrix3d inertia(const Matrix3d& second) { return second.trace() * Matrix3d::Identity() - second; }

}  // namespace

MassFractions shareMass(MassRule rule, const std::vector<Vector3d>& points,
                        const std::vector<Triangle>& surface) {
  MassFractions result;
  result.shares = massFractions(rule, points, surface);
  result.centreError = result.inertiaError = std::numeric_limits<double>::quiet_NaN();
  if (surface.empty() || !findEdgeDefects(surface).none()) return result;
  const SolidMoments solid = solidMoments(points, surface);
  if (!(std::abs(solid.volume) > 0.0) || !(solid.second.trace() > 0.0)) return result;

  if (rule == MassRule::Moments) {
    MassProgramme p = massProgramme(points, surface, solid);
    result.leastMisfit = provenMisfit(p, matchMoments(p));
    p.minFractions.assign(p.minFractions.size(), 0.0);
    p.maxFractions.assign(points.size(), 1.0);
    if (result.leastMisfit > 0.0) result.leastMisfitAnyMass = provenMisfit(p, matchMoments(p));
  }
  Vector3d centre = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) centre += result.shares[i] * points[i];
  for (std::size_t i = 0; i < points.size(); ++i)
    second += result.shares[i] * (points[i] - centre) * (points[i] - centre).transpose();
  result.centreError = (centre - solid.centre).norm() / extent(points);
  result.inertiaError = (inertia(second) - inertia(solid.second)).norm() / inertia(solid.second).norm();
  return result;
}

}  // namespace limber::test
