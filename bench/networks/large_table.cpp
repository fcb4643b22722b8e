// SPDX-License-Identifier: Zlib
#include "networks/large_table.h"

#include "analysis/analysis.h"
#include "clocks.h"
#include "machine.h"
#include "support/test_shapes.h"
#include "text_format.h"

#include <limber/mesh.h>

#include <algorithm>
#include <stdexcept>

namespace limber::bench {
namespace {

constexpr double kMaxMegabytes = 2048.0;
constexpr std::uint32_t kRunsOfEach = 2;
constexpr std::uint64_t kSeed = 1000;

LargeRow measure(double cell, std::uint32_t points) {
  const Result<TriangleMesh> mesh = simplify(test_shapes::rabbit(cell), points);
  if (!mesh) throw std::runtime_error(mesh.error());
  const Stopwatch watch;
  const Result<SharedNetwork> network = buildNetwork(*mesh);
  if (!network) throw std::runtime_error(network.error());
  LargeRow row{"rabbit", (*network)->restPoints.size()};
  row.seconds = 1e-3 * watch.time().cpuMs;
  row.megabytes = peakMegabytes();
  for (const NetworkSpring& s : (*network)->springs) row.braces += s.kind == SpringKind::Brace ? 1 : 0;
  for (std::size_t kind = 0; kind < kDeformations; ++kind) {
    const ReturnRate rate = measureReturns(**network, static_cast<Deformation>(kind), kRunsOfEach, kSeed);
    row.runs += rate.runs;
    row.returned += rate.returned;
  }
  return row;
}

double timeLimit(const LargeRow& row) { return row.points <= 400 ? 10.0 : 300.0; }

}  // namespace

std::vector<LargeRow> measureLarge() { return {measure(0.03, 300), measure(0.01, 5000)}; }

std::string largeTable(const std::vector<LargeRow>& rows) {
  if (rows.empty()) return {};
  std::string text = "\ncooking small and large\n";
  text += format("%-8s %6s %6s %8s %8s %8s\n", "mesh", "points", "+/n", "return", "s", "MB");
  for (const LargeRow& r : rows)
    text += format("%-8s %6zu %6.2f %4u/%-3u %8.1f %8.0f\n", r.mesh.c_str(), r.points,
                   double(r.braces) / double(r.points), r.returned, r.runs, r.seconds, r.megabytes);
  return text;
}

std::string largeTargets(const std::vector<LargeRow>& rows) {
  std::string text;
  for (const LargeRow& r : rows)
    text += format("  %-4s  %-78s %.1f s, %.0f MB\n",
                   r.seconds <= timeLimit(r) && r.megabytes < kMaxMegabytes ? "hit" : "MISS",
                   format("%zu points cook in at most %.0f s and 2 GiB", r.points, timeLimit(r)).c_str(),
                   r.seconds, r.megabytes);
  return text;
}

}  // namespace limber::bench
