// SPDX-License-Identifier: Zlib
#include "scaling/count_search.h"

#include <gtest/gtest.h>

#include <vector>

namespace limber::bench {
namespace {

/// Returns the counts that the search requests if those up to `limit` pass.
std::vector<std::uint32_t> run(CountSearch& search, std::uint32_t limit) {
  std::vector<std::uint32_t> requested;
  while (const auto count = search.next()) {
    requested.push_back(*count);
    search.report(*count <= limit);
    if (requested.size() > 100) break;  // endless search
  }
  return requested;
}

using Counts = std::vector<std::uint32_t>;

TEST(CountSearch, doublesThenBisectsToTheLastThatPasses) {
  CountSearch search({1, 1000, 0.0});
  EXPECT_EQ(run(search, 11), (Counts{1, 2, 4, 8, 16, 12, 10, 11}));
  EXPECT_EQ(search.largest(), 11u);
  EXPECT_TRUE(search.foundFailure());
}

TEST(CountSearch, findsEveryLimit) {
  for (std::uint32_t limit = 0; limit <= 300; ++limit) {
    CountSearch search({1, 1000, 0.0});
    run(search, limit);
    EXPECT_EQ(search.largest(), limit);
  }
}

TEST(CountSearch, stopsAtTheResolution) {
  CountSearch search({1, 1u << 20, 0.05});
  run(search, 70000);
  EXPECT_LE(search.largest(), 70000u);
  EXPECT_GE(search.largest(), 66500u);
}

TEST(CountSearch, nothingPasses) {
  CountSearch search({1, 1000, 0.05});
  EXPECT_EQ(run(search, 0), Counts{1});
  EXPECT_EQ(search.largest(), 0u);
  EXPECT_TRUE(search.foundFailure());
}

TEST(CountSearch, doublesOnThroughWhatIsAlwaysMeasured) {
  CountSearch search({16, 1000, 0.05});
  EXPECT_EQ(run(search, 3), (Counts{1, 2, 4, 8, 16, 3}));
  EXPECT_EQ(search.largest(), 3u);
}

TEST(CountSearch, passingAfterAFailureIsLuck) {
  CountSearch search({8, 8, 0.05});
  for (const bool passes : {true, false, true, true}) search.report(passes);
  EXPECT_FALSE(search.next());
  EXPECT_EQ(search.largest(), 1u);
}

TEST(CountSearch, capNeedsNoPowerOfTwo) {
  CountSearch search({1, 6, 0.05});
  EXPECT_EQ(run(search, 1000), (Counts{1, 2, 4, 6}));
  EXPECT_EQ(search.largest(), 6u);
  EXPECT_FALSE(search.foundFailure());
}

TEST(CountSearch, capFails) {
  CountSearch search({1, 6, 0.0});
  EXPECT_EQ(run(search, 4), (Counts{1, 2, 4, 6, 5}));
  EXPECT_EQ(search.largest(), 4u);
}

TEST(CountSearch, capOfOne) {
  CountSearch search({64, 1, 0.05});
  EXPECT_EQ(run(search, 1000), Counts{1});
  EXPECT_EQ(search.largest(), 1u);
}

TEST(CountSearch, largestCapDoesNotOverflow) {
  CountSearch search({1, UINT32_MAX, 0.05});
  EXPECT_EQ(run(search, UINT32_MAX).size(), 33u);
  EXPECT_EQ(search.largest(), UINT32_MAX);
}

}  // namespace
}  // namespace limber::bench
