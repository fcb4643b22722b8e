// SPDX-License-Identifier: Zlib
// Pictures are compared with reference pictures that were checked by eye. Software rasterisers of one version
// agree bit for bit on one kind of processor. Between kinds (reciprocals, fused multiplication) a few
// channels differ by some levels, and a pixel at an edge may change sides: a tolerance of 3, and a thousandth
// of the pixels. A GPU has other rules for edges: an NVIDIA H200 differs in 1.5 to 3.7 thousandths of the
// pixels.
//
// To renew them after a change of looks: LIMBER_RENEW_GOLDENS=1 limber_render_tests
// --gtest_filter='*Golden*', then check tests/render/goldens/*.png by eye.
#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <string>

#include "limber/render/png_file.h"
#include "test_scene.h"

namespace limber::render::test {
namespace {

constexpr int kTolerance = 3;
constexpr double kOutliers = 1e-3, kOutliersOfGpus = 1e-2;

struct GoldenCase {
  const char* name;
  DrawMode mode;
  int samples;
  bool overlay;
  Quality quality = Quality::Fast;
};

void PrintTo(const GoldenCase& value, std::ostream* out) { *out << value.name; }

std::string goldenPath(const GoldenCase& value) {
  return std::string(LIMBER_GOLDENS_DIR) + "/" + value.name + ".png";
}

struct Drawn {
  Image image;
  double outliers;  ///< allowed share of the pixels
};

Drawn draw(const GoldenCase& value) {
  RendererDesc desc = smallDesc();
  desc.width = 320;
  desc.height = 180;
  desc.samples = value.samples;
  desc.quality = value.quality;
  Stage stage(Backend::Auto, desc);
  populate(stage);
  DrawOptions options;
  options.mode = value.mode;
  if (value.overlay) {
    options.legends = {{ColourMap::Share, "0", "", "5 m/s"}};
    for (int i = 0; i < 8; ++i) {
      const auto x = static_cast<float>(i);
      addArrow(stage.overlay, {0.5f * x - 2.0f, 0.1f, 0.5f}, {0.5f * x - 1.8f, 1.2f, 0.2f},
               shareColour(x / 7.0f), stage.camera.eye);
      addCross(stage.overlay, {0.7f * x - 1.8f, 0.0f, -0.5f}, 0.1f, {1.0f, 0.8f, 0.0f});
    }
  }
  const double outliers = isSoftwareRasteriser(stage.renderer().gl()) ? kOutliers : kOutliersOfGpus;
  return {stage.picture(options), outliers};
}

class Golden : public ::testing::TestWithParam<GoldenCase> {};

TEST_P(Golden, LooksAsItDid) {
  const auto [image, outliers] = draw(GetParam());
  const std::string path = goldenPath(GetParam());
  if (std::getenv("LIMBER_RENEW_GOLDENS") != nullptr) {
    writePng(path, image);
    GTEST_SKIP() << "wrote " << path << ": look at it";
  }
  const Image golden = readPng(path);
  ASSERT_EQ(golden.width, image.width);
  ASSERT_EQ(golden.height, image.height);
  const double fraction = differingShare(golden, image, kTolerance);
  if (fraction > outliers) {
    const std::string file = std::filesystem::absolute(std::string(GetParam().name) + "-seen.png").string();
    writePng(file, image);
    ADD_FAILURE() << 100.0 * fraction << " % of the pixels differ by more than " << kTolerance
                  << " levels from " << path << "; what was drawn is in " << file;
  }
}

INSTANTIATE_TEST_SUITE_P(Pictures, Golden,
                         ::testing::Values(GoldenCase{"shaded", DrawMode::Shaded, 1, false},
                                           GoldenCase{"multisampled", DrawMode::Shaded, 4, false},
                                           GoldenCase{"wireframe", DrawMode::Wireframe, 1, false},
                                           GoldenCase{"overlay", DrawMode::Shaded, 1, true},
                                           GoldenCase{"gallery", DrawMode::Shaded, 4, false,
                                                      Quality::Gallery}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace limber::render::test
