// SPDX-License-Identifier: Zlib
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "computed_points.h"
#include "test_scene.h"

namespace limber::render::test {
namespace {

using Double3 = std::array<double, 3>;

Double3 pointAt(const std::vector<float>& points, std::uint32_t i) {
  return {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
}

// Returns area-weighted normals in double precision, with vertices welded to their points.
std::vector<Double3> referenceNormals(const Scenery& scenery) {
  std::vector<Double3> sums(scenery.shape.pointCount, Double3{});
  const auto& map = scenery.shape.vertexToPoint;
  for (std::size_t t = 0; t < scenery.shape.triangles.size(); t += 3) {
    std::array<std::uint32_t, 3> corner{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = scenery.shape.triangles[t + k];
      corner[k] = map.empty() ? vertex : map[vertex];
    }
    const Double3 a = pointAt(scenery.points, corner[0]);
    const Double3 b = pointAt(scenery.points, corner[1]);
    const Double3 c = pointAt(scenery.points, corner[2]);
    const Double3 u{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const Double3 v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const Double3 cross{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    for (const std::uint32_t p : corner) {
      for (std::size_t k = 0; k < 3; ++k) {
        sums[p][k] += cross[k];
      }
    }
  }
  for (Double3& n : sums) {
    const double size = std::hypot(n[0], n[1], n[2]);
    n = {n[0] / size, n[1] / size, n[2] / size};
  }
  return sums;
}

void expectNormals(Stage& stage, InstanceId id, const Scenery& scenery) {
  const std::vector<float> normals = readNormals(stage.renderer(), id);
  const std::vector<Double3> expected = referenceNormals(scenery);
  ASSERT_EQ(normals.size(), 3 * expected.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    ASSERT_NEAR(normals[i], expected[i / 3][i % 3], 2e-5) << "point " << i / 3;
  }
}

class Normals : public ::testing::TestWithParam<ComputeOn> {
 protected:
  Stage stage{Backend::Auto, smallDesc(GetParam())};
};

TEST_P(Normals, SmoothOnesAreAreaWeightedOverWeldedPoints) {
  stage.add(makeFloor({}, 4.0f));
  const Scenery ball = makeUvSphere({0.2f, 0.3f, 0.1f}, 0.7f, 7, 11);
  const Scenery sheet = cloth(9);
  const ShapeId ballShape = stage.renderer().addShape(ball.shape);
  const ShapeId sheetShape = stage.renderer().addShape(sheet.shape);
  const InstanceId first = stage.add(ballShape, ball.points);
  Scenery squeezed = ball;
  for (std::size_t i = 0; i < squeezed.points.size(); ++i) {
    squeezed.points[i] *= i % 3 == 1 ? 0.4f : 1.1f;
  }
  const InstanceId second = stage.add(ballShape, squeezed.points);
  const InstanceId third = stage.add(sheetShape, sheet.points);
  stage.draw();
  expectNormals(stage, first, ball);
  expectNormals(stage, second, squeezed);
  expectNormals(stage, third, sheet);
}

TEST_P(Normals, OfASharpBoxAreThoseOfItsSides) {
  Scenery box = makeBox({}, {0.5f, 0.6f, 0.7f});
  box.shape.shading = Shading::Smooth;
  sharpenEdges(box.shape, box.points, 0.7f);
  EXPECT_EQ(normalCount(box.shape), 24u);
  const InstanceId other = stage.add(cloth(5)), id = stage.add(box), second = stage.add(box);
  stage.draw();
  EXPECT_EQ(readNormals(stage.renderer(), other).size(), 75u);
  const std::vector<float> normals = readNormals(stage.renderer(), id);
  EXPECT_EQ(readNormals(stage.renderer(), second), normals);
  std::array<int, 6> sides{};
  for (std::uint32_t i = 0; i < 24; ++i) {
    const Double3 n = pointAt(normals, i);
    for (std::size_t c = 0; c < 3; ++c) {
      if (std::abs(n[c]) > 0.5) {
        EXPECT_NEAR(std::abs(n[c]), 1.0, 1e-6);
        ++sides[2 * c + (n[c] > 0.0 ? 1 : 0)];
      }
    }
  }
  for (const int count : sides) EXPECT_EQ(count, 4);
}

TEST_P(Normals, TubeFramesAreUnitAndAcrossTheTube) {
  const Scenery tube = rope(9);
  const InstanceId id = stage.add(tube);
  stage.draw();
  const std::vector<float> sides = readNormals(stage.renderer(), id);
  for (std::uint32_t k = 1; k + 1 < tube.shape.pointCount; ++k) {
    const Double3 before = pointAt(tube.points, k - 1);
    const Double3 after = pointAt(tube.points, k + 1);
    const Double3 side = pointAt(sides, k);
    EXPECT_NEAR(std::hypot(side[0], side[1], side[2]), 1.0, 1e-5);
    double along = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      along += side[c] * (after[c] - before[c]);
    }
    EXPECT_NEAR(along, 0.0, 1e-5);
  }
}

TEST_P(Normals, FlatShapesHaveNone) {
  const InstanceId id = stage.add(makeBox({}, {0.5f, 0.5f, 0.5f}));
  stage.draw();
  EXPECT_THROW(readNormals(stage.renderer(), id), std::runtime_error);
}

TEST(SharpEdges, LeaveWhatBendsLess) {
  Scenery ball = makeUvSphere({}, 0.5f, 12, 24);
  const std::size_t vertices = ball.shape.vertexToPoint.size();
  sharpenEdges(ball.shape, ball.points, 0.7f);
  EXPECT_EQ(normalCount(ball.shape), ball.shape.pointCount);
  EXPECT_LE(ball.shape.vertexToPoint.size(), vertices);
  EXPECT_EQ(validate(ball.shape), "");
  sharpenEdges(ball.shape, ball.points, 0.01f);
  EXPECT_GT(normalCount(ball.shape), 3u * ball.shape.pointCount);
}

// A tent: two halves of a sheet that meet at a right angle. Only the ridge is sharp, although the sheet's
// border is the end of smoothness, too.
TEST(SharpEdges, AreSharpOnBothSidesOfARidge) {
  Scenery tent = cloth(5);
  for (std::size_t i = 0; i < tent.points.size(); i += 3) {
    tent.points[i + 1] = -std::abs(tent.points[i] - 0.6f);
  }
  sharpenEdges(tent.shape, tent.points, 0.7f);
  EXPECT_EQ(normalCount(tent.shape), 25u + 5u);
}

TEST(SharpEdges, OfBadInputAreRefusedWithTheReason) {
  Scenery box = makeBox({}, {1, 1, 1});
  EXPECT_THROW(sharpenEdges(box.shape, {0.0f}, 0.5f), std::runtime_error);
  Scenery tube = rope(5);
  EXPECT_THROW(sharpenEdges(tube.shape, tube.points, 0.5f), std::runtime_error);
  box.shape.triangles[4] = 99;
  EXPECT_THROW(sharpenEdges(box.shape, box.points, 0.5f), std::runtime_error);
}

INSTANTIATE_TEST_SUITE_P(ComputeOn, Normals, ::testing::Values(ComputeOn::Gpu, ComputeOn::Cpu));

}  // namespace
}  // namespace limber::render::test
