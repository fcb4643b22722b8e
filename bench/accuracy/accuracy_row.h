// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

#include <optional>
#include <utility>

namespace limber::bench {

/// One error of one engine in one scene, with one length of the ticks.
struct AccuracyRow {
  std::string scene, engine, setting;
  double dt = 0.0;                ///< s
  double error = 0.0;             ///< infinite: the points are lost
  double tickMicroseconds = 0.0;  ///< median, for the whole world
  double stepMicroseconds = 0.0;  ///< median, for the springs; in other engines for the whole tick
  std::uint64_t hash = 0;         ///< of the final state
  double noise = 0.0;             ///< us; half of the ticks deviate less than this from the median
  Kind kind = Kind::Free;
  std::string measure;   ///< name of the error
  int substeps = 1;      ///< multiple of the stable number of substeps, in Limber's finer runs
  bool ordered = false;  ///< errors should shrink with the step
};

std::vector<std::string> accuracyColumns();
std::vector<std::string> accuracyCells(const AccuracyRow& row);

// --- queries --------------------------------------------------------------------------------

constexpr double kUsualTick = 1.0 / 60;

using Rows = std::vector<AccuracyRow>;
using Condition = std::function<bool(const AccuracyRow&)>;

Rows select(const Rows& rows, const Condition& condition);

/// Returns the row with the smallest error, if there is one.
std::optional<AccuracyRow> best(const Rows& rows);
/// Returns the row with the largest error, if there is one.
std::optional<AccuracyRow> worst(const Rows& rows);

/// Returns all pairs of scene and measure, in the order of the rows.
std::vector<std::pair<std::string, std::string>> subjects(const Rows& rows);

bool isUsual(const AccuracyRow& row);  ///< 60 ticks a second
bool isLimber(const AccuracyRow& row, const std::string& setting);
bool startsWith(const std::string& text, const std::string& start);

}  // namespace limber::bench
