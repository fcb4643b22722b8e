// SPDX-License-Identifier: Zlib
#include "accuracy/accuracy_row.h"

#include "csv_table.h"

namespace limber::bench {

std::vector<std::string> accuracyColumns() {
  return {"scene",   "engine", "setting",  "dt",   "error",  "us_per_tick",
          "us_step", "hash",   "us_noise", "kind", "measure"};
}

std::vector<std::string> accuracyCells(const AccuracyRow& row) {
  return {row.scene,
          row.engine,
          row.setting,
          numberCell(row.dt),
          numberCell(row.error),
          numberCell(row.tickMicroseconds),
          numberCell(row.stepMicroseconds),
          hexCell(row.hash),
          numberCell(row.noise),
          row.kind == Kind::Free ? "free" : "contact",
          row.measure};
}

}  // namespace limber::bench
