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
#include <stdexcept>
#include <utility>

using Eigen::Vector3d;
using limber::SharedNetwork;
using limber::SpringNetwork;
using limber::TriangleMesh;
using limber::test::kPi;

namespace {

/// A closed mesh of one piece.
struct Expected {
  const char* name;
  std::size_t points, triangles, springs, braces;
  int eulerCharacteristic;
  double volume;     ///< m^3, of the polyhedron or, if the tolerance is large, of the smooth shape
  double tolerance;  ///< as a fraction of the volume
  Vector3d size;     ///< m
};

/// A mesh with defects, in units of its own.
struct Difficult {
  const char* name;
  std::size_t points, triangles, pieces, openEdges, nonManifoldEdges, inconsistentEdges;
  Vector3d size;
};

/// Returns the volume of a prism over a regular polygon: height * n / 2 * r^2 * sin(2 pi / n).
double cylinderVolume() { return 6.0 * 0.35 * 0.35 * std::sin(kPi / 6.0); }

void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.name; }
void PrintTo(const Difficult& expected, std::ostream* out) { *out << expected.name; }

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

Vector3d boxSize(const std::vector<Vector3d>& points) {
  Vector3d low = points[0], high = low;
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return high - low;
}

/// Returns the row of the mesh in the tables of the README.
std::string readmeRow(const std::string& name) {
  const std::string readme = readFile(meshPath("README.md"));
  const std::size_t row = readme.find("| `" + name + ".obj`");
  if (row == std::string::npos) return "";
  return readme.substr(row, readme.find('\n', row) + 1 - row);
}

TriangleMesh load(const std::string& name) {
  limber::Result<TriangleMesh> mesh = limber::importMesh(meshPath(name + ".obj"));
  if (!mesh) throw std::runtime_error(mesh.error());
  return std::move(*mesh);
}

int generate(const std::string& folder, const std::string& names) {
  return std::system((std::string(LIMBER_GENERATE_MESHES) + " " + folder + " " + names).c_str());
}

void expectIsWhatItsGeneratorWrites(const std::string& name) {
  const TemporaryFolder folder;
  ASSERT_EQ(generate(folder.path(), name), 0);
  // not EXPECT_EQ, which would print both files
  EXPECT_TRUE(readFile(folder.path() + "/" + name + ".obj") == readFile(meshPath(name + ".obj")));
}

class Meshes : public testing::TestWithParam<Expected> {
 protected:
  SharedNetwork build(limber::BraceRule braces) const {
    limber::NetworkSettings settings;
    settings.braces = braces;
    return *buildNetwork(load(GetParam().name), settings);
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
  EXPECT_NE(readmeRow(expected.name).find(counts.str()), std::string::npos) << counts.str();
}

TEST_P(Meshes, hasTheTopologyOfItsShape) {
  const SharedNetwork network = build(limber::BraceRule::None);
  const int euler = static_cast<int>(network->restPoints.size() + network->surface.size()) -
                    static_cast<int>(network->springs.size());
  EXPECT_EQ(euler, GetParam().eulerCharacteristic);
}

TEST_P(Meshes, hasItsSize) {
  const Vector3d size = boxSize(build(limber::BraceRule::None)->restPoints);
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

TEST_P(Meshes, isWhatItsGeneratorWrites) { expectIsWhatItsGeneratorWrites(GetParam().name); }

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

class DifficultMeshes : public testing::TestWithParam<Difficult> {};

TEST_P(DifficultMeshes, hasTheDefectsOfTheReadme) {
  const Difficult& expected = GetParam();
  const limber::Result<limber::WeldedMesh> welded = limber::weld(load(expected.name));
  ASSERT_TRUE(welded) << welded.error();
  const limber::MeshReport& report = welded->report;
  EXPECT_EQ(report.points, expected.points);
  EXPECT_EQ(report.triangles, expected.triangles);
  EXPECT_EQ(report.components, expected.pieces);
  EXPECT_EQ(report.openEdges, expected.openEdges);
  EXPECT_EQ(report.nonManifoldEdges, expected.nonManifoldEdges);
  EXPECT_EQ(report.inconsistentEdges, expected.inconsistentEdges);
  EXPECT_EQ(report.degenerateTriangles + report.duplicateTriangles + report.isolatedVertices, 0u);

  std::ostringstream counts;
  counts << " | " << expected.points << " | " << expected.triangles << " | " << expected.pieces << " | "
         << expected.openEdges << " | " << expected.nonManifoldEdges << " | " << expected.inconsistentEdges
         << " |\n";
  EXPECT_NE(readmeRow(expected.name).find(counts.str()), std::string::npos) << counts.str();
}

TEST_P(DifficultMeshes, hasItsSize) {
  const Vector3d size = boxSize(load(GetParam().name).positions), expected = GetParam().size;
  EXPECT_LT((size - expected).cwiseAbs().maxCoeff(), 0.005 * expected.maxCoeff()) << size.transpose();
}

/// The surface of a wrap lies within about half a cell of the mesh; holes are capped and sheets thickened by
/// half their thickness at either side, which may add to the size but not take from it.
TEST_P(DifficultMeshes, canBeWrappedByOneClosedSurface) {
  const TriangleMesh mesh = load(GetParam().name);
  const limber::Result<limber::WrappedMesh> wrapped = limber::wrap(mesh);
  ASSERT_TRUE(wrapped) << wrapped.error();
  const limber::Result<limber::WeldedMesh> welded = limber::weld(wrapped->mesh);
  ASSERT_TRUE(welded) << welded.error();
  EXPECT_TRUE(welded->report.watertight()) << describe(welded->report);
  EXPECT_EQ(welded->report.components, 1u);
  EXPECT_GT(wrapped->volume, 0.0);
  const Vector3d grown = boxSize(wrapped->mesh.positions) - boxSize(mesh.positions);
  EXPECT_GT(grown.minCoeff(), -wrapped->resolution) << grown.transpose();
  EXPECT_LT(grown.maxCoeff(), wrapped->thickness + wrapped->resolution) << grown.transpose();
}

TEST_P(DifficultMeshes, isWhatItsGeneratorWrites) { expectIsWhatItsGeneratorWrites(GetParam().name); }

INSTANTIATE_TEST_SUITE_P(
    All, DifficultMeshes,
    testing::Values(Difficult{"animal", 3536, 7068, 1, 0, 0, 0, {0.300, 0.782, 0.977}},
                    Difficult{"teapot", 2592, 5052, 3, 132, 0, 32, {1.013, 0.517, 0.572}},
                    Difficult{"head", 1656, 3242, 3, 66, 0, 0, {0.973, 0.744, 0.673}},
                    Difficult{"ogre", 6757, 13082, 40, 320, 0, 0, {167, 187, 63.5}},
                    Difficult{"bunny", 7626, 15098, 1, 182, 7, 0, {0.893, 1.635, 1.617}},
                    Difficult{"car", 2890, 4739, 19, 1011, 0, 0, {1541, 1458, 3993}},
                    Difficult{"puppet", 989, 1700, 1, 286, 0, 0, {0.779, 0.994, 0.0}}),
    [](const testing::TestParamInfo<Difficult>& shape) { return std::string(shape.param.name); });

TEST(MeshGenerator, refusesAnUnknownName) {
  const TemporaryFolder folder;
  EXPECT_NE(generate(folder.path(), "cube unicorn"), 0);
  EXPECT_FALSE(std::ifstream(folder.path() + "/cube.obj"));
}

TEST(CubeMesh, isTheCubeOfOneMetreAroundTheOrigin) {
  const TriangleMesh mesh = load("cube");
  for (const Vector3d& p : mesh.positions) EXPECT_EQ(p.cwiseAbs(), Vector3d(0.5, 0.5, 0.5));
}

}  // namespace
