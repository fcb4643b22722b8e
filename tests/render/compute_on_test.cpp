// SPDX-License-Identifier: Zlib
// Skins, normals and side vectors of tubes, computed on the CPU and by compute shaders: the same up to
// rounding, on any number of threads.
#include <cmath>
#include <cstddef>
#include <random>
#include <stdexcept>
#include <vector>

#include "allocation_counter.h"
#include "computed_points.h"
#include "limber/render/gl_functions.h"
#include "renderer_parts.h"
#include "test_scene.h"

namespace limber::render::test {
namespace {

/// Places and normals are sums of a few products of numbers up to 1.5, each rounded to 24 bits. A normal is
/// divided by the length of such a sum; its differences of positions cancel a hundredfold.
constexpr double kPositionTolerance = 1e-6, kNormalTolerance = 2e-5;

void expectNear(const std::vector<float>& a, const std::vector<float>& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_NEAR(a[i], b[i], tolerance) << "point " << i / 3;
  }
}

TEST(ComputeOn, AutoChoosesTheCpuForSoftwareRasterisersOnly) {
  Stage automatic;
  Stage cpu(Backend::Auto, smallDesc(ComputeOn::Cpu)), gpu(Backend::Auto, smallDesc(ComputeOn::Gpu));
  EXPECT_EQ(automatic.renderer().computesOnCpu(), isSoftwareRasteriser(automatic.renderer().gl()));
  EXPECT_TRUE(cpu.renderer().computesOnCpu());
  EXPECT_FALSE(gpu.renderer().computesOnCpu());
  EXPECT_TRUE(isSoftwareRasteriser("llvmpipe (LLVM 15.0.6, 256 bits)"));
  EXPECT_FALSE(isSoftwareRasteriser("NVIDIA GeForce RTX 3070/PCIe/SSE2"));
}

TEST(ComputeOn, NegativeThreadsAreRefused) {
  RendererDesc desc = smallDesc();
  desc.computeThreads = -1;
  EXPECT_THROW(Stage(Backend::Auto, desc), std::runtime_error);
}

TEST(ComputeOn, BothGiveTheSamePositionsAndNormals) {
  Stage cpu(Backend::Auto, smallDesc(ComputeOn::Cpu)), gpu(Backend::Auto, smallDesc(ComputeOn::Gpu));
  std::vector<InstanceId> skinned, smooth;
  for (Stage* stage : {&cpu, &gpu}) {
    skinned.clear();
    smooth.clear();
    stage->add(makeFloor({}, 4.0f));
    for (const std::uint32_t cells : {1u, 3u}) {
      const Scenery ball = skinnedBall(cells);
      const ShapeId shape = stage->renderer().addShape(ball.shape);
      for (const float x : {0.0f, 0.5f, -0.7f}) {
        skinned.push_back(stage->add(shape, moved(ball.points, x, 0.4f, 0.3f)));
      }
    }
    smooth = skinned;
    smooth.push_back(stage->add(rope(9)));
    smooth.push_back(stage->add(cloth(9)));
    stage->draw();
  }
  for (const InstanceId id : skinned) {
    expectNear(readSkinnedPoints(cpu.renderer(), id), readSkinnedPoints(gpu.renderer(), id),
               kPositionTolerance);
  }
  for (const InstanceId id : smooth) {
    expectNear(readNormals(cpu.renderer(), id), readNormals(gpu.renderer(), id), kNormalTolerance);
  }
  EXPECT_EQ(cpu.renderer().lastFrame().dispatches, 0u);
}

TEST(ComputeOn, PicturesAreEqualUpToRounding) {
  for (const DrawMode mode : {DrawMode::Shaded, DrawMode::Wireframe}) {
    Stage cpu(Backend::Auto, smallDesc(ComputeOn::Cpu)), gpu(Backend::Auto, smallDesc(ComputeOn::Gpu));
    DrawOptions options;
    options.mode = mode;
    populate(cpu);
    populate(gpu);
    const Image a = cpu.picture(options), b = gpu.picture(options);
    // A pixel at the edge of a triangle or of a shadow may change sides.
    EXPECT_LE(differingShare(a, b, 1), 1e-3);
  }
}

TEST(ComputeOn, TheCpuStreamsWhatItComputes) {
  const Scenery ball = skinnedBall(3);
  Stage stage(Backend::Auto, smallDesc(ComputeOn::Cpu));
  stage.add(ball);
  stage.draw();
  const std::size_t places = ball.shape.skin.skinnedPointCount();
  EXPECT_EQ(stage.renderer().lastFrame().bytesStreamed, 12 * (ball.shape.pointCount + 2 * places));
  EXPECT_GT(stage.renderer().lastFrame().computeMs, 0.0);
}

/// A skin with random weights and instances with random points, large enough for several threads.
struct LargeSkin {
  static constexpr std::uint32_t kPoints = 200;
  static constexpr std::size_t kPlaces = 3001, kInstances = 9;  // no multiples of a block of places

  explicit LargeSkin(std::uint32_t weightsPerPlace) {
    std::uniform_real_distribution<float> coordinate(-1.0f, 1.0f);
    std::uniform_int_distribution<std::uint32_t> offset(0, kPoints - 1);
    for (std::size_t i = 0; i < 3 * kPoints * kInstances; ++i) {
      points.push_back(coordinate(random));
    }
    skin.first = {0};
    for (std::size_t place = 0; place < kPlaces; ++place) {
      for (std::uint32_t k = 0; k < weightsPerPlace; ++k) {
        skin.points.push_back((k * (kPoints / weightsPerPlace) + offset(random)) % kPoints);
        skin.weights.push_back(coordinate(random) / static_cast<float>(weightsPerPlace));
      }
      skin.first.push_back(static_cast<std::uint32_t>(skin.weights.size()));
    }
  }

  std::vector<double> exactPlaces() const {
    std::vector<double> places(3 * kPlaces * kInstances, 0.0);
    for (std::size_t i = 0; i < kPlaces * kInstances; ++i) {
      const std::size_t place = i % kPlaces, firstPoint = i / kPlaces * kPoints;
      for (std::size_t k = skin.first[place]; k < skin.first[place + 1]; ++k) {
        for (std::size_t c = 0; c < 3; ++c) {
          places[3 * i + c] +=
              double{skin.weights[k]} * double{points[3 * (firstPoint + skin.points[k]) + c]};
        }
      }
    }
    return places;
  }

  std::mt19937 random{7};
  Skin skin;
  std::vector<float> points;
};

class CpuSkinTest : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(CpuSkinTest, EveryPlaceOfEveryInstanceIsItsSumOnAnyNumberOfThreads) {
  const LargeSkin large(GetParam());
  const CpuSkin skin = makeCpuSkin(large.skin, LargeSkin::kPoints);
  ASSERT_EQ(skin.dense.empty(), GetParam() < LargeSkin::kPoints / 2);
  const std::vector<double> expected = large.exactPlaces();
  std::vector<Lanes> lanes;
  std::vector<float> first;
  for (const unsigned threadCount : {1u, 2u, 5u}) {
    RowThreads threads(threadCount);
    std::vector<float> places(expected.size(), std::nanf(""));
    applySkin(skin, {LargeSkin::kInstances, large.points.data(), places.data()}, lanes, threads);
    for (std::size_t i = 0; i < places.size(); ++i) {
      ASSERT_NEAR(places[i], expected[i], kPositionTolerance) << "place " << i / 3;
    }
    if (first.empty()) {
      first = places;
    }
    ASSERT_EQ(places, first) << threadCount << " threads";
  }
}

TEST_P(CpuSkinTest, AllocatesAtTheFirstCallOnly) {
  const LargeSkin large(GetParam());
  const CpuSkin skin = makeCpuSkin(large.skin, LargeSkin::kPoints);
  std::vector<float> places(3 * LargeSkin::kPlaces * LargeSkin::kInstances);
  std::vector<Lanes> lanes;
  RowThreads threads(3);
  const auto apply = [&] {
    applySkin(skin, {LargeSkin::kInstances, large.points.data(), places.data()}, lanes, threads);
  };
  apply();
  const std::size_t before = allocationCount();
  apply();
  EXPECT_EQ(allocationCount() - before, 0u);
}

INSTANTIATE_TEST_SUITE_P(WeightsPerPlace, CpuSkinTest, ::testing::Values(40u, 200u));

TEST(RowThreads, EachRowIsDoneOnceWhateverTheirNumber) {
  constexpr std::size_t kMuchWork = 10'000'000;
  RowThreads threads(4);
  for (const std::size_t rows : {0u, 1u, 3u, 4u, 5u, 1000u}) {
    for (const std::size_t work : {std::size_t{1}, kMuchWork}) {
      std::vector<int> done(rows, 0);
      std::vector<int> parts(4, 0);
      threads.run(rows, work, [&](RowRange range, unsigned part) {
        ++parts[part];
        for (std::size_t row = range.begin; row < range.end; ++row) {
          ++done[row];
        }
      });
      EXPECT_EQ(done, std::vector<int>(rows, 1));
      if (rows == 1000) {
        EXPECT_EQ(parts, work == 1 ? (std::vector<int>{1, 0, 0, 0}) : (std::vector<int>{1, 1, 1, 1}));
      }
    }
  }
}

}  // namespace
}  // namespace limber::render::test
