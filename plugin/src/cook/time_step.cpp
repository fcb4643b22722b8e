// SPDX-License-Identifier: Zlib
#include "cook/time_step.h"

#include "cook/body_terms.h"
#include "cook/rest_state.h"
#include "solver/stepping_choice.h"

#include <cmath>

namespace limber {
namespace {

constexpr double kResidual = 1e-5;  // of the eigenvalue, whose own error is the square of that

double stepOf(double frequencySquared) {
  return frequencySquared > 0.0 ? 2.0 / std::sqrt(frequencySquared) : HUGE_VAL;
}

}  // namespace

TimeSteps timeSteps(const SpringNetwork& network, const SoftBodySettings& settings) {
  const PointState state = restState(network, settings);
  BodyTerms terms(network, settings);
  const double fastest =
      fastestOscillationSquared(terms.springs, terms.volumes, terms.tetrahedra, state, kResidual);
  return {stepOf(fastest), stepOf(boundSquared(terms, state))};
}

}  // namespace limber
