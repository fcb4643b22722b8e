// SPDX-License-Identifier: Zlib
#include "cook/moment_match.h"

#include "solver/linear_algebra.h"

#include <algorithm>
#include <numeric>

// The quadratic programme
//     min  1/2 sum (x_i - w_i)^2 / w_i   with  sum x_i A_i = t,  l <= x_i <= m_i
// has the solution  x_i = clamp(w_i (1 + A_i . y), l, m_i)  for the multipliers y that minimise the convex,
// piecewise quadratic dual
//     sum g_i(A_i . y) - t . y,   g_i'(s) = clamp(w_i (1 + s), l, m_i),
// whatever the number of points in ten unknowns. It is minimised by the proximal point method (R.
// Rockafellar, "Augmented Lagrangians and applications of the proximal point algorithm", 1976): each round
// adds 1/2 sum r (y - y_before)^2 and takes Newton steps. Where no x has the moments t, the multipliers grow
// without end while x tends to the least misfit, each moment's square weighted by 1 / r.
namespace limber {
namespace {

using Hessian = Eigen::Matrix<double, 10, 10>;

constexpr int kMostMatchRounds = 100;
constexpr int kMostNewtonSteps = 50;
constexpr double kExact = 1e-10;

struct Programme {
  const std::vector<MomentVector>& rows;
  const MomentVector& target;
  const std::vector<double>& wanted;
  double least;
  const std::vector<double>& most;
  MomentVector regularisation;
};

/// A_i . y, no lower or higher than where the share reaches its bounds.
double freePart(const Programme& p, std::size_t i, double s) {
  return std::clamp(s, p.least / p.wanted[i] - 1.0, p.most[i] / p.wanted[i] - 1.0);
}

double share(const Programme& p, std::size_t i, const MomentVector& y) {
  return p.wanted[i] * (1.0 + freePart(p, i, p.rows[i].dot(y)));
}

double dual(const Programme& p, const MomentVector& y, const MomentVector& before) {
  double sum = -p.target.dot(y) + 0.5 * (y - before).cwiseAbs2().dot(p.regularisation);
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    const double s = p.rows[i].dot(y), free = freePart(p, i, s), w = p.wanted[i];
    sum += w * free + 0.5 * w * free * free + w * (1.0 + free) * (s - free);
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
    if (freePart(p, i, s) == s) h += p.wanted[i] * p.rows[i] * p.rows[i].transpose();
  }
  return h;
}

/// One round of the proximal point method, with Newton steps halved until the dual falls.
MomentVector proximalStep(const Programme& p, const MomentVector& before) {
  MomentVector y = before;
  for (int i = 0; i < kMostNewtonSteps; ++i) {
    const MomentVector gradient = misfit(p, y) + p.regularisation.cwiseProduct(y - before);
    if (gradient.cwiseAbs().maxCoeff() < 0.01 * kExact) break;
    MomentVector step = -gradient;
    solveSmall(hessian(p, y), step);
    const double slope = gradient.dot(step), now = dual(p, y, before);
    double length = 1.0;
    while (length > 1e-6 && dual(p, y + length * step, before) > now + 1e-4 * length * slope) length /= 2.0;
    y += length * step;
  }
  return y;
}

/// How far, along a direction, the moments of all shares within the bounds stay beyond the target's. They
/// fill a convex body, so that a plane with the body on one side and the target on the other is a certificate
/// (Farkas' lemma) that no shares have the target's moments; checking it takes one sum.
double separation(const Programme& p, const MomentVector& direction) {
  double least = -p.target.dot(direction);
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    const double along = p.rows[i].dot(direction);
    least += along * (along > 0.0 ? p.least : p.most[i]);
  }
  return least / direction.norm();
}

/// The multipliers of a problem without solution grow along such a direction, and the weighted misfit that is
/// left points along one.
double provenMisfit(const Programme& p, const MomentVector& y, const MomentVector& error) {
  const MomentVector weighted = error.cwiseQuotient(p.regularisation);
  double proven = 0.0;
  for (const MomentVector& direction : {MomentVector(-y), weighted})
    if (direction.norm() > 0.0) proven = std::max(proven, separation(p, direction));
  return proven;
}

}  // namespace

MomentMatch matchMoments(const std::vector<MomentVector>& momentsOfPoint, const MomentVector& target,
                         const std::vector<double>& wanted, double least, const std::vector<double>& most) {
  Programme p{momentsOfPoint, target, wanted, least, most, MomentVector::Constant(1e-4)};
  p.regularisation.head<4>().setConstant(1e-8);
  MomentVector y = MomentVector::Zero(), error = misfit(p, y);
  for (int round = 0; round < kMostMatchRounds && error.cwiseAbs().maxCoeff() > kExact; ++round) {
    y = proximalStep(p, y);
    error = misfit(p, y);
  }
  MomentMatch match;
  for (std::size_t i = 0; i < momentsOfPoint.size(); ++i) match.shares.push_back(share(p, i, y));
  const double sum = std::accumulate(match.shares.begin(), match.shares.end(), 0.0);
  for (double& s : match.shares) s /= sum;
  match.misfit = error;
  if (error.cwiseAbs().maxCoeff() > kExact) match.leastMisfit = provenMisfit(p, y, error);
  return match;
}

}  // namespace limber
