// SPDX-License-Identifier: Zlib
// Distributes the mass of a body over its points: equally, by area, or so that the moments of the solid are
// matched.

#include "network/masses.h"

#include "mesh/linear_algebra.h"
#include "mesh/surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The programme has the solution  x_i = clamp(w_i (1 + A_i . y), l_i, m_i)  for the multipliers y that
// minimise the convex, piecewise quadratic dual
//     sum g_i(A_i . y) - t . y,   g_i'(s) = clamp(w_i (1 + s), l_i, m_i),
// which has ten unknowns for any number of points. It is minimised by the proximal point method (R.
// Rockafellar, "Augmented Lagrangians and applications of the proximal point algorithm", 1976): each round
// adds 1/2 sum r (y - y_before)^2 and takes Newton steps. If no x has the moments t, the multipliers grow
// without limit while x converges to the smallest misfit, with the square of each moment weighted by 1 / r.

using Hessian = Eigen::Matrix<double, 10, 10>;

constexpr int kMaxMatchRounds = 100;
constexpr int kMaxNewtonSteps = 50;

/// Clamps s = A_i . y to the range in which the fraction is within its bounds.
double clampedMultiplier(const MassProgramme& p, std::size_t i, double s) {
  return std::clamp(s, p.minFractions[i] / p.desired[i] - 1.0, p.maxFractions[i] / p.desired[i] - 1.0);
}

double fraction(const MassProgramme& p, std::size_t i, const MomentVector& y) {
  return p.desired[i] * (1.0 + clampedMultiplier(p, i, p.rows[i].dot(y)));
}

double dual(const MassProgramme& p, const MomentVector& y, const MomentVector& before) {
  double sum = -p.target.dot(y) + 0.5 * (y - before).cwiseAbs2().dot(momentRegularisation());
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    const double s = p.rows[i].dot(y), clamped = clampedMultiplier(p, i, s), w = p.desired[i];
    sum += w * clamped + 0.5 * w * clamped * clamped + w * (1.0 + clamped) * (s - clamped);
  }
  return sum;
}

MomentVector misfit(const MassProgramme& p, const MomentVector& y) {
  MomentVector sum = -p.target;
  for (std::size_t i = 0; i < p.rows.size(); ++i) sum += fraction(p, i, y) * p.rows[i];
  return sum;
}

Hessian hessian(const MassProgramme& p, const MomentVector& y) {
  Hessian h = momentRegularisation().asDiagonal();
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    const double s = p.rows[i].dot(y);
    if (clampedMultiplier(p, i, s) == s) h += p.desired[i] * p.rows[i] * p.rows[i].transpose();
  }
  return h;
}

/// Performs one round of the proximal point method. Newton steps are halved until the dual falls.
MomentVector proximalStep(const MassProgramme& p, const MomentVector& before) {
  MomentVector y = before;
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const MomentVector gradient = misfit(p, y) + momentRegularisation().cwiseProduct(y - before);
    if (gradient.cwiseAbs().maxCoeff() < 0.01 * kExactMoments) break;
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

/// Smallest fraction that Area and Moments give, relative to the mean: the lightest point limits the time
/// step.
constexpr double kMinFraction = 0.2;
/// Largest fraction that they give to a point of the surface, relative to the mean, so that a few points do
/// not have most of the mass. Moments does not limit points inside.
constexpr double kMaxFraction = 10.0;
constexpr double kZeroFraction = 1e-30;

void divideBySum(std::vector<double>& values) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  for (double& value : values) value /= sum;
}

/// Returns fractions of sum 1, in proportion to `fractions` except where they are clamped to the bounds.
std::vector<double> clamped(const std::vector<double>& fractions) {
  const double mean = 1.0 / static_cast<double>(fractions.size());
  const double lower = kMinFraction * mean, upper = kMaxFraction * mean;
  const auto [smallest, largest] = std::minmax_element(fractions.begin(), fractions.end());
  if (*smallest >= lower && *largest <= upper) return fractions;
  std::vector<double> result(fractions.size());
  const auto sumWith = [&](double factor) {
    std::transform(fractions.begin(), fractions.end(), result.begin(),
                   [&](double f) { return std::clamp(factor * f, lower, upper); });
    return std::accumulate(result.begin(), result.end(), 0.0);
  };
  // the sum grows with the factor, from below 1 to above: at the largest factor even the smallest fraction is
  // `upper`
  double below = 0.0, above = upper / std::max(*smallest, kZeroFraction);
  for (int halving = 0; halving < 200; ++halving) {
    const double factor = 0.5 * (below + above);
    (sumWith(factor) < 1.0 ? below : above) = factor;
  }
  sumWith(above);
  divideBySum(result);
  return result;
}

std::vector<double> areaFractions(const std::vector<Vector3d>& points, const std::vector<Triangle>& surface) {
  std::vector<double> fractions(points.size(), 0.0);
  for (const Triangle& t : surface) {
    const double area = areaVector(points, t).norm();
    for (const std::uint32_t corner : t) fractions[corner] += area / 3.0;
  }
  const double sum = std::accumulate(fractions.begin(), fractions.end(), 0.0);
  const auto used = std::count_if(fractions.begin(), fractions.end(), [](double f) { return f > 0.0; });
  const double mean = used > 0 ? sum / static_cast<double>(used) : 1.0;
  for (double& f : fractions) f = f > 0.0 ? f : mean;
  divideBySum(fractions);
  return clamped(fractions);
}

MomentVector momentsOf(const Vector3d& p) {
  MomentVector m;
  m << 1.0, p.x(), p.y(), p.z(), p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), p.y() * p.z(), p.z() * p.x(),
      p.x() * p.y();
  return m;
}

}  // namespace

// Sums over the tetrahedra from the mean of the points, where rounding is smallest, to each triangle. One
// with corners v_i has the second moments V/20 (sum v_i v_i^T + (sum v_i) (sum v_i)^T).
SolidMoments solidMoments(const std::vector<Vector3d>& points, const std::vector<Triangle>& surface) {
  Vector3d origin = Vector3d::Zero(), first = Vector3d::Zero();
  for (const Vector3d& p : points) origin += p;
  origin /= static_cast<double>(points.size());
  SolidMoments m;
  for (const Triangle& t : surface) {
    const Vector3d a = points[t[0]] - origin, b = points[t[1]] - origin, c = points[t[2]] - origin,
                   sum = a + b + c;
    const double part = a.dot(b.cross(c)) / 6.0;
    m.volume += part;
    first += part / 4.0 * sum;
    m.second +=
        part / 20.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  const Vector3d centre = first / m.volume;
  m.centre = origin + centre;
  m.second = m.second / m.volume - centre * centre.transpose();
  return m;
}

MomentVector momentRegularisation() {
  MomentVector regularisation = MomentVector::Constant(1e-4);
  regularisation.head<4>().setConstant(1e-8);
  return regularisation;
}

MassProgramme massProgramme(const std::vector<Vector3d>& points, const std::vector<Triangle>& surface,
                            const SolidMoments& solid) {
  MassProgramme p;
  const double unit = std::sqrt(solid.second.trace()), mean = 1.0 / static_cast<double>(points.size());
  const Matrix3d s = solid.second / (unit * unit);
  p.target << 1.0, 0.0, 0.0, 0.0, s(0, 0), s(1, 1), s(2, 2), s(1, 2), s(2, 0), s(0, 1);
  for (const Vector3d& point : points) p.rows.push_back(momentsOf((point - solid.centre) / unit));
  p.desired = areaFractions(points, surface);
  p.minFractions.assign(points.size(), kMinFraction * mean);
  p.maxFractions.assign(points.size(), 1.0);
  for (const Triangle& t : surface)
    for (const std::uint32_t corner : t) p.maxFractions[corner] = std::min(1.0, kMaxFraction * mean);
  return p;
}

MassMatch matchMoments(const MassProgramme& p) {
  MassMatch match{{}, MomentVector::Zero(), misfit(p, MomentVector::Zero())};
  for (int round = 0; round < kMaxMatchRounds && match.misfit.cwiseAbs().maxCoeff() > kExactMoments;
       ++round) {
    match.multipliers = proximalStep(p, match.multipliers);
    match.misfit = misfit(p, match.multipliers);
  }
  for (std::size_t i = 0; i < p.rows.size(); ++i)
    match.fractions.push_back(fraction(p, i, match.multipliers));
  divideBySum(match.fractions);
  return match;
}

std::vector<double> massFractions(MassRule rule, const std::vector<Vector3d>& points,
                                  const std::vector<Triangle>& surface) {
  if (rule == MassRule::Equal)
    return std::vector<double>(points.size(), 1.0 / static_cast<double>(points.size()));
  const bool closed = !surface.empty() && findEdgeDefects(surface).none();
  if (rule == MassRule::Area || !closed) return areaFractions(points, surface);
  const SolidMoments solid = solidMoments(points, surface);
  if (!(std::abs(solid.volume) > 0.0) || !(solid.second.trace() > 0.0)) return areaFractions(points, surface);
  return matchMoments(massProgramme(points, surface, solid)).fractions;
}

}  // namespace limber
