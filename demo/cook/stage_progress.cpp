// SPDX-License-Identifier: Zlib
#include "cook/stage_progress.h"

#include <algorithm>

namespace limber::demo {
namespace {

constexpr long long kSteps = 1000;
constexpr std::size_t kLabelWidth = 22;  // so that the bars stand below each other

std::string padded(const std::string& label) {
  return label + std::string(kLabelWidth - std::min(kLabelWidth, label.size()), ' ');
}

}  // namespace

void StageProgress::begin(const std::string& stage) {
  finish();
  bar_.emplace(stream_, terminal_, padded(stage));
  stage_ = stage;
  steps_ = 0;
  start_ = std::chrono::steady_clock::now();
}

void StageProgress::show(const std::string& stage, double done) {
  const auto steps = static_cast<long long>(std::clamp(done, 0.0, 1.0) * kSteps);
  if (!bar_ || stage != stage_ || steps < steps_) begin(stage);
  steps_ = steps;
  if (steps == kSteps) return finish();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  if (!open_ && elapsed.count() < patience_) return;
  bar_->show(steps, kSteps);
  open_ = true;
}

void StageProgress::finish() {
  if (open_) bar_->show(kSteps, kSteps);
  open_ = false;
}

}  // namespace limber::demo
