// SPDX-License-Identifier: Zlib
#include "limber/render/stream_ring.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <string>

namespace limber::render {
namespace {

using std::chrono::nanoseconds;

// Fences are numbers. Those in `passed` are signalled; the others pass only if `patient` is set.
class FakeFences final : public FenceSource {
 public:
  Fence insert() override {
    if (lost) {
      throw std::runtime_error("no context");
    }
    return reinterpret_cast<Fence>(++last);
  }
  bool wait(Fence fence, nanoseconds timeout) override {
    ++waits;
    longest = std::max(longest, timeout);
    return passed.count(number(fence)) > 0 || (patient && timeout > nanoseconds::zero());
  }
  void destroy(Fence fence) noexcept override { destroyed.insert(number(fence)); }
  static std::uintptr_t number(Fence fence) { return reinterpret_cast<std::uintptr_t>(fence); }

  std::uintptr_t last = 0;
  std::set<std::uintptr_t> passed;
  std::set<std::uintptr_t> destroyed;
  bool patient = false, lost = false;
  int waits = 0;
  nanoseconds longest{0};
};

void runFrames(StreamRing& ring, int frames) {
  for (int i = 0; i < frames; ++i) {
    ring.begin();
    ring.submit();
  }
}

TEST(StreamRing, GoesRoundAndFencesEachRegionOnce) {
  FakeFences fences;
  StreamRing ring(fences);
  EXPECT_EQ(ring.begin(), 0u);
  EXPECT_EQ(ring.state(0), StreamRing::State::Writing);
  ring.submit();
  EXPECT_EQ(ring.state(0), StreamRing::State::InFlight);
  EXPECT_EQ(ring.begin(), 1u);
  ring.submit();
  EXPECT_EQ(ring.begin(), 2u);
  ring.submit();
  EXPECT_EQ(fences.waits, 0) << "the first round needs no waiting";
  fences.passed = {1};
  EXPECT_EQ(ring.begin(), 0u);
  EXPECT_EQ(ring.state(1), StreamRing::State::InFlight);
  EXPECT_EQ(fences.destroyed, std::set<std::uintptr_t>{1});
}

TEST(StreamRing, GoesOnAfterARegionWithoutAFence) {
  FakeFences fences;
  StreamRing ring(fences);
  ring.begin();
  fences.lost = true;
  EXPECT_THROW(ring.submit(), std::runtime_error);
  fences.lost = false;
  EXPECT_FALSE(ring.writing());
  EXPECT_NO_THROW(runFrames(ring, 2));
}

TEST(StreamRing, CountsWaitsAndStallsApart) {
  FakeFences fences;
  fences.patient = true;
  StreamRing ring(fences);
  runFrames(ring, 3);
  fences.passed = {1};
  runFrames(ring, 2);
  EXPECT_EQ(ring.counters().frames, 5u);
  EXPECT_EQ(ring.counters().waits, 2u);
  EXPECT_EQ(ring.counters().stalls, 1u);
}

TEST(StreamRing, RefusesWrongOrder) {
  FakeFences fences;
  StreamRing ring(fences);
  EXPECT_THROW(ring.submit(), std::logic_error);
  EXPECT_THROW(ring.cancel(), std::logic_error);
  ring.begin();
  EXPECT_THROW(ring.begin(), std::logic_error);
  EXPECT_THROW(ring.drain(), std::logic_error);
  ring.submit();
  EXPECT_THROW(ring.submit(), std::logic_error);
}

TEST(StreamRing, TimeoutIsAClearErrorAndKeepsTheRegionInFlight) {
  FakeFences fences;
  StreamRing ring(fences, std::chrono::milliseconds(250));
  runFrames(ring, 3);
  try {
    ring.begin();
    FAIL() << "begin() must not hand out a region that is in use";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("region 0 after 0.25"), std::string::npos) << error.what();
  }
  EXPECT_EQ(fences.longest, std::chrono::milliseconds(250));
  EXPECT_EQ(ring.state(0), StreamRing::State::InFlight);
  EXPECT_TRUE(fences.destroyed.empty());
  fences.passed = {1};
  EXPECT_EQ(ring.begin(), 0u) << "the ring recovers once the fence has passed";
}

TEST(StreamRing, CancelledRegionIsFreeWithoutAFence) {
  FakeFences fences;
  StreamRing ring(fences);
  const std::size_t region = ring.begin();
  ring.cancel();
  EXPECT_EQ(ring.state(region), StreamRing::State::Free);
  EXPECT_EQ(fences.last, 0u);
  runFrames(ring, 3);
}

TEST(StreamRing, DrainWaitsForAllAndDestructionLeaksNoFence) {
  FakeFences fences;
  fences.patient = true;
  {
    StreamRing ring(fences);
    runFrames(ring, 3);
    ring.drain();
    EXPECT_EQ(fences.destroyed.size(), 3u);
    EXPECT_EQ(ring.state(2), StreamRing::State::Free);
    runFrames(ring, 2);
  }
  EXPECT_EQ(fences.destroyed.size(), 5u);
}

}  // namespace
}  // namespace limber::render
