// SPDX-License-Identifier: Zlib
#include "timing.h"

#include <gtest/gtest.h>

namespace limber::bench {
namespace {

TEST(SampleStats, noSamples) {
  EXPECT_EQ(sum({}), 0.0);
  EXPECT_EQ(mean({}), 0.0);
  EXPECT_EQ(median({}), 0.0);
  EXPECT_EQ(largest({}), 0.0);
}

TEST(SampleStats, oddNumber) {
  EXPECT_EQ(mean({9.0, 1.0, 2.0}), 4.0);
  EXPECT_EQ(median({9.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(largest({1.0, 9.0, 2.0}), 9.0);
}

TEST(SampleStats, evenNumber) {
  EXPECT_EQ(sum({4.0, 1.0, 3.0, 20.0}), 28.0);
  EXPECT_EQ(median({4.0, 1.0, 3.0, 20.0}), 3.5);
}

TEST(SampleStats, largestOfNegatives) { EXPECT_EQ(largest({-3.0, -1.0}), -1.0); }

}  // namespace
}  // namespace limber::bench
