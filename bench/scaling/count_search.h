// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace limber::bench {

struct CountSearchSettings {
  std::uint32_t always = 1;   ///< counts up to here are doubled through even after the first failure
  std::uint32_t cap = 65536;  ///< no count is larger
  double resolution = 0.05;   ///< share of the answer at which bisecting ends
};

/// Finds the largest count that passes a test: 1, 2, 4 ... until one fails, then bisecting between the last
/// that passed and the first that failed. Ask next(), try it, report; until next() is empty.
class CountSearch {
 public:
  explicit CountSearch(const CountSearchSettings& settings) : settings_(settings) {}

  /// The count to try, or nothing when the search is over.
  std::optional<std::uint32_t> next() const {
    if (doubling_) return doubled_;
    const double fineEnough = std::max(1.0, settings_.resolution * passed_);
    const bool isOver = !foundFailure() || double(failed_ - passed_) <= fineEnough;
    return isOver ? std::nullopt : std::optional(middle());
  }

  /// Whether the count that next() gives passes.
  void report(bool passes) {
    // what passes by luck after a failure changes nothing
    if (!doubling_ || !foundFailure()) (passes ? passed_ : failed_) = doubling_ ? doubled_ : middle();
    if (!doubling_) return;
    doubling_ = doubled_ != settings_.cap && !(foundFailure() && doubled_ >= settings_.always);
    doubled_ = doubled_ > settings_.cap / 2 ? settings_.cap : 2 * doubled_;
  }

  std::uint32_t largest() const { return passed_; }   ///< so far; 0: not even one passes
  bool foundFailure() const { return failed_ != 0; }  ///< false at the end: the cap passes

 private:
  std::uint32_t middle() const { return passed_ + (failed_ - passed_) / 2; }

  CountSearchSettings settings_;
  bool doubling_ = true;
  std::uint32_t doubled_ = 1;
  std::uint32_t passed_ = 0;
  std::uint32_t failed_ = 0;  // 0: none yet
};

}  // namespace limber::bench
