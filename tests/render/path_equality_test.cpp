// SPDX-License-Identifier: Zlib
// The batched path must give the same picture as one buffer, one upload and one draw call per body.
#include <ostream>
#include <stdexcept>
#include <string>

#include "baseline_picture.h"

namespace limber::render::test {
namespace {

struct PathCase {
  std::string name;
  DrawMode mode = DrawMode::Shaded;
  bool shadows = true;
  int samples = 1;
};

void PrintTo(const PathCase& value, std::ostream* out) { *out << value.name; }

class PathEquality : public ::testing::TestWithParam<PathCase> {};

TEST_P(PathEquality, NaiveAndBatchedPicturesAreEqual) {
  const PathCase& param = GetParam();
  RendererDesc desc = smallDesc(ComputeOn::Gpu);  // As in the baseline, for equal bits.
  desc.samples = param.samples;
  Stage stage(Backend::Auto, desc);
  populate(stage);
  stage.light.shadows = param.shadows;
  DrawOptions options;
  options.mode = param.mode;
  const Image batched = stage.picture(options);
  const std::size_t batchedDraws = stage.renderer().lastFrame().shapeDrawCalls;
  const auto baseline = bench::makeNaivePoints(stage.renderer());
  const Image naive = pictureAs(*baseline, stage, options);
  EXPECT_EQ(batched.rgba, naive.rgba);
  EXPECT_GT(stage.renderer().lastFrame().shapeDrawCalls, batchedDraws);
  EXPECT_EQ(stage.picture(options).rgba, batched.rgba) << "not the same twice";
}

TEST(Baseline, WrongOrdersAreRefused) {
  Stage stage(Backend::Auto, smallDesc(ComputeOn::Gpu));
  const InstanceId box = stage.add(makeBox({}, {0.5f, 0.5f, 0.5f}));
  const auto baseline = bench::makeNaivePoints(stage.renderer());
  EXPECT_THROW(baseline->points(box), std::runtime_error);
  EXPECT_THROW(baseline->draw(stage.camera, stage.light), std::logic_error);
  {
    const FrameWriter frame = stage.renderer().beginFrame();
    EXPECT_THROW(baseline->beginFrame(), std::logic_error);
  }
  EXPECT_NO_THROW(drawAs(*baseline, stage));
  EXPECT_THROW(baseline->draw(stage.camera, stage.light), std::logic_error);
}

TEST(Baseline, NaivePointsNeedComputeShaders) {
  Stage stage(Backend::Auto, smallDesc(ComputeOn::Cpu));
  EXPECT_THROW(bench::makeNaivePoints(stage.renderer()), std::runtime_error);
}

INSTANTIATE_TEST_SUITE_P(Modes, PathEquality,
                         ::testing::Values(PathCase{"Shaded", DrawMode::Shaded, false, 1},
                                           PathCase{"ShadedWithShadows", DrawMode::Shaded, true, 1},
                                           PathCase{"Wireframe", DrawMode::Wireframe, true, 1},
                                           PathCase{"Multisampled", DrawMode::Shaded, true, 4}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace limber::render::test
