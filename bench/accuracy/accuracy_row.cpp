// SPDX-License-Identifier: Zlib
#include "accuracy/accuracy_row.h"

#include "csv_table.h"

#include <algorithm>
#include <iterator>

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

// --- queries --------------------------------------------------------------------------------

namespace {

bool lessError(const AccuracyRow& a, const AccuracyRow& b) { return a.error < b.error; }

}  // namespace

Rows select(const Rows& rows, const Condition& condition) {
  Rows chosen;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(chosen), condition);
  return chosen;
}

std::optional<AccuracyRow> best(const Rows& rows) {
  const auto row = std::min_element(rows.begin(), rows.end(), lessError);
  return row == rows.end() ? std::nullopt : std::optional(*row);
}

std::optional<AccuracyRow> worst(const Rows& rows) {
  const auto row = std::max_element(rows.begin(), rows.end(), lessError);
  return row == rows.end() ? std::nullopt : std::optional(*row);
}

std::vector<std::pair<std::string, std::string>> subjects(const Rows& rows) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const AccuracyRow& row : rows) {
    const std::pair<std::string, std::string> subject(row.scene, row.measure);
    if (std::find(pairs.begin(), pairs.end(), subject) == pairs.end()) pairs.push_back(subject);
  }
  return pairs;
}

bool isUsual(const AccuracyRow& row) { return std::abs(row.dt - kUsualTick) < 1e-9; }

bool isLimber(const AccuracyRow& row, const std::string& setting) {
  return row.engine == "limber" && row.setting == setting;
}

bool startsWith(const std::string& text, const std::string& start) { return text.rfind(start, 0) == 0; }

}  // namespace limber::bench
