// SPDX-License-Identifier: Zlib
// The committed meshes must be valid, have the documented shapes and counts, and equal the generator's
// output.
#include <limber/mesh.h>
#include <limber/network_builder.h>

#include "import/temporary_folder.h"
#include "support/constants.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

using Eigen::Vector3d;
using limber::SharedNetwork;
using limber::SpringNetwork;
using limber::TriangleMesh;
using limber::test::kPi;

namespace {

struct Expected {
  const char* name;
  std::size_t points, triangles, springs, braces;
  int eulerCharacteristic;
  double volume;     ///< m^3, of the polyhedron or, if the tolerance is large, of the smooth shape
  double tolerance;  ///< as a fraction of the volume
  Vector3d size;     ///< m
};

/// Returns the volume of a prism over a regular polygon: height * n / 2 * r^2 * sin(2 pi / n).
double cylinderVolume() { return 6.0 * 0.35 * 0.35 * std::sin(kPi / 6.0); }

void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.name; }

std::string meshPath(const std::string& name) { return std::string(LIMBER_MESHES) + "/" + name; }

std::string readFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  std::ostringstream content;
  content << file.rdbuf();
  return content.str();
}

/// Returns the volume by the divergence theorem: the sum of the signed volumes of the tetrahedra between the
/// triangles and the origin.
double signedVolume(const SpringNetwork& network) {
  double volume = 0.0;
  for (const limber::Triangle& t : network.surface) {
    const auto& p = network.restPoints;
    volume += p[t[0]].dot(p[t[1]].cross(p[t[2]])) / 6.0;
  }
  return volume;
}

Vector3d boxSize(const SpringNetwork& network) {
  Vector3d low = network.restPoints[0], high = low;
  for (const Vector3d& p : network.restPoints) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return high - low;
}

class Meshes : public testing::TestWithParam<Expected> {
 protected:
  SharedNetwork build(limber::BraceRule braces) const {
    limber::Result<TriangleMesh> mesh = limber::importMesh(meshPath(std::string(GetParam().name) + ".obj"));
    if (!mesh) throw std::runtime_error(mesh.error());
    limber::NetworkSettings settings;
    settings.braces = braces;
    return *buildNetwork(*mesh, settings);
  }
};

TEST_P(Meshes, isOneClosedSurfaceWithTheOutsideOut) {
  const SharedNetwork network = build(limber::BraceRule::None);
  EXPECT_EQ(validate(*network).error(), "");
  EXPECT_TRUE(network->report.watertight()) << describe(network->report);
  EXPECT_EQ(network->report.components, 1u);
  EXPECT_EQ(network->report.degenerateTriangles + network->report.duplicateTriangles, 0u);
  EXPECT_EQ(network->report.isolatedVertices, 0u);
  EXPECT_NEAR(signedVolume(*network) / GetParam().volume, 1.0, GetParam().tolerance);
}

TEST_P(Meshes, hasTheCountsOfTheReadme) {
  const Expected& expected = GetParam();
  const SharedNetwork bare = build(limber::BraceRule::None), braced = build(limber::BraceRule::EqualLength);
  EXPECT_EQ(bare->restPoints.size(), expected.points);
  EXPECT_EQ(bare->surface.size(), expected.triangles);
  EXPECT_EQ(bare->springs.size(), expected.springs);
  EXPECT_EQ(braced->springs.size() - bare->springs.size(), expected.braces);

  std::ostringstream counts;
  counts << " | " << expected.points << " | " << expected.triangles << " | " << expected.springs << " | "
         << expected.braces << " |\n";
  const std::string readme = readFile(meshPath("README.md"));
  const std::size_t row = readme.find("| `" + std::string(expected.name) + ".obj`");
  ASSERT_NE(row, std::string::npos);
  EXPECT_NE(readme.substr(row, readme.find('\n', row) + 1 - row).find(counts.str()), std::string::npos);
}

TEST_P(Meshes, hasTheTopologyOfItsShape) {
  const SharedNetwork network = build(limber::BraceRule::None);
  const int euler = static_cast<int>(network->restPoints.size() + network->surface.size()) -
                    static_cast<int>(network->springs.size());
  EXPECT_EQ(euler, GetParam().eulerCharacteristic);
}

TEST_P(Meshes, hasItsSize) {
  const Vector3d size = boxSize(*build(limber::BraceRule::None));
  EXPECT_LT((size - GetParam().size).cwiseAbs().maxCoeff(), 0.01) << size.transpose();
}

TEST_P(Meshes, hasTextureCoordinates) {
  const SharedNetwork network = build(limber::BraceRule::None);
  EXPECT_EQ(network->render.uvs.size(), network->render.vertexToPoint.size());
  for (const limber::Triangle& t : network->render.triangles) {
    for (const std::uint32_t vertex : t) {
      const Eigen::Vector2f& uv = network->render.uvs[vertex];
      EXPECT_TRUE(uv.minCoeff() >= 0.0f && uv.x() <= 1.6f && uv.y() <= 1.0f) << uv.transpose();
      EXPECT_LE((uv - network->render.uvs[t[0]]).cwiseAbs().maxCoeff(), 1.0f)
          << "a triangle smeared over a seam";
    }
  }
}

TEST_P(Meshes, isWhatItsGeneratorWrites) {
  const TemporaryFolder folder;
  ASSERT_EQ(std::system((std::string(LIMBER_GENERATE_MESHES) + " " + folder.path()).c_str()), 0);
  const std::string name = std::string(GetParam().name) + ".obj";
  EXPECT_EQ(readFile(folder.path() + "/" + name), readFile(meshPath(name)));
}

INSTANTIATE_TEST_SUITE_P(
    All, Meshes,
    testing::Values(
        Expected{"cube", 8, 12, 18, 6, 2, 1.0, 1e-6, {1, 1, 1}},
        Expected{"icosphere", 162, 320, 480, 0, 2, 4.0 / 3.0 * kPi * 0.125, 0.06, {1, 1, 1}},
        Expected{"torus", 128, 256, 384, 128, 0, 2.0 * kPi* kPi * 0.35 * 0.15 * 0.15, 0.13, {1, 0.3, 1}},
        Expected{"cylinder", 74, 144, 216, 132, 2, cylinderVolume(), 1e-6, {0.7, 1, 0.7}},
        Expected{"l_shape", 90, 176, 264, 132, 2, 0.75, 1e-6, {1, 1, 1}},
        Expected{"star", 162, 320, 480, 0, 2, 0.162, 0.2, {1, 1, 1}},
        Expected{"figure", 408, 812, 1218, 58, 2, 0.0505, 0.1, {0.895, 1, 0.285}}),
    [](const testing::TestParamInfo<Expected>& shape) { return std::string(shape.param.name); });

TEST(CubeMesh, isTheCubeOfOneMetreAroundTheOrigin) {
  const limber::Result<TriangleMesh> mesh = limber::importMesh(meshPath("cube.obj"));
  ASSERT_TRUE(mesh) << mesh.error();
  for (const Vector3d& p : mesh->positions) EXPECT_EQ(p.cwiseAbs(), Vector3d(0.5, 0.5, 0.5));
}

}  // namespace
