// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/accuracy_row.h"

#include <optional>
#include <utility>

namespace limber::bench {

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
