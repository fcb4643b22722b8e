// SPDX-License-Identifier: Zlib
#include "cook/time_step.h"

#include "cook/largest_eigenvalue.h"
#include "cook/rest_state.h"
#include "cook/stiffness_matrix.h"
#include "core/spring_arrays.h"
#include "core/stepping_choice.h"
#include "core/volume_term.h"

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

/// The stiffness matrix of the springs of a body with these settings.
SparseMatrix bodyStiffness(SpringNetwork network, const SoftBodySettings& settings) {
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
  const SparseMatrix stiffness = bodyStiffness(network, settings);
  VolumeArrays volumes = makeVolumes(network, settings);
  const std::vector<VectorXd> gradients = volumeGradients(volumes, state);
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

  std::vector<double> sums;
  const SpringArrays springs = makeSprings(network, settings);
  double bound = frequencyBoundSquared(springs, state.inverseMass, sums);
  if (!volumes.empty()) bound += volumeFrequencyBoundSquared(volumes, state, 0.0);
  return {stepOf(fastest), stepOf(bound)};
}

}  // namespace limber
