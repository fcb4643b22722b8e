// SPDX-License-Identifier: Zlib
// Distributes the mass of a body over its points: equally, by area, or so that the moments of the solid are
// matched.

#include "network/masses.h"

#include "mesh/edges.h"
#include "mesh/linear_algebra.h"
#include "mesh/surface.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

}  // namespace

// Sums over the tetrahedra from the mean of the points, where rounding is smallest, to each triangle. One
// with corners v_i has the second moments V/20 (sum v_i v_i^T + (sum v_i) (sum v_i)^T).
SolidMoments solidMoments(const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                          const std::vector<Triangle>& surface) {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(), first = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < points.cols(); ++i) origin += points.col(i);
  origin /= static_cast<double>(points.cols());
  SolidMoments m;
  for (const Triangle& t : surface) {
    const Eigen::Vector3d a = points.col(t[0]) - origin, b = points.col(t[1]) - origin,
                          c = points.col(t[2]) - origin, sum = a + b + c;
    const double part = a.dot(b.cross(c)) / 6.0;
    m.volume += part;
    first += part / 4.0 * sum;
    m.second +=
        part / 20.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  const Eigen::Vector3d centre = first / m.volume;
  m.centre = origin + centre;
  m.second = m.second / m.volume - centre * centre.transpose();
  return m;
}

namespace {

/// Mass, first moments (3), second moments (6).
using MomentVector = Eigen::Matrix<double, 10, 1>;

struct MomentMatch {
  std::vector<double> shares;  ///< #points, sum 1
  /// Proven lower bound of the distance of any shares within the bounds from the target (Euclidean distance
  /// of the moments, including the mass). Above 0 the problem has no solution.
  double leastMisfit = 0.0;
};

// The quadratic programme
//     min  1/2 sum (x_i - w_i)^2 / w_i   with  sum x_i A_i = t,  l <= x_i <= m_i
// has the solution  x_i = clamp(w_i (1 + A_i . y), l, m_i)  for the multipliers y that minimise the convex,
// piecewise quadratic dual
//     sum g_i(A_i . y) - t . y,   g_i'(s) = clamp(w_i (1 + s), l, m_i),
// which has ten unknowns for any number of points. It is minimised by the proximal point method (R.
// Rockafellar, "Augmented Lagrangians and applications of the proximal point algorithm", 1976): each round
// adds 1/2 sum r (y - y_before)^2 and takes Newton steps. If no x has the moments t, the multipliers grow
// without limit while x converges to the smallest misfit, with the square of each moment weighted by 1 / r.

using Hessian = Eigen::Matrix<double, 10, 10>;

constexpr int kMaxMatchRounds = 100;
constexpr int kMaxNewtonSteps = 50;
constexpr double kExact = 1e-10;

struct Programme {
  const std::vector<MomentVector>& rows;
  const MomentVector& target;
  const std::vector<double>& desired;
  double minShare;
  const std::vector<double>& maxShares;
  MomentVector regularisation;
};

/// Clamps s = A_i . y to the range in which the share is within its bounds.
double clampedMultiplier(const Programme& p, std::size_t i, double s) {
  return std::clamp(s, p.minShare / p.desired[i] - 1.0, p.maxShares[i] / p.desired[i] - 1.0);
}

double share(const Programme& p, std::size_t i, const MomentVector& y) {
  return p.desired[i] * (1.0 + clampedMultiplier(p, i, p.rows[i].dot(y)));
}

double dual(const Programme& p, const MomentVector& y, const MomentVector& before) {
  double sum = -p.target.dot(y) + 0.5 * (y - before).cwiseAbs2().dot(p.regularisation);
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    const double s = p.rows[i].dot(y), clamped = clampedMultiplier(p, i, s), w = p.desired[i];
    sum += w * clamped + 0.5 * w * clamped * clamped + w * (1.0 + clamped) * (s - clamped);
  }
  return sum;
}

MomentVector misfit(const Programme& p, const MomentVector& y) {
  MomentVector sum = -p.target;
  for (std::size_t i = 0; i < p.rows.size(); ++i) sum += share(p, i, y) * p.rows[i];
  return sum;
}

Hessian hessian(const Programme& p, const MomentVector& y) {
  Hessian h = p.regularisation.asDiagonal();
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    const double s = p.rows[i].dot(y);
    if (clampedMultiplier(p, i, s) == s) h += p.desired[i] * p.rows[i] * p.rows[i].transpose();
  }
  return h;
}

/// Performs one round of the proximal point method. Newton steps are halved until the dual falls.
MomentVector proximalStep(const Programme& p, const MomentVector& before) {
  MomentVector y = before;
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const MomentVector gradient = misfit(p, y) + p.regularisation.cwiseProduct(y - before);
    if (gradient.cwiseAbs().maxCoeff() < 0.01 * kExact) break;
    MomentVector step = -gradient;
    solveSmall(hessian(p, y), step);
    const double slope = gradient.dot(step), current = dual(p, y, before);
    double length = 1.0;
    while (length > 1e-6 && dual(p, y + length * step, before) > current + 1e-4 * length * slope)
      length /= 2.0;
    y += length * step;
  }
  return y;
}

/// Returns the smallest distance, along a direction, by which the moments of all shares within the bounds lie
/// beyond the target's. These moments fill a convex body. A plane with the body on one side and the target on
/// the other proves (Farkas' lemma) that no shares have the target's moments. The check needs one sum.
double separation(const Programme& p, const MomentVector& direction) {
  double distance = -p.target.dot(direction);
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    const double along = p.rows[i].dot(direction);
    distance += along * (along > 0.0 ? p.minShare : p.maxShares[i]);
  }
  return distance / direction.norm();
}

/// Returns a proven misfit. The multipliers of a problem without solution grow along a separating direction,
/// and the remaining weighted misfit points along one too.
double provenMisfit(const Programme& p, const MomentVector& y, const MomentVector& error) {
  const MomentVector weighted = error.cwiseQuotient(p.regularisation);
  double proven = 0.0;
  for (const MomentVector& direction : {MomentVector(-y), weighted})
    if (direction.norm() > 0.0) proven = std::max(proven, separation(p, direction));
  return proven;
}

/// Computes shares of sum 1 between `minShare` (below 1 / #points) and maxShares[i] whose moments
///     sum share_i momentsOfPoint_i
/// are `target`. Of all such shares, returns those with the smallest
///     sum (share_i - desired_i)^2 / desired_i.
/// If there are none, returns those with the smallest error of the moments; the first moments count far more
/// than the second. All moments should be of the order of 1.
MomentMatch matchMoments(const std::vector<MomentVector>& momentsOfPoint, const MomentVector& target,
                         const std::vector<double>& desired, double minShare,
                         const std::vector<double>& maxShares) {
  Programme p{momentsOfPoint, target, desired, minShare, maxShares, MomentVector::Constant(1e-4)};
  p.regularisation.head<4>().setConstant(1e-8);
  MomentVector y = MomentVector::Zero(), error = misfit(p, y);
  for (int round = 0; round < kMaxMatchRounds && error.cwiseAbs().maxCoeff() > kExact; ++round) {
    y = proximalStep(p, y);
    error = misfit(p, y);
  }
  MomentMatch match;
  for (std::size_t i = 0; i < momentsOfPoint.size(); ++i) match.shares.push_back(share(p, i, y));
  const double sum = std::accumulate(match.shares.begin(), match.shares.end(), 0.0);
  for (double& s : match.shares) s /= sum;
  if (error.cwiseAbs().maxCoeff() > kExact) match.leastMisfit = provenMisfit(p, y, error);
  return match;
}

/// Smallest share that Area and Moments give, relative to the mean: the lightest point limits the time step.
constexpr double kMinMassShare = 0.2;
/// Largest share that they give to a point of the surface, relative to the mean, so that a few points do not
/// have most of the mass. Moments does not limit points inside.
constexpr double kMaxMassShare = 10.0;

/// Share of the mass that counts as zero.
constexpr double kZeroShare = 1e-30;

/// Centre and second moments about it, of a mass of 1.
struct Moments {
  Vector3d centre = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
};

Matrix3d inertia(const Matrix3d& second) { return second.trace() * Matrix3d::Identity() - second; }

Moments pointMoments(const std::vector<Vector3d>& points, const std::vector<double>& shares) {
  Moments m;
  for (std::size_t i = 0; i < points.size(); ++i) m.centre += shares[i] * points[i];
  for (std::size_t i = 0; i < points.size(); ++i)
    m.second += shares[i] * (points[i] - m.centre) * (points[i] - m.centre).transpose();
  return m;
}

/// Returns shares of sum 1, in proportion to `shares` except where they are clamped to the bounds.
std::vector<double> clampShares(const std::vector<double>& shares) {
  const double mean = 1.0 / static_cast<double>(shares.size());
  const double minShare = kMinMassShare * mean, maxShare = kMaxMassShare * mean;
  const auto [smallest, largest] = std::minmax_element(shares.begin(), shares.end());
  if (*smallest >= minShare && *largest <= maxShare) return shares;
  const auto sumOf = [&](double factor) {
    double sum = 0.0;
    for (const double share : shares) sum += std::clamp(factor * share, minShare, maxShare);
    return sum;
  };
  // the sum grows with the factor, from below 1 to above: at the largest factor even the smallest share is
  // `maxShare`
  double below = 0.0, above = maxShare / std::max(*smallest, kZeroShare);
  for (int halving = 0; halving < 200; ++halving) {
    const double factor = 0.5 * (below + above);
    (sumOf(factor) < 1.0 ? below : above) = factor;
  }
  std::vector<double> result;
  const double sum = sumOf(above);
  for (const double share : shares) result.push_back(std::clamp(above * share, minShare, maxShare) / sum);
  return result;
}

std::vector<double> areaShares(const std::vector<Vector3d>& points, const std::vector<Triangle>& surface) {
  std::vector<double> shares(points.size(), 0.0);
  for (const Triangle& t : surface) {
    const double area = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).norm() / 2.0;
    for (const std::uint32_t corner : t) shares[corner] += area / 3.0;
  }
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  const auto used = std::count_if(shares.begin(), shares.end(), [](double share) { return share > 0.0; });
  if (used == 0) return std::vector<double>(points.size(), 1.0 / static_cast<double>(points.size()));
  const double mean = sum / static_cast<double>(used);
  for (double& share : shares) share = share > 0.0 ? share : mean;
  const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share /= total;
  return clampShares(shares);
}

/// Returns mass, first and second moments of a point of mass 1. The coordinates are about the solid's centre
/// in units of its radius of gyration, so that all moments are of the order of 1.
MomentVector momentsOf(const Vector3d& p) {
  MomentVector m;
  m << 1.0, p.x(), p.y(), p.z(), p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), p.y() * p.z(), p.z() * p.x(),
      p.x() * p.y();
  return m;
}

/// Matches the moments: replaces the desired shares in `result` and sets the proven misfits.
void matchSolid(MassFractions& result, const std::vector<Vector3d>& points,
                const std::vector<Triangle>& surface, const SolidMoments& solid) {
  const double unit = std::sqrt(solid.second.trace());
  const Matrix3d s = solid.second / (unit * unit);
  MomentVector target;
  target << 1.0, 0.0, 0.0, 0.0, s(0, 0), s(1, 1), s(2, 2), s(1, 2), s(2, 0), s(0, 1);
  std::vector<MomentVector> rows;
  rows.reserve(points.size());
  for (const Vector3d& p : points) rows.push_back(momentsOf((p - solid.centre) / unit));
  const double mean = 1.0 / static_cast<double>(points.size());
  std::vector<double> maxShares(points.size(), 1.0);
  for (const Triangle& t : surface) {
    for (const std::uint32_t corner : t) maxShares[corner] = std::min(1.0, kMaxMassShare * mean);
  }
  const std::vector<double> desired = std::move(result.shares);
  MomentMatch match = matchMoments(rows, target, desired, kMinMassShare * mean, maxShares);
  result.leastMisfit = match.leastMisfit;
  if (match.leastMisfit > 0.0)
    result.leastMisfitAnyMass =
        matchMoments(rows, target, desired, 0.0, std::vector<double>(points.size(), 1.0)).leastMisfit;
  result.shares = std::move(match.shares);
}

}  // namespace

MassFractions shareMass(MassRule rule, const std::vector<Vector3d>& points,
                        const std::vector<Triangle>& surface) {
  MassFractions result;
  if (rule == MassRule::Equal) {
    result.shares.assign(points.size(), 1.0 / static_cast<double>(points.size()));
  } else {
    result.shares = areaShares(points, surface);
  }
  result.centreError = result.inertiaError = std::numeric_limits<double>::quiet_NaN();
  if (surface.empty() || !findEdgeDefects(surface).none()) return result;
  const Eigen::Map<const Eigen::Matrix3Xd> positions(points.front().data(), 3, Eigen::Index(points.size()));
  const SolidMoments solid = solidMoments(positions, surface);
  if (!(std::abs(solid.volume) > 0.0) || !(solid.second.trace() > 0.0)) return result;

  if (rule == MassRule::Moments) matchSolid(result, points, surface, solid);
  const Moments actual = pointMoments(points, result.shares);
  result.centreError = (actual.centre - solid.centre).norm() / extent(points);
  result.inertiaError =
      (inertia(actual.second) - inertia(solid.second)).norm() / inertia(solid.second).norm();
  return result;
}

}  // namespace limber
