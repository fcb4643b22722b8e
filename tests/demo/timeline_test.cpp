// SPDX-License-Identifier: Zlib
#include "scenes/scene.h"

#include <gtest/gtest.h>

namespace limber::scenes {
namespace {

TEST(Timeline, wholeSecondsAreWholeTicks) { EXPECT_EQ(timelineOf(6.0, 30).ticks, 360); }

TEST(Timeline, roundingAddsNoTick) {
  EXPECT_EQ(timelineOf(0.1, 30).ticks, 6);
  EXPECT_EQ(timelineOf(0.7, 30).ticks, 42);
  EXPECT_EQ(timelineOf(0.11, 30).ticks, 7);
}

TEST(Timeline, twoTicksAFrameAtThirty) {
  const Timeline timeline = timelineOf(2.0, 30);
  EXPECT_EQ(timeline.frameCount(), 61);
  for (std::int64_t k = 0; k < timeline.frameCount(); ++k) {
    EXPECT_EQ(timeline.ticksFor(k), 2 * k);
    EXPECT_EQ(timeline.tickFraction(k), 1.0);
  }
}

TEST(Timeline, ratesThatDoNotDivideSixtyKeepTime) {
  for (const int fps : {1, 7, 24, 25, 50, 59, 144, 240}) {
    const Timeline timeline = timelineOf(5.0, fps);
    EXPECT_EQ(timeline.frameCount(), 5 * fps + 1);
    EXPECT_EQ(timeline.ticksFor(timeline.frameCount() - 1), timeline.ticks) << fps;
    for (std::int64_t k = 0; k < timeline.frameCount(); ++k) {
      const double exact = static_cast<double>(k) * 60.0 / fps;
      EXPECT_NEAR(static_cast<double>(timeline.ticksFor(k)) - 1.0 + timeline.tickFraction(k), exact, 1e-9);
      EXPECT_GT(timeline.tickFraction(k), 0.0);
      EXPECT_LE(timeline.tickFraction(k), 1.0);
    }
  }
}

TEST(Timeline, noFrameLiesBeyondTheEnd) {
  const Timeline timeline = timelineOf(0.11, 7);
  EXPECT_LE(timeline.ticksFor(timeline.frameCount() - 1), timeline.ticks);
  EXPECT_GT(timeline.ticksFor(timeline.frameCount()), timeline.ticks);
}

}  // namespace
}  // namespace limber::scenes
