// SPDX-License-Identifier: Zlib
// Declares the fit of spring constants to the response of a solid body.
#pragma once

#include "network/solid_responses.h"

#include <limber/spring_network.h>

#include <functional>
#include <vector>

namespace limber {

/// Smallest and largest constant (N/m) of each spring; above 0.
struct SpringLimits {
  std::vector<double> smallest, largest;
};

/// Changes the stiffnessScale of each spring, which is its constant (N/m) here, so that the network responds
/// to the loads like the solid. Minimises
///     sum over entries of the compliance |weight (measured - wanted)|^2
///     + kChangeWeight sum over springs share log(k / k0)^2
/// with the present constants k0 and the springs' shares of the sum of k L^2. Uses the method of Levenberg
/// and Marquardt for log k within the limits; each step is solved by conjugate gradients. The derivative of
/// the compliance of loads i, j is  -e_i e_j  for the constant of a spring with the extensions e. `goOn` is
/// called with the progress, 0 to 1; after it has returned false, no further steps are made.
void fitResponses(SpringNetwork& network, const SolidResponses& wanted, const SpringLimits& limits,
                  const std::function<bool(double)>& goOn = {});

}  // namespace limber
