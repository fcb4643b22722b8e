// SPDX-License-Identifier: Zlib
#include "solver/fastest_oscillation.h"

#include "solver/largest_eigenvalue.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// A spring's part of the stiffness matrix is (along - across) n n^T + across I between its ends.
struct SpringSlopes {
  Points direction;                   ///< 3 x #springs, n
  std::vector<double> along, across;  ///< N/m
};

/// The force k (l - L) n of a spring changes by k n n^T along it, and by its force over its length across it.
/// In compression that is negative and lowers frequencies: left out.
SpringSlopes slopesOf(const SpringArrays& springs, const Points& x) {
  const std::size_t count = springs.size();
  SpringSlopes s{Points(3, static_cast<Index>(count)), std::vector<double>(count),
                 std::vector<double>(count)};
  const double stiffened = springs.limit.stiffenStrain > 0.0 ? springs.limit.stiffenFactor : 1.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d d = x.col(springs.b[i]) - x.col(springs.a[i]);
    const double length = d.norm();
    s.direction.col(static_cast<Index>(i)) = d.stableNormalized();
    s.along[i] = stiffened * std::max(springs.extensionStiffness[i], springs.compressionStiffness[i]);
    if (length > springs.restLength[i])
      s.across[i] = springs.extensionStiffness[i] * (length - springs.restLength[i]) / length;
  }
  return s;
}

void addSpringForces(const SpringArrays& springs, const SpringSlopes& s, const Points& u, Points& force) {
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Vector3d n = s.direction.col(static_cast<Index>(i));
    const Vector3d way = u.col(springs.b[i]) - u.col(springs.a[i]);
    const Vector3d f = s.across[i] * way + ((s.along[i] - s.across[i]) * n.dot(way)) * n;
    force.col(springs.a[i]) -= f;
    force.col(springs.b[i]) += f;
  }
}

/// sqrt(stiffness) times the gradient of each component's volume: the volume term's stiffness matrix is the
/// sum of their squares g g^T, for at rest it has no force.
std::vector<Points> volumeGradients(const VolumeArrays& volumes, const PointState& state) {
  std::vector<Points> gradients;
  Points gradient = Points::Zero(3, state.position.cols());
  for (std::size_t c = 0; c < volumes.restVolume.size(); ++c) {
    const VolumeSlope slope = volumeSlope(volumes, c, state, gradient);
    gradients.push_back(std::sqrt(slope.stiffness) * gradient);
  }
  return gradients;
}

std::vector<TetrahedronSlope> tetrahedronSlopes(const TetrahedronVolumes& volumes, const Points& x) {
  std::vector<TetrahedronSlope> slopes;
  for (std::size_t i = 0; i < volumes.tetrahedra.size(); ++i)
    slopes.push_back(tetrahedronSlope(volumes, i, x));
  return slopes;
}

void addTetrahedronForces(const TetrahedronVolumes& volumes, const std::vector<TetrahedronSlope>& slopes,
                          const Points& u, Points& force) {
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    double change = 0.0;
    for (Index k = 0; k < 4; ++k)
      change += slopes[i].gradient.col(k).dot(u.col(volumes.tetrahedra[i][static_cast<std::size_t>(k)]));
    for (Index k = 0; k < 4; ++k)
      force.col(volumes.tetrahedra[i][static_cast<std::size_t>(k)]) +=
          slopes[i].stiffness * change * slopes[i].gradient.col(k);
  }
}

}  // namespace

double fastestOscillationSquared(const SpringArrays& springs, const VolumeArrays& volumes,
                                 const TetrahedronVolumes& tetrahedra, const PointState& state,
                                 double tolerance) {
  const SpringSlopes slopes = slopesOf(springs, state.position);
  const std::vector<Points> gradients = volumeGradients(volumes, state);
  const std::vector<TetrahedronSlope> ofTetrahedra = tetrahedronSlopes(tetrahedra, state.position);
  const Points root = state.inverseMass.cwiseSqrt();
  Points force(3, root.cols());
  return largestEigenvalue(
      [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
        const Points u = root.cwiseProduct(v.reshaped(3, root.cols()));
        force.setZero();
        addSpringForces(springs, slopes, u, force);
        addTetrahedronForces(tetrahedra, ofTetrahedra, u, force);
        for (const Points& g : gradients) force += dot(g, u) * g;
        return root.cwiseProduct(force).reshaped();
      },
      root.size(), tolerance);
}

}  // namespace limber
