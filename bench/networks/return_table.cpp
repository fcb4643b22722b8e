// SPDX-License-Identifier: Zlib
#include "networks/return_table.h"

#include "clocks.h"
#include "network/bracing.h"
#include "network/material.h"

#include <algorithm>
#include <random>
#include <set>
#include <stdexcept>

namespace limber::bench {
namespace {

SharedNetwork cook(const TriangleMesh& mesh, BraceRule rule) {
  NetworkSettings settings;
  settings.braces = rule;
  Result<SharedNetwork> network = buildNetwork(mesh, settings);
  if (!network) throw std::runtime_error(network.error());
  return *network;
}

bool inOrder(const NetworkSpring& s, const NetworkSpring& t) { return s.a != t.a ? s.a < t.a : s.b < t.b; }

/// As many braces as asked for between random pairs that have no spring.
SharedNetwork withRandomBraces(const SpringNetwork& bare, std::size_t braces, double weight) {
  auto network = std::make_shared<SpringNetwork>(bare);
  std::set<std::pair<std::uint32_t, std::uint32_t>> taken;
  for (const NetworkSpring& s : bare.springs) taken.emplace(s.a, s.b);
  std::mt19937_64 engine(7);
  const std::size_t points = bare.restPoints.size();
  const std::size_t most = std::min(braces, points * (points - 1) / 2 - bare.springs.size());
  while (network->springs.size() < bare.springs.size() + most) {
    const auto a = static_cast<std::uint32_t>(engine() % points),
               b = static_cast<std::uint32_t>(engine() % points);
    if (a == b || !taken.emplace(std::min(a, b), std::max(a, b)).second) continue;
    network->springs.push_back({std::min(a, b), std::max(a, b), SpringKind::Brace, weight});
  }
  std::sort(network->springs.begin(), network->springs.end(), inOrder);
  return network;
}

SharedNetwork networkOf(const ReturnQuestion& q, const NetworkRow* as) {
  const TriangleMesh mesh = q.shape.make();
  if (q.rule == "none") return cook(mesh, BraceRule::None);
  if (q.rule == "equal") return cook(mesh, BraceRule::EqualLength);
  if (q.rule == "two-ring") return cook(mesh, BraceRule::TwoRing);
  if (q.rule == "pipeline") return cook(mesh, BraceRule::Pipeline);
  return withRandomBraces(*cook(mesh, BraceRule::None), as ? as->braces : 0, kPipelineWeight);
}

std::size_t countBraces(const SpringNetwork& network) {
  return static_cast<std::size_t>(std::count_if(network.springs.begin(), network.springs.end(),
                                                [](const auto& s) { return s.kind == SpringKind::Brace; }));
}

}  // namespace

const std::vector<std::string>& braceRules() {
  static const std::vector<std::string> kRules = {"none", "equal", "two-ring", "pipeline", "random"};
  return kRules;
}

NetworkRow measureReturns(const ReturnQuestion& q, const NetworkRow* as) {
  NetworkRow row;
  row.mesh = q.shape.name;
  row.rule = q.rule;
  const Stopwatch watch;
  const SharedNetwork network = networkOf(q, as);
  row.seconds = 1e-3 * watch.time().cpuMs;
  row.points = network->restPoints.size();
  row.braces = countBraces(*network);
  row.edges = network->springs.size() - row.braces;
  AnalysisSettings settings;
  settings.runs = (q.runs + 4) / 5;
  settings.seed = q.seed;
  row.analysis = analyse(*network, settings);
  row.isotropy = measureModuli({*network}).isotropy;
  return row;
}

}  // namespace limber::bench
