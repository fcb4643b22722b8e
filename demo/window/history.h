// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"
#include "window/session.h"

#include <array>
#include <cstddef>
#include <deque>

namespace limber::demo {

/// The parts of a tick that the plot shows, as TickProfile has them.
constexpr std::size_t kTickParts = 4;
constexpr std::array<const char*, kTickParts> kTickPartNames = {"springs", "contacts", "exchange", "Bullet"};

/// The figures of one tick.
struct TickSample {
  std::array<float, kTickParts> ms{};
  float totalMs = 0.0f;
  float twinMs = 0.0f;            ///< of btSoftBody, with the split
  float substeps = 0.0f;          ///< mean of the awake bodies
  float errorMm = 0.0f;           ///< mm/s, largest SoftBody::errorPerSecond()
  std::array<float, 3> energy{};  ///< J: kinetic, elastic, potential
};

TickSample sampleOf(const scenes::TickTimes& times, const Diagnostics& bodies);

/// The last ticks, for plots.
class History {
 public:
  static constexpr std::size_t kLength = 240;  // ticks

  void add(const TickSample& sample);
  void clear() { samples_.clear(); }
  const std::deque<TickSample>& samples() const { return samples_; }
  /// Returns the mean duration of a tick in the last second, ms.
  double meanMs() const { return mean(&TickSample::totalMs); }
  /// The same of btSoftBody.
  double meanTwinMs() const { return mean(&TickSample::twinMs); }

 private:
  double mean(float TickSample::*value) const;

  std::deque<TickSample> samples_;
};

}  // namespace limber::demo
