// SPDX-License-Identifier: Zlib
#include "allocation_counter.h"
#include "test_scene.h"

namespace limber::render::test {
namespace {

class FrameAllocation : public ::testing::TestWithParam<ComputeOn> {};

TEST_P(FrameAllocation, NothingIsAllocatedAfterTheFirstFrames) {
  Stage stage(Backend::Auto, smallDesc(GetParam()));
  populate(stage);
  Image image;
  for (int i = 0; i < 4; ++i) {
    stage.draw();
    stage.renderer().readPixels(image);
  }
  const std::size_t before = allocationCount();
  for (int i = 0; i < 6; ++i) {
    stage.draw();
    stage.renderer().readPixels(image);
  }
  EXPECT_EQ(allocationCount() - before, 0u);
}

INSTANTIATE_TEST_SUITE_P(ComputeOn, FrameAllocation, ::testing::Values(ComputeOn::Gpu, ComputeOn::Cpu));

}  // namespace
}  // namespace limber::render::test
