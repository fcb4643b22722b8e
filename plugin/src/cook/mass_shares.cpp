// SPDX-License-Identifier: Zlib
#include "cook/mass_shares.h"

#include "cook/moment_match.h"
#include "cook/solid_moments.h"
#include "mesh/edges.h"
#include "mesh/surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The least share that Area and Moments give, of the mean: the lightest point limits the time step.
constexpr double kLeastMassShare = 0.2;
/// The most that they give to a point of the surface, lest a few carry the body. Points inside get what
/// Moments takes.
constexpr double kMostMassShare = 10.0;

/// Of the mass: too little to be told from nothing.
constexpr double kNoShare = 1e-30;

/// Mass 1, centre, and second moments about it.
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

/// Sum 1, in proportion to `shares` but for those that the bounds stand against.
std::vector<double> bounded(const std::vector<double>& shares) {
  const double mean = 1.0 / static_cast<double>(shares.size());
  const double least = kLeastMassShare * mean, most = kMostMassShare * mean;
  const auto [low, high] = std::minmax_element(shares.begin(), shares.end());
  if (*low >= least && *high <= most) return shares;
  const auto sumOf = [&](double factor) {
    double sum = 0.0;
    for (const double share : shares) sum += std::clamp(factor * share, least, most);
    return sum;
  };
  // the sum grows with the factor, from below 1 to above: even the least share comes to `most`
  double below = 0.0, above = most / std::max(*low, kNoShare);
  for (int halving = 0; halving < 200; ++halving) {
    const double factor = 0.5 * (below + above);
    (sumOf(factor) < 1.0 ? below : above) = factor;
  }
  std::vector<double> result;
  const double sum = sumOf(above);
  for (const double share : shares) result.push_back(std::clamp(above * share, least, most) / sum);
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
  return bounded(shares);
}

/// In coordinates about the solid's centre in units of its radius of gyration, where all moments are of the
/// order of 1: mass, first and second moments of a point of mass 1.
MomentVector momentsOf(const Vector3d& p) {
  MomentVector m;
  m << 1.0, p.x(), p.y(), p.z(), p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), p.y() * p.z(), p.z() * p.x(),
      p.x() * p.y();
  return m;
}

/// Sets the shares, from those wanted, and what is proven about them.
void matchSolid(MassShares& result, const std::vector<Vector3d>& points, const std::vector<Triangle>& surface,
                const SolidMoments& solid) {
  const double unit = std::sqrt(solid.second.trace());
  const Matrix3d s = solid.second / (unit * unit);
  MomentVector target;
  target << 1.0, 0.0, 0.0, 0.0, s(0, 0), s(1, 1), s(2, 2), s(1, 2), s(2, 0), s(0, 1);
  std::vector<MomentVector> rows;
  rows.reserve(points.size());
  for (const Vector3d& p : points) rows.push_back(momentsOf((p - solid.centre) / unit));
  const double mean = 1.0 / static_cast<double>(points.size());
  std::vector<double> most(points.size(), 1.0);
  for (const Triangle& t : surface) {
    for (const std::uint32_t corner : t) most[corner] = std::min(1.0, kMostMassShare * mean);
  }
  const std::vector<double> wanted = std::move(result.shares);
  MomentMatch match = matchMoments(rows, target, wanted, kLeastMassShare * mean, most);
  result.leastMisfit = match.leastMisfit;
  if (match.leastMisfit > 0.0)
    result.leastMisfitAnyMass =
        matchMoments(rows, target, wanted, 0.0, std::vector<double>(points.size(), 1.0)).leastMisfit;
  result.shares = std::move(match.shares);
}

}  // namespace

MassShares shareMass(MassRule rule, const std::vector<Vector3d>& points,
                     const std::vector<Triangle>& surface) {
  MassShares result;
  if (rule == MassRule::Equal) {
    result.shares.assign(points.size(), 1.0 / static_cast<double>(points.size()));
  } else {
    result.shares = areaShares(points, surface);
  }
  result.centreError = result.inertiaError = std::numeric_limits<double>::quiet_NaN();
  if (surface.empty() || !findEdgeDefects(surface).none()) return result;
  const Eigen::Map<const Eigen::Matrix3Xd> places(points.front().data(), 3, Eigen::Index(points.size()));
  const SolidMoments solid = solidMoments(places, surface);
  if (!(std::abs(solid.volume) > 0.0) || !(solid.second.trace() > 0.0)) return result;

  if (rule == MassRule::Moments) matchSolid(result, points, surface, solid);
  const Moments got = pointMoments(points, result.shares);
  result.centreError = (got.centre - solid.centre).norm() / extent(points);
  result.inertiaError = (inertia(got.second) - inertia(solid.second)).norm() / inertia(solid.second).norm();
  return result;
}

}  // namespace limber
