// SPDX-License-Identifier: Zlib
#include "scene/reference.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber::bench {
namespace {

Signal cosine(double period, double dt, double seconds) {
  Signal signal{dt, {}};
  for (int i = 0; i * dt <= seconds; ++i) signal.samples.push_back(std::cos(2 * M_PI * i * dt / period));
  return signal;
}

TEST(Signal, periodOfACosineAtFifteenSamplesAPeriod) {
  const Signal signal = cosine(0.497, 1.0 / 30, 5.2);
  EXPECT_EQ(fallsThroughZero(signal).size(), 11u);
  EXPECT_NEAR(period(signal), 0.497, 1e-6 * 0.497);
}

TEST(Signal, amplitudeIsFoundBetweenSamples) {
  const Signal signal = cosine(0.497, 1.0 / 30, 5.2);
  EXPECT_NEAR(amplitude(signal, 4.0, 5.0), 1.0, 1e-4);
  EXPECT_EQ(amplitude(Signal{0.1, {0, 0, 0, 0}}, 0, 1), 0.0);
}

TEST(Signal, noPeriodWithoutSwinging) {
  EXPECT_TRUE(std::isinf(period(Signal{0.1, {3, 2, 1, 0.5, 0.2, 0.1, 0.05}})));
  EXPECT_TRUE(std::isinf(period(Signal{0.1, {1, -1, -2, -3}})));
}

TEST(Signal, firstReachesALevelEitherWay) {
  const Signal line{0.5, {0, 1, 2, 3, 4, 5, 6, 7}};
  EXPECT_NEAR(firstReaches(line, 2.5), 1.25, 1e-9);
  EXPECT_NEAR(firstReaches(cosine(1.0, 0.02, 1.0), 0.5), 1.0 / 6, 1e-6);
  EXPECT_TRUE(std::isinf(firstReaches(line, 8.0)));
  EXPECT_TRUE(std::isinf(firstReaches(line, 2.5, 2.0)));
}

}  // namespace
}  // namespace limber::bench
