// SPDX-License-Identifier: Zlib
#include "cook/stage_progress.h"

#include <algorithm>

namespace limber::demo {
namespace {

constexpr long long kSteps = 1000;
constexpr std::size_t kLabelWidth = 18;  // so that the bars stand below each other

std::string padded(const std::string& label) {
  return label + std::string(kLabelWidth - std::min(kLabelWidth, label.size()), ' ');
}

}  // namespace

void StageProgress::show(const std::string& stage, double done) {
  if (!bar_ || stage != stage_) {
    finish();
    bar_.emplace(stream_, terminal_, padded(stage));
    stage_ = stage;
    full_ = false;
  }
  if (full_) return;
  const auto steps = static_cast<long long>(std::clamp(done, 0.0, 1.0) * kSteps);
  bar_->show(steps, kSteps);
  full_ = steps == kSteps;
}

void StageProgress::finish() {
  if (!full_) bar_->show(kSteps, kSteps);
  full_ = true;
}

}  // namespace limber::demo
