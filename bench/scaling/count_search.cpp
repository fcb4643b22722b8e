// SPDX-License-Identifier: Zlib
#include "scaling/count_search.h"

#include <algorithm>

namespace limber::bench {

std::optional<std::uint32_t> CountSearch::next() const {
  if (doubling_) return doubled_;
  if (!foundFailure()) return std::nullopt;
  const double gap = static_cast<double>(failed_ - passed_);
  const double fineEnough = std::max(1.0, settings_.resolution * static_cast<double>(passed_));
  return gap > fineEnough ? std::optional(middle()) : std::nullopt;
}

void CountSearch::report(bool passes) {
  if (doubling_)
    reportDoubled(passes);
  else
    (passes ? passed_ : failed_) = middle();
}

void CountSearch::reportDoubled(bool passes) {
  // what passes by luck after a failure changes nothing
  if (!foundFailure()) (passes ? passed_ : failed_) = doubled_;
  const bool enough = doubled_ == settings_.cap || (foundFailure() && doubled_ >= settings_.always);
  doubling_ = !enough;
  doubled_ = doubled_ > settings_.cap / 2 ? settings_.cap : 2 * doubled_;
}

}  // namespace limber::bench
