// SPDX-License-Identifier: Zlib
// Distributes the mass of a body of tetrahedra over its points.

#include "network/masses.h"
#include "network/material.h"
#include "network/tetrahedra.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Mass that is added to the points of the fastest oscillations, as a fraction of the body's.
constexpr double kAdded = 0.07;

/// Largest mass of a point, as a multiple of the mass of the quarters of its tetrahedra: what the light
/// points gain must not come from a few heavy ones.
constexpr double kLargestGrowth = 1.3;

/// The interval in which the bound of stiffness over mass is searched, as a fraction of the largest ratio,
/// and the halvings of its logarithm.
constexpr double kSlowest = 1e-9;
constexpr int kHalvings = 60;

std::vector<double> quartersOfVolumes(const SpringNetwork& network) {
  std::vector<double> quarters(network.restPoints.size(), 0.0);
  for (const Tetrahedron& t : network.tetrahedra)
    for (const std::uint32_t point : t) quarters[point] += volumeOf(network.restPoints, t) / 4.0;
  return quarters;
}

/// Adds the stiffness of the volume terms of a material of Poisson's ratio 0.39, whose volume modulus is the
/// Young's modulus of the springs: K/V g g^T with the volume's gradient g, a third of the area vector of the
/// opposite face.
void addVolumeTerms(const SpringNetwork& network, std::vector<Matrix3d>& blocks) {
  const std::vector<Vector3d>& x = network.restPoints;
  for (const Tetrahedron& t : network.tetrahedra) {
    const double factor = 1.0 / (network.stiffnessPerModulus * volumeOf(x, t));
    for (std::size_t i = 0; i < 4; ++i) {
      const Vector3d &a = x[t[(i + 1) % 4]], &b = x[t[(i + 2) % 4]], &c = x[t[(i + 3) % 4]];
      const Vector3d gradient = (b - a).cross(c - a) / 6.0;
      blocks[t[i]] += factor * gradient * gradient.transpose();
    }
  }
}

/// Returns the largest stiffness of each point while its neighbours are held, as a multiple of that of a
/// spring of stiffnessScale 1.
std::vector<double> stiffnessOfPoints(const SpringNetwork& network) {
  std::vector<Matrix3d> blocks(network.restPoints.size(), Matrix3d::Zero());
  for (const NetworkSpring& s : network.springs) {
    const Vector3d along = (network.restPoints[s.b] - network.restPoints[s.a]).normalized();
    for (const std::uint32_t end : {s.a, s.b}) blocks[end] += s.stiffnessScale * along * along.transpose();
  }
  addVolumeTerms(network, blocks);
  std::vector<double> stiffness;
  stiffness.reserve(blocks.size());
  for (const Matrix3d& block : blocks) stiffness.push_back(symmetricValues(block)[2]);
  return stiffness;
}

/// Returns the smallest masses of the points for the smallest bound of stiffness over mass that adds at most
/// kAdded to the given masses of sum 1.
std::vector<double> smallestMasses(const std::vector<double>& masses, const std::vector<double>& stiffness) {
  double fast = 0.0;
  for (std::size_t i = 0; i < masses.size(); ++i) fast = std::max(fast, stiffness[i] / masses[i]);
  double slow = kSlowest * fast;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(slow * fast);
    double added = 0.0;
    for (std::size_t p = 0; p < masses.size(); ++p) added += std::max(0.0, stiffness[p] / middle - masses[p]);
    (added > kAdded ? slow : fast) = middle;
  }
  std::vector<double> smallest;
  smallest.reserve(stiffness.size());
  for (const double s : stiffness) smallest.push_back(s / fast);
  return smallest;
}

}  // namespace

std::vector<double> materialMasses(const SpringNetwork& network) {
  std::vector<double> quarters = quartersOfVolumes(network);
  const double volume = std::accumulate(quarters.begin(), quarters.end(), 0.0);
  for (double& quarter : quarters) quarter /= volume;
  MassProgramme programme =
      massProgramme(network.restPoints, network.surface, solidMoments(network.restPoints, network.surface));
  programme.minFractions = smallestMasses(quarters, stiffnessOfPoints(network));
  for (std::size_t i = 0; i < quarters.size(); ++i)
    programme.maxFractions[i] = std::max(programme.minFractions[i], kLargestGrowth * quarters[i]);
  programme.desired = std::move(quarters);
  return matchMoments(programme).fractions;
}

}  // namespace limber
