// SPDX-License-Identifier: Zlib
// Vertices of a skin, computed on the GPU and on the CPU, compared with sums in double precision, and
// pictures of them.
#include "shape_layout.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <ostream>
#include <stdexcept>
#include <vector>

#include "computed_points.h"
#include "test_scene.h"

namespace limber::render::test {
namespace {

std::vector<float> twisted(std::vector<float> points, float rotation) {
  for (std::size_t i = 0; i < points.size(); i += 3) {
    const float angle = rotation * points[i + 1];
    const float x = points[i], z = points[i + 2];
    points[i] = std::cos(angle) * x + std::sin(angle) * z;
    points[i + 2] = std::cos(angle) * z - std::sin(angle) * x;
    points[i + 1] *= 1.0f + 0.3f * rotation;
  }
  return points;
}

std::vector<double> placesOf(const Skin& skin, const std::vector<float>& points) {
  std::vector<double> places(3 * skin.skinnedPointCount(), 0.0);
  for (std::size_t p = 0; p < skin.skinnedPointCount(); ++p) {
    for (std::size_t k = skin.first[p]; k < skin.first[p + 1]; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        places[3 * p + c] += double{skin.weights[k]} * double{points[3 * skin.points[k] + c]};
      }
    }
  }
  return places;
}

struct SkinCase {
  std::uint32_t cells;
  ComputeOn computeOn;
};

void PrintTo(const SkinCase& value, std::ostream* out) {
  *out << value.cells << (value.computeOn == ComputeOn::Gpu ? " gpu" : " cpu");
}

class SkinPlaces : public ::testing::TestWithParam<SkinCase> {
 protected:
  Scenery ball = skinnedBall(GetParam().cells);
  RendererDesc desc = smallDesc(GetParam().computeOn);
};

TEST_P(SkinPlaces, AreTheWeightedSums) {
  ASSERT_EQ(isDense(ball.shape.skin, ball.shape.pointCount), GetParam().cells == 1);
  Stage stage(Backend::Auto, desc);
  stage.add(makeUvSphere({}, 0.1f));  // so that no offset is 0
  const ShapeId shape = stage.renderer().addShape(ball.shape);
  std::vector<std::pair<InstanceId, std::vector<float>>> bodies;
  for (const float rotation : {0.0f, 0.9f, -1.7f}) {
    const std::vector<float> points = twisted(ball.points, rotation);
    bodies.emplace_back(stage.add(shape, points), points);
  }
  stage.draw();
  for (const auto& [id, points] : bodies) {
    const std::vector<float> places = readSkinnedPoints(stage.renderer(), id);
    const std::vector<double> expected = placesOf(ball.shape.skin, points);
    ASSERT_EQ(places.size(), expected.size());
    // Eight products of numbers below 1, rounded to 24 bits each.
    for (std::size_t i = 0; i < places.size(); ++i) {
      ASSERT_NEAR(double{places[i]}, expected[i], 1e-6) << "place " << i / 3;
    }
  }
}

TEST_P(SkinPlaces, GiveThePictureOfAMeshAtTheSamePlaces) {
  const std::vector<float> points = twisted(ball.points, 1.2f);
  for (const Shading shading : {Shading::Flat, Shading::Smooth}) {
    ShapeDesc skinned = ball.shape;
    skinned.shading = shading;
    Stage stage(Backend::Auto, desc);
    const InstanceId id = stage.add(stage.renderer().addShape(skinned), points);
    const Image picture = stage.picture();
    const std::vector<float> places = readSkinnedPoints(stage.renderer(), id);

    ShapeDesc plain = skinned;
    plain.skin = {};
    plain.pointCount = static_cast<std::uint32_t>(ball.shape.skin.skinnedPointCount());
    Stage other(Backend::Auto, desc);
    other.add(other.renderer().addShape(plain), places);
    EXPECT_EQ(picture.rgba, other.picture().rgba);
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, SkinPlaces,
                         ::testing::Values(SkinCase{1, ComputeOn::Gpu}, SkinCase{3, ComputeOn::Gpu},
                                           SkinCase{1, ComputeOn::Cpu}, SkinCase{3, ComputeOn::Cpu}));

TEST(Skin, OnlyThePointsAreStreamedIfTheGpuComputesPlaces) {
  for (const std::uint32_t cells : {1u, 3u}) {
    const Scenery ball = skinnedBall(cells);
    Stage stage(Backend::Auto, smallDesc(ComputeOn::Gpu));
    stage.add(ball);
    stage.draw();
    EXPECT_EQ(stage.renderer().lastFrame().bytesStreamed, 12 * ball.shape.pointCount);
    EXPECT_EQ(stage.renderer().lastFrame().dispatches, 2u) << "places and normals";
  }
}

TEST(Skin, LinesLieBetweenPointsNotPlaces) {
  Scenery ball = skinnedBall(1);
  ball.shape.lines = {0, 7};
  DrawOptions wireframe;
  wireframe.mode = DrawMode::Wireframe;
  Stage stage;
  stage.add(ball);
  Scenery line = ball;
  line.shape.skin = {};
  line.shape.triangles.clear();
  line.shape.vertexToPoint.clear();
  line.shape.uvs.clear();
  Stage other;
  other.add(line);
  EXPECT_EQ(stage.picture(wireframe).rgba, other.picture(wireframe).rgba);
}

TEST(Skin, ShapesWithoutOneHaveNoPlacesToRead) {
  Stage stage;
  const InstanceId id = stage.add(makeBox({}, {0.5f, 0.5f, 0.5f}));
  stage.draw();
  EXPECT_THROW(readSkinnedPoints(stage.renderer(), id), std::runtime_error);
}

TEST(ShapeLayout, ClosedSurfacesHaveNoBoundary) {
  std::vector<std::uint32_t> tetrahedron{0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
  EXPECT_TRUE(isClosed(tetrahedron));
  EXPECT_FALSE(isClosed(cloth(3).shape.triangles));
  std::swap(tetrahedron[0], tetrahedron[1]);
  EXPECT_FALSE(isClosed(tetrahedron)) << "one triangle is flipped";
}

TEST(SkinLayout, DenseTakesOverWhereItIsSmaller) {
  // Two skin vertices on four points: with two weights each both layouts have the same size.
  Skin skin{{0, 2, 4}, {0, 1, 2, 3}, {0.5f, 0.5f, 0.25f, 0.75f}};
  EXPECT_TRUE(isDense(skin, 4));
  EXPECT_FALSE(isDense(skin, 5));
  EXPECT_EQ(denseWeights(skin, 4), (std::vector<float>{0.5f, 0.0f, 0.5f, 0.0f, 0.0f, 0.25f, 0.0f, 0.75f}));
  EXPECT_EQ(sparseWeights(skin)[4], 2u);
}

}  // namespace
}  // namespace limber::render::test
