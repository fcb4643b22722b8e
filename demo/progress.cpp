// SPDX-License-Identifier: Zlib
#include "progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace limber::demo {

Progress::Progress(std::FILE* stream, bool terminal, std::string label)
    : stream_(stream),
      terminal_(terminal),
      label_(label.empty() ? label : label + " "),
      start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (terminal_ && shown_ >= 0 && shown_ < 100) std::fputc('\n', stream_);
}

void Progress::show(long long done, long long total) {
  const double share = total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 1.0;
  if (terminal_)
    showBar(share);
  else
    showLine(share);
}

double Progress::secondsLeft(double share) const {
  return share > 0.0 ? secondsSince(start_) * (1.0 - share) / share : 0.0;
}

void Progress::showBar(double share) {
  const int percent = static_cast<int>(100.0 * share);
  if (percent == shown_) return;
  shown_ = percent;
  const std::string left = percent > 0 && percent < 100 ? durationText(secondsLeft(share)) + " left" : "";
  // the padding overwrites the rest of a longer line
  std::fprintf(stream_, "\r%s%s %3d %%  %-20s", label_.c_str(), barText(share, 30).c_str(), percent,
               left.c_str());
  if (share >= 1.0) std::fputc('\n', stream_);
  std::fflush(stream_);
}

void Progress::showLine(double share) {
  const int tens = static_cast<int>(10.0 * share);
  if (tens == shown_ || tens == 0) return;
  shown_ = tens;
  const std::string left = tens < 10 ? ", " + durationText(secondsLeft(share)) + " left" : "";
  std::fprintf(stream_, "%s%3d %%%s\n", label_.c_str(), 10 * tens, left.c_str());
  std::fflush(stream_);
}

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

bool isTerminal(std::FILE* stream) {
  const char* kind = std::getenv("TERM");
  return isatty(fileno(stream)) && kind && std::strcmp(kind, "dumb") != 0;
}

std::string durationText(double seconds) {
  const int whole = static_cast<int>(std::ceil(std::clamp(seconds, 0.0, 1e8)));
  char text[40];
  if (whole < 60)
    std::snprintf(text, sizeof text, "%d s", whole);
  else
    std::snprintf(text, sizeof text, "%d min %02d s", whole / 60, whole % 60);
  return text;
}

std::string barText(double share, int width) {
  const int full = static_cast<int>(std::clamp(share, 0.0, 1.0) * width);
  const auto count = [](int n) { return static_cast<std::size_t>(n); };
  return "[" + std::string(count(full), '#') + std::string(count(width - full), '-') + "]";
}

namespace {

constexpr long long kSteps = 1000;
constexpr std::size_t kLabelWidth = 22;  // so that the bars are aligned

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
  if (!open_ && secondsSince(start_) < patience_) return;
  bar_->show(steps, kSteps);
  open_ = true;
}

void StageProgress::finish() {
  if (open_) bar_->show(kSteps, kSteps);
  open_ = false;
}

}  // namespace limber::demo
