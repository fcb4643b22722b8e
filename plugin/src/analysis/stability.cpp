// SPDX-License-Identifier: Zlib
// Measures the stability of a body of a network against large deformations, and its time steps.

#include "analysis/analysis.h"

#include "network/modes.h"
#include "network/relaxation.h"
#include "solver/springs.h"
#include "solver/stepping_choice.h"
#include "solver/verlet_step.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <thread>
#include <vector>

namespace limber {
namespace {

/// How a run ended.
enum class RunEnd : std::uint8_t { Skipped, Returned, Mirrored, Wrong };

RunEnd endOf(const RelaxedBody& body, const Points& x) {
  if (distanceToRest(body, x) < kReturned) return RunEnd::Returned;
  return distanceToRest(body, -x) < kReturned ? RunEnd::Mirrored : RunEnd::Wrong;
}

ReturnRate rateOf(const std::vector<RunEnd>& ends) {
  const auto count = [&](RunEnd end) {
    return static_cast<std::uint32_t>(std::count(ends.begin(), ends.end(), end));
  };
  const auto runs = static_cast<std::uint32_t>(ends.size()) - count(RunEnd::Skipped);
  return {runs, count(RunEnd::Returned), count(RunEnd::Mirrored)};
}

}  // namespace

std::uint64_t measuringSeed(std::uint64_t seed) { return seed ^ 0x6d65617375726564u; }  // "measured"

ReturnRate measureReturns(const SpringNetwork& network, Deformation kind, std::uint32_t runs,
                          std::uint64_t seed, const Progress& progress, const ParallelFor& parallel) {
  RelaxedBody body(network);
  if (!canRelax(body)) return {};
  std::vector<RunEnd> ends(runs, RunEnd::Skipped);
  std::atomic<std::uint32_t> finished{0};
  const std::thread::id caller = std::this_thread::get_id();
  relax(
      body, runs, [&](std::size_t run) { return deform(body.rest, kind, measuringSeed(seed), run); },
      [&](std::size_t run, const Points& x) {
        ends[run] = endOf(body, x);
        const double done = static_cast<double>(++finished) / runs;
        return !progress || std::this_thread::get_id() != caller || progress("return rate", done);
      },
      parallel);
  return rateOf(ends);
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
