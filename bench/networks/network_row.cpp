// SPDX-License-Identifier: Zlib
#include "networks/network_row.h"

#include "csv_table.h"
#include "text_format.h"

namespace limber::bench {
namespace {

const char* const kKinds[kDeformations] = {"squash", "twist",   "noise",    "push",
                                           "mirror", "flatten", "inversion"};

std::string measured(double value) { return value < 0.0 ? std::string() : numberCell(value); }

}  // namespace

std::vector<std::string> networkColumns() {
  std::vector<std::string> columns = {"mesh",        "points",        "edges",      "braces",      "rule",
                                      "return_rate", "runs",          "mode_ratio", "isotropy",    "outside",
                                      "seconds",     "mechanisms",    "rank",       "self_stress", "softest",
                                      "stiffest",    "globally_rigid"};
  for (const char* kind : kKinds) columns.push_back(std::string("return_") + kind);
  return columns;
}

std::vector<std::string> networkCells(const NetworkRow& row) {
  const NetworkAnalysis& a = row.analysis;
  std::vector<std::string> cells = {row.mesh,
                                    countCell(row.points),
                                    countCell(row.edges),
                                    countCell(row.braces),
                                    row.rule,
                                    numberCell(a.allReturns().rate()),
                                    countCell(a.allReturns().runs),
                                    numberCell(a.modeRatio),
                                    measured(row.isotropy),
                                    countCell(a.springsOutside),
                                    numberCell(row.seconds),
                                    countCell(a.mechanisms),
                                    countCell(a.rank),
                                    countCell(a.selfStresses),
                                    numberCell(a.softestEigenvalue),
                                    numberCell(a.stiffestEigenvalue),
                                    a.globallyRigidKnown ? (a.globallyRigid ? "1" : "0") : ""};
  for (const ReturnRate& rate : a.returns) cells.push_back(numberCell(rate.rate()));
  return cells;
}

std::string networkHeading() {
  return format("%-9s %-9s %5s %6s %5s | %7s %5s | %4s %4s %4s %4s %4s %4s %4s | %8s %5s %4s %7s\n", "mesh",
                "rule", "n", "edges", "+/n", "return", "runs", "sqsh", "twst", "nois", "push", "mirr", "flat",
                "invt", "l1/lmax", "isotr", "out", "s");
}

std::string networkLine(const NetworkRow& row) {
  const NetworkAnalysis& a = row.analysis;
  std::string line =
      format("%-9s %-9s %5zu %6zu %5.2f | %6.1f%% %5u |", row.mesh.c_str(), row.rule.c_str(), row.points,
             row.edges, row.perPoint(), 100.0 * a.allReturns().rate(), a.allReturns().runs);
  for (const ReturnRate& rate : a.returns) line += format(" %4.0f", 100.0 * rate.rate());
  return line + format(" | %8.1e %5s %4zu %7.2f\n", a.modeRatio,
                       row.isotropy < 0.0 ? "" : format("%.2f", row.isotropy).c_str(), a.springsOutside,
                       row.seconds);
}

}  // namespace limber::bench
