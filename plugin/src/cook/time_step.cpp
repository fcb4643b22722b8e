// SPDX-License-Identifier: Zlib
#include "cook/time_step.h"

#include "cook/body_terms.h"
#include "cook/largest_eigenvalue.h"
#include "cook/rest_state.h"
#include "cook/stiffness_matrix.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::VectorXd;

/// sqrt(stiffness) times the gradient of each component's volume at rest: the volume term's stiffness matrix
/// is the sum of their squares g g^T, for at rest it has no force.
std::vector<VectorXd> volumeGradients(const VolumeArrays& volumes, const PointState& state) {
  std::vector<VectorXd> gradients;
  Points gradient = Points::Zero(3, state.position.cols());
  for (std::size_t c = 0; c < volumes.restVolume.size(); ++c) {
    const VolumeSlope slope = volumeSlope(volumes, c, state, gradient);
    gradients.push_back(std::sqrt(slope.stiffness) * gradient.reshaped());
  }
  return gradients;
}

/// The same of the tetrahedra, which have four points each: one sparse matrix of all.
SparseMatrix tetrahedronStiffness(const TetrahedronVolumes& volumes, const PointState& state) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < volumes.tetrahedra.size(); ++i) {
    const TetrahedronSlope slope = tetrahedronSlope(volumes, i, state.position);
    const auto row = [&](Eigen::Index k) {
      return static_cast<int>(3 * volumes.tetrahedra[i][static_cast<std::size_t>(k / 3)] + k % 3);
    };
    for (Eigen::Index j = 0; j < 12; ++j)
      for (Eigen::Index k = 0; k < 12; ++k)
        entries.emplace_back(row(j), row(k),
                             slope.stiffness * slope.gradient.data()[j] * slope.gradient.data()[k]);
  }
  SparseMatrix stiffness(state.position.size(), state.position.size());
  stiffness.setFromTriplets(entries.begin(), entries.end());
  return stiffness;
}

/// The stiffness matrix of the springs of a body with these settings.
SparseMatrix springStiffness(SpringNetwork network, const SoftBodySettings& settings) {
  for (Eigen::Vector3d& p : network.restPoints) p = p.cwiseProduct(settings.scale);
  return std::max(settings.extensionStiffness, settings.compressionStiffness) *
         stiffnessMatrix(rigidityMatrix(network));
}

double stepOf(double frequencySquared) {
  return frequencySquared > 0.0 ? 2.0 / std::sqrt(frequencySquared) : HUGE_VAL;
}

}  // namespace

TimeSteps timeSteps(const SpringNetwork& network, const SoftBodySettings& settings) {
  const PointState state = restState(network, settings);
  BodyTerms terms(network, settings);
  SparseMatrix stiffness = springStiffness(network, settings);
  if (!terms.tetrahedra.empty()) stiffness += tetrahedronStiffness(terms.tetrahedra, state);
  const std::vector<VectorXd> gradients = volumeGradients(terms.volumes, state);
  const VectorXd root = state.inverseMass.reshaped().cwiseSqrt();

  // omega^2 are the eigenvalues of  M^-1/2 K M^-1/2
  const double fastest = largestEigenvalue(
      [&](const VectorXd& v) -> VectorXd {
        const VectorXd u = root.cwiseProduct(v);
        VectorXd force = stiffness * u;
        for (const VectorXd& g : gradients) force += g.dot(u) * g;
        return root.cwiseProduct(force);
      },
      stiffness.rows());

  return {stepOf(fastest), stepOf(boundSquared(terms, state))};
}

}  // namespace limber
