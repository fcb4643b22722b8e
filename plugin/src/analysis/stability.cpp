// SPDX-License-Identifier: Zlib
// Measures the stability of a body of a network against large deformations, and its time steps.

#include "analysis/analysis.h"

#include "network/modes.h"
#include "network/relaxation.h"
#include "solver/springs.h"
#include "solver/stepping_choice.h"
#include "solver/verlet_step.h"

#include <cmath>

namespace limber {
namespace {

void count(ReturnRate& rate, const RelaxedBody& body, const Points& x) {
  ++rate.runs;
  if (distanceToRest(body, x) < kReturned)
    ++rate.returned;
  else if (distanceToRest(body, -x) < kReturned)
    ++rate.mirrored;
}

}  // namespace

std::uint64_t measuringSeed(std::uint64_t seed) { return seed ^ 0x6d65617375726564u; }  // "measured"

ReturnRate measureReturns(const SpringNetwork& network, Deformation kind, std::uint32_t runs,
                          std::uint64_t seed, const Progress& progress) {
  RelaxedBody body(network);
  ReturnRate rate;
  if (!canRelax(body)) return rate;
  relax(
      body, runs, [&](std::size_t run) { return deform(body.rest, kind, measuringSeed(seed), run); },
      [&](std::size_t, const Points& x) {
        count(rate, body, x);
        return !progress || progress("return rate", static_cast<double>(rate.runs) / runs);
      });
  return rate;
}

namespace {

constexpr double kResidual = 1e-5;  // relative to the eigenvalue, whose own error is the square of that

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
