// SPDX-License-Identifier: Zlib
#include "scenes/rest_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limber::scenes {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// not a number counts as infinitely far
double diagonal(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return 0.0;
  const double length = box.diagonal().norm();
  return std::isfinite(length) ? length : kInfinity;
}

}  // namespace

void RestWatch::look(const SoftBodySystem& soft) {
  if (ticks_++ % kWindowTicks == 0) {
    before_ = std::move(present_);
    present_.clear();
  }
  firstPoint_.assign(1, 0);
  for (std::size_t b = 0; b < soft.bodyCount(); ++b) {
    firstPoint_.push_back(firstPoint_.back() + soft.body(b)->pointCount());
  }
  present_.resize(firstPoint_.back());
  for (std::size_t b = 0; b < soft.bodyCount(); ++b) {
    for (std::uint32_t i = 0; i < soft.body(b)->pointCount(); ++i) {
      present_[firstPoint_[b] + i].extend(soft.body(b)->position(i));
    }
  }
}

double RestWatch::largestMotion(std::size_t body) const {
  if (before_.size() != present_.size() || body + 1 >= firstPoint_.size()) return kInfinity;
  double largest = 0.0;
  for (std::size_t i = firstPoint_[body]; i < firstPoint_[body + 1]; ++i) {
    largest = std::max({largest, diagonal(present_[i]), diagonal(before_[i])});
  }
  return largest;
}

double RestWatch::largestMotion() const {
  if (firstPoint_.size() < 2) return kInfinity;
  double largest = 0.0;
  for (std::size_t b = 0; b + 1 < firstPoint_.size(); ++b) largest = std::max(largest, largestMotion(b));
  return largest;
}

}  // namespace limber::scenes
