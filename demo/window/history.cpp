// SPDX-License-Identifier: Zlib
#include "window/history.h"

#include <algorithm>

namespace limber::demo {

TickSample sampleOf(const scenes::TickTimes& times, const Diagnostics& bodies) {
  const TickProfile& soft = times.soft;
  const double parts[kTickParts] = {soft.stepMs, soft.searchMs + soft.islandsMs,
                                    soft.readMs + soft.chooseMs + soft.writeMs + soft.readBackMs,
                                    std::max(times.total - soft.totalMs(), 0.0)};
  TickSample sample;
  for (std::size_t i = 0; i < kTickParts; ++i) sample.ms[i] = static_cast<float>(parts[i]);
  sample.totalMs = static_cast<float>(times.total);
  if (soft.awakeBodies > 0)
    sample.substeps = static_cast<float>(soft.substeps) / static_cast<float>(soft.awakeBodies);
  sample.energy = {static_cast<float>(bodies.kinetic), static_cast<float>(bodies.elastic),
                   static_cast<float>(bodies.potential)};
  sample.errorMm = static_cast<float>(1e3 * bodies.error);
  return sample;
}

void History::add(const TickSample& sample) {
  samples_.push_back(sample);
  if (samples_.size() > kLength) samples_.pop_front();
}

double History::mean(float TickSample::*value) const {
  const std::size_t count = std::min(samples_.size(), static_cast<std::size_t>(scenes::kTicksPerSecond));
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) sum += double(samples_[samples_.size() - 1 - i].*value);
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

}  // namespace limber::demo
