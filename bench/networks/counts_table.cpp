// SPDX-License-Identifier: Zlib
#include "networks/counts_table.h"

#include "analysis/analysis.h"
#include "support/network_shapes.h"
#include "text_format.h"

namespace limber::bench {
namespace {

using namespace network_shapes;

/// Cauchy, Dehn, Alexandrov: convex without points inside flat faces, no mechanism; each such point adds one,
/// and one self-stress. A torus has six self-stresses by Euler's formula, a grid and a rope count for
/// themselves.
struct Expected {
  const char* name;
  SharedNetwork network;
  std::size_t mechanisms, selfStresses;
};

std::vector<Expected> expectedCounts() {
  return {{"cube8", bare(cube8()), 0, 0},         {"cube26", bare(cube26()), 6, 6},
          {"cube98", bare(cube98()), 54, 54},     {"ico42", bare(ico42()), 0, 0},
          {"ico162", bare(ico162()), 0, 0},       {"ico642", bare(ico642()), 0, 0},
          {"torus128", bare(torus128()), 0, 6},   {"hull60", bare(hull60()), 0, 0},
          {"cyl62", bare(cyl62()), 2, 2},         {"cyl60", bare(cyl60()), 0, 0},
          {"lshape90", bare(lshape90()), 36, 36}, {"star162", bare(star162()), 0, 0},
          {"noise162", bare(noise162()), 0, 0},   {"rabbit302", bare(rabbit302()), 0, 0},
          {"cloth100", bare(cloth100()), 97, 64}, {"rope20", rope20(), 36, 0},
          {"tube60", bare(tube60()), 0, 0}};
}

}  // namespace

std::vector<CountRow> measureCounts() {
  std::vector<CountRow> rows;
  for (const Expected& e : expectedCounts()) {
    const SmallDeformations s = smallDeformations(*e.network);
    rows.push_back({e.name, e.network->restPoints.size(), e.network->springs.size(), s.rank, s.mechanisms,
                    s.selfStresses, e.mechanisms, e.selfStresses, s.softest, s.stiffest});
  }
  return rows;
}

std::string countTable(const std::vector<CountRow>& rows) {
  std::string text = "edges alone, small deformations: counted (expected)\n";
  text += format("%-10s %6s %7s %6s %12s %12s %9s %9s\n", "mesh", "points", "springs", "rank", "mechanisms",
                 "self-stress", "softest", "stiffest");
  for (const CountRow& r : rows)
    text += format("%-10s %6zu %7zu %6zu %6zu (%3zu) %6zu (%3zu) %9.2e %9.2f\n", r.mesh.c_str(), r.points,
                   r.springs, r.rank, r.mechanisms, r.expectedMechanisms, r.selfStresses,
                   r.expectedSelfStresses, r.softest, r.stiffest);
  return text;
}

}  // namespace limber::bench
