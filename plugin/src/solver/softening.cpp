// SPDX-License-Identifier: Zlib
#include "solver/softening.h"

#include "mesh/linear_algebra.h"
#include "solver/stepping_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace limber {
namespace {

/// The bounds after softening must not be above the limit by rounding.
constexpr double kRounding = 1.0 - 1e-9;

/// The parts of the bound of a body's oscillations, rad^2/s^2.
struct Bounds {
  double springs, volumes, tetrahedra;
};

Bounds boundsAtRest(const ElasticConstants& full, const Points& restShape, const Points& inverseMass) {
  PointState rest;
  rest.resize(restShape.cols());
  rest.position = restShape;
  rest.inverseMass = inverseMass;
  SpringArrays springs;
  springs.original = full.springs;
  const auto points = static_cast<std::size_t>(restShape.cols());
  VolumeArrays volumes;
  volumes.constants = full.volumes;
  volumes.sums.resize(4 * full.volumes->restVolume.size());
  volumes.gradient.resize(3, restShape.cols());
  volumes.rowSums.resize(points);
  TetrahedronVolumes tetrahedra;
  tetrahedra.constants = full.tetrahedra;
  tetrahedra.rowSums.resize(points);
  std::vector<double> sums;
  return {frequencyBoundSquared(springs, inverseMass, sums), volumeFrequencyBoundSquared(volumes, rest, 0.0),
          tetrahedronFrequencyBoundSquared(tetrahedra, rest)};
}

/// The larger stiffness of each spring, also beyond its stiffening strain, N/m.
Eigen::VectorXd stiffest(const SpringConstants& s) {
  const double stiffened = s.limit.stiffenStrain > 0.0 ? s.limit.stiffenFactor : 1.0;
  const Eigen::Map<const Eigen::VectorXd> extension(s.extensionStiffness.data(),
                                                    static_cast<Eigen::Index>(s.a.size()));
  const Eigen::Map<const Eigen::VectorXd> compression(s.compressionStiffness.data(), extension.size());
  return stiffened * extension.cwiseMax(compression);
}

/// Relative tolerance of the eigenvalue below, whose square is its error, and a margin above that error.
constexpr double kEigenvalueTolerance = 0.03, kMargin = 1.01;

/// Returns a bound (rad^2/s^2) of the oscillations of springs of the stiffness k (N/m) at any deformation:
/// the largest eigenvalue of  W L W  with the graph's Laplacian L = sum k (e_a - e_b) (e_a - e_b)^T  and the
/// roots W of the inverse masses, because no spring is stiffer than k in any direction. Gershgorin's bound of
/// it is up to twice as large.
double graphBoundSquared(const SpringConstants& springs, const Eigen::VectorXd& k,
                         const Eigen::VectorXd& inverseMass) {
  const Eigen::VectorXd root = inverseMass.cwiseSqrt();
  Eigen::VectorXd force(root.size());
  const auto multiply = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
    force.setZero();
    for (std::size_t i = 0; i < springs.a.size(); ++i) {
      const Eigen::Index a = springs.a[i], b = springs.b[i];
      const double pull = k[static_cast<Eigen::Index>(i)] * (root[b] * v[b] - root[a] * v[a]);
      force[a] -= pull;
      force[b] += pull;
    }
    return root.cwiseProduct(force);
  };
  return kMargin * largestEigenvalue(multiply, root.size(), kEigenvalueTolerance);
}

/// The stiffness of the springs at each point, N/m: those of point i begin at first[i], the softest one
/// first.
struct SpringsOfPoints {
  std::vector<std::size_t> first;  ///< #points + 1
  std::vector<double> stiffness;
};

SpringsOfPoints springsOfPoints(const SpringConstants& springs, const Eigen::VectorXd& k,
                                Eigen::Index points) {
  SpringsOfPoints all;
  all.first.assign(static_cast<std::size_t>(points) + 1, 0);
  const auto forEachEnd = [&](auto visit) {
    for (std::size_t i = 0; i < springs.a.size(); ++i)
      for (const std::uint32_t end : {springs.a[i], springs.b[i]})
        visit(end, k[static_cast<Eigen::Index>(i)]);
  };
  forEachEnd([&](std::uint32_t end, double) { ++all.first[end + 1]; });
  std::partial_sum(all.first.begin(), all.first.end(), all.first.begin());
  all.stiffness.resize(all.first.back());
  std::vector<std::size_t> next = all.first;
  forEachEnd([&](std::uint32_t end, double stiffness) { all.stiffness[next[end]++] = stiffness; });
  for (std::size_t i = 0; i + 1 < all.first.size(); ++i)
    std::sort(all.stiffness.begin() + static_cast<std::ptrdiff_t>(all.first[i]),
              all.stiffness.begin() + static_cast<std::ptrdiff_t>(all.first[i + 1]));
  return all;
}

/// Returns the largest stiffness (N/m) c for which  sum min(k, c) <= largest  over the springs of a point.
double cap(const SpringsOfPoints& all, std::size_t point, double largest) {
  for (std::size_t i = all.first[point], end = all.first[point + 1]; i < end; ++i) {
    const auto left = static_cast<double>(end - i);
    if (left * all.stiffness[i] >= largest) return largest / left;
    largest -= all.stiffness[i];
  }
  return std::numeric_limits<double>::infinity();
}

/// Softens springs to the bound `largest`. Returns the smallest share. First the stiffest springs of each
/// point get so soft that its row  w sum k  is at most half of `largest`, as Gershgorin's bound requires;
/// then these are made stiffer by what the graph's bound is below that.
double soften(SpringConstants& springs, const Points& inverseMass, double largest) {
  const Eigen::VectorXd w = inverseMass.colwise().maxCoeff(), k = stiffest(springs);
  const SpringsOfPoints all = springsOfPoints(springs, k, w.size());
  Eigen::VectorXd caps(w.size()), share(k.size());
  for (Eigen::Index i = 0; i < w.size(); ++i)
    caps[i] = w[i] > 0.0 ? cap(all, static_cast<std::size_t>(i), 0.5 * largest / w[i]) : HUGE_VAL;
  for (Eigen::Index i = 0; i < k.size(); ++i) {
    const auto s = static_cast<std::size_t>(i);
    const double stiffest = std::min(caps[springs.a[s]], caps[springs.b[s]]);
    share[i] = k[i] > stiffest ? stiffest / k[i] : 1.0;
  }
  const double bound = graphBoundSquared(springs, share.cwiseProduct(k), w);
  if (bound < largest) share = (largest / bound * share).cwiseMin(1.0);
  for (Eigen::Index i = 0; i < k.size(); ++i) {
    springs.extensionStiffness[static_cast<std::size_t>(i)] *= share[i];
    springs.compressionStiffness[static_cast<std::size_t>(i)] *= share[i];
  }
  return share.size() ? share.minCoeff() : 1.0;
}

/// The shares of their stiffness that springs, closed surfaces and tetrahedra keep. A part that takes at most
/// a third of `largest` keeps all, and the others share the rest in proportion. With a pressure above the
/// ambient one no part does: it is in equilibrium with the springs.
struct Shares {
  double slow, others;

  Shares(const Bounds& bounds, double largest, bool underPressure)
      : slow(underPressure ? 0.0 : largest / 3.0) {
    double kept = 0.0, shared = 0.0;
    for (const double bound : {bounds.springs, bounds.volumes, bounds.tetrahedra})
      (bound <= slow ? kept : shared) += bound;
    others = shared > 0.0 ? std::min(1.0, kRounding * (largest - kept) / shared) : 1.0;
  }
  double of(double bound) const { return bound <= slow ? 1.0 : others; }
};

}  // namespace

SoftenedConstants softened(const ElasticConstants& full, const Points& restShape, const Points& inverseMass,
                           double largest) {
  SoftenedConstants result{full, 1.0, largest, inverseMass};
  const Bounds bounds = boundsAtRest(full, restShape, inverseMass);
  const Shares shares(bounds, largest, full.volumes->gasPressure > full.volumes->ambient);
  if (const double share = shares.of(bounds.springs); share < 1.0) {
    SpringConstants springs = *full.springs;
    result.share = soften(springs, inverseMass, share * bounds.springs);
    result.constants.springs = SharedConstants<SpringConstants>(std::move(springs));
  }
  if (const double share = shares.of(bounds.volumes); share < 1.0) {
    VolumeConstants volumes = *full.volumes;
    volumes.modulus *= share;
    volumes.gasPressure *= share;
    volumes.ambient *= share;
    result.share = std::min(result.share, share);
    result.constants.volumes = SharedConstants<VolumeConstants>(std::move(volumes));
  }
  if (const double share = shares.of(bounds.tetrahedra); share < 1.0) {
    TetrahedronConstants tetrahedra = *full.tetrahedra;
    tetrahedra.modulus *= share;
    tetrahedra.crushModulus *= share;
    result.share = std::min(result.share, share);
    result.constants.tetrahedra = SharedConstants<TetrahedronConstants>(std::move(tetrahedra));
  }
  return result;
}

std::shared_ptr<const SoftenedConstants> SharedSoftening::of(const ElasticConstants& full,
                                                             const Points& restShape,
                                                             const Points& inverseMass, double largest) {
  const std::lock_guard<std::mutex> guard(lock_);
  const auto isGone = [](const auto& made) { return made.expired(); };
  made_.erase(std::remove_if(made_.begin(), made_.end(), isGone), made_.end());
  for (const auto& made : made_)
    if (auto found = made.lock(); found->largest == largest && found->inverseMass == inverseMass)
      return found;
  auto constants = std::make_shared<const SoftenedConstants>(softened(full, restShape, inverseMass, largest));
  made_.push_back(constants);
  return constants;
}

}  // namespace limber
