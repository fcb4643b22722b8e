// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>

#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <set>

using limber::BraceRule;
using limber::NetworkSettings;
using limber::NetworkSpring;
using limber::Result;
using limber::SharedNetwork;
using limber::SpringKind;
using limber::SpringNetwork;
using limber::TriangleMesh;

namespace {

NetworkSettings equalLength() {
  NetworkSettings settings;
  settings.braces = BraceRule::EqualLength;
  return settings;
}

SharedNetwork validNetwork(const TriangleMesh& mesh, const NetworkSettings& settings = equalLength()) {
  Result<SharedNetwork> network = buildNetwork(mesh, settings);
  if (!network) {
    ADD_FAILURE() << network.error();
    return std::make_shared<SpringNetwork>();
  }
  EXPECT_EQ(validate(**network).error(), "");
  return *network;
}

std::size_t countOf(const SpringNetwork& network, SpringKind kind) {
  std::size_t count = 0;
  for (const NetworkSpring& spring : network.springs) count += spring.kind == kind;
  return count;
}

double lengthOf(const SpringNetwork& network, std::uint32_t a, std::uint32_t b) {
  return (network.restPoints[a] - network.restPoints[b]).norm();
}

struct Counts {
  std::size_t points, edges, braces;
};

void expectCounts(const TriangleMesh& mesh, const Counts& counts) {
  const SharedNetwork network = validNetwork(mesh);
  EXPECT_EQ(network->restPoints.size(), counts.points);
  EXPECT_EQ(countOf(*network, SpringKind::Structural), counts.edges);
  EXPECT_EQ(countOf(*network, SpringKind::Brace), counts.braces);
  EXPECT_EQ(network->springs.size(), counts.edges + counts.braces);
}

/// The brace rule, implemented directly: all pairs that are not edges and have the length of an edge.
std::set<std::pair<std::uint32_t, std::uint32_t>> bracesByBruteForce(const SpringNetwork& bare) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges, braces;
  for (const NetworkSpring& spring : bare.springs) edges.insert({spring.a, spring.b});
  for (std::uint32_t a = 0; a < bare.restPoints.size(); ++a) {
    for (std::uint32_t b = a + 1; b < bare.restPoints.size(); ++b) {
      if (edges.count({a, b}) > 0) continue;
      for (const NetworkSpring& spring : bare.springs) {
        const double length = lengthOf(bare, spring.a, spring.b);
        if (std::abs(lengthOf(bare, a, b) - length) <= 1e-5 * length) braces.insert({a, b});
      }
    }
  }
  return braces;
}

}  // namespace

TEST(NetworkFromMesh, singleTriangle) {
  const SharedNetwork network = validNetwork(small_meshes::singleTriangle());
  ASSERT_EQ(network->springs.size(), 3u);
  EXPECT_EQ(network->kind, limber::NetworkKind::Solid);
  EXPECT_EQ(network->springs[1].a, 0u);
  EXPECT_EQ(network->springs[1].b, 2u);
  EXPECT_EQ(network->springs[1].kind, SpringKind::Structural);
  EXPECT_EQ(network->springs[1].stiffnessScale, 1.0);
}

TEST(NetworkFromMesh, equalLengthBracesOfCubes) {
  expectCounts(small_meshes::cube(1), {8, 18, 6});
  expectCounts(small_meshes::cube(2), {26, 72, 36});
  expectCounts(small_meshes::cube(4), {98, 288, 132});
}

TEST(NetworkFromMesh, equalLengthBracesOfIcospheres) {
  expectCounts(small_meshes::icosphere(1), {42, 120, 0});
  expectCounts(small_meshes::icosphere(2), {162, 480, 0});
}

// Braces of a cube of n x n cells per face: the second diagonal of each of the 6 n^2 cells, and across each
// of the 12 edges a diagonal between the n - 1 pairs of points next to that edge.
TEST(NetworkFromMesh, equalLengthBracesOfAFineCube) {
  constexpr std::size_t n = 29;
  expectCounts(small_meshes::cube(n), {6 * n * n + 2, 18 * n * n, 6 * n * n + 12 * (n - 1)});
}

TEST(NetworkFromMesh, equalLengthAgreesWithSearchOfAll) {
  std::mt19937 random(3);
  TriangleMesh mesh = small_meshes::cube(3);
  // changes lengths of 0.33 m by up to 6e-6 m; differences up to 3e-6 m still count as equal
  for (Eigen::Vector3d& p : mesh.positions) p *= 1.0 + 1e-6 * static_cast<double>(random() % 8);
  NetworkSettings settings = equalLength();
  settings.weldTolerance = 1e-4;
  const SharedNetwork braced = validNetwork(mesh, settings);
  settings.braces = BraceRule::None;
  const auto expected = bracesByBruteForce(*validNetwork(mesh, settings));
  EXPECT_GT(expected.size(), 54u);
  std::set<std::pair<std::uint32_t, std::uint32_t>> found;
  for (const NetworkSpring& spring : braced->springs) {
    if (spring.kind == SpringKind::Brace) found.insert({spring.a, spring.b});
  }
  EXPECT_EQ(found, expected);
}

TEST(NetworkFromMesh, bracesAreAsLongAsTheFaceDiagonalsOfTheCube) {
  const SharedNetwork cube = validNetwork(small_meshes::cube());
  for (const NetworkSpring& spring : cube->springs) {
    if (spring.kind != SpringKind::Brace) continue;
    EXPECT_NEAR(lengthOf(*cube, spring.a, spring.b), std::sqrt(2.0), 1e-12);
  }
}

TEST(NetworkFromMesh, braceWeight) {
  NetworkSettings settings = equalLength();
  for (const std::optional<double> weight : {std::optional(0.25), std::optional<double>()}) {
    settings.braceWeight = weight;
    const SharedNetwork cube = validNetwork(small_meshes::cube(), settings);
    for (const NetworkSpring& spring : cube->springs) {
      const bool brace = spring.kind == SpringKind::Brace;
      EXPECT_EQ(spring.stiffnessScale, brace ? weight.value_or(1.0) : 1.0);
    }
  }
}

TEST(NetworkFromMesh, settingsOutOfRangeAreNamed) {
  const auto error = [](auto change) {
    NetworkSettings settings = equalLength();
    change(settings);
    return buildNetwork(small_meshes::cube(), settings).error();
  };
  EXPECT_EQ(error([](auto& s) { s.braceWeight = -1.0; }), "braceWeight is -1.000000, must be above 0");
  EXPECT_EQ(error([](auto& s) { s.maxBracesPerPoint = 0.0; }),
            "maxBracesPerPoint is 0.000000, must be above 0");
  EXPECT_EQ(error([](auto& s) { s.timeLimit = -2.0; }), "timeLimit is -2.000000, must be 0 or more");
  EXPECT_EQ(error([](auto& s) { s.braces = static_cast<BraceRule>(9); }), "braces is no value of BraceRule");
  EXPECT_EQ(error([](auto& s) { s.masses = static_cast<limber::MassRule>(9); }),
            "masses is no value of MassRule");
  for (const double weight : {std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_NE(error([weight](auto& s) { s.braceWeight = weight; }), "") << weight;
}

TEST(NetworkFromMesh, noBraces) {
  NetworkSettings settings;
  settings.braces = BraceRule::None;
  EXPECT_EQ(validNetwork(small_meshes::cube(), settings)->springs.size(), 18u);
}

TEST(NetworkFromMesh, equalMassShares) {
  const SharedNetwork network = validNetwork(small_meshes::cube(12));
  const double sum = std::accumulate(network->massFractions.begin(), network->massFractions.end(), 0.0);
  EXPECT_NEAR(sum, 1.0, 1e-12);
  for (const double fraction : network->massFractions) EXPECT_EQ(fraction, network->massFractions.front());
}

TEST(NetworkFromMesh, weldErrorsPassThrough) {
  TriangleMesh mesh = small_meshes::singleTriangle();
  mesh.positions[1].x() = std::nan("");
  EXPECT_EQ(buildNetwork(mesh).error(), "the position of vertex 1 is not finite");
  NetworkSettings settings = equalLength();
  settings.weldTolerance = -1.0;
  EXPECT_FALSE(buildNetwork(small_meshes::cube(), settings));
}

TEST(NetworkFromMesh, isolatedVertexBecomesNoPoint) {
  const SharedNetwork network = validNetwork(small_meshes::isolatedVertex());
  EXPECT_EQ(network->restPoints.size(), 3u);
  EXPECT_EQ(network->render.vertexToPoint[0], limber::kNoPoint);
  EXPECT_EQ(network->render.triangles, (std::vector<limber::Triangle>{{1, 2, 3}}));
  EXPECT_EQ(network->surface, (std::vector<limber::Triangle>{{0, 1, 2}}));
  EXPECT_EQ(network->report.isolatedVertices, 1u);
}

TEST(NetworkFromMesh, renderSurfaceKeepsTheSeams) {
  TriangleMesh mesh = small_meshes::cube(2);
  for (const Eigen::Vector3d& p : mesh.positions) mesh.uvs.emplace_back(p.cast<float>().head<2>());
  mesh.triangles.insert(mesh.triangles.begin(), {0, 0, 1});
  const limber::RenderSurface render = validNetwork(mesh)->render;
  EXPECT_EQ(render.vertexToPoint.size(), mesh.positions.size());
  EXPECT_EQ(render.uvs, mesh.uvs);
  mesh.triangles.erase(mesh.triangles.begin());
  EXPECT_EQ(render.triangles, mesh.triangles);
}

TEST(NetworkFromMesh, surfaceAndRenderTrianglesCoincide) {
  const SharedNetwork network = validNetwork(small_meshes::cube(3));
  ASSERT_EQ(network->surface.size(), network->render.triangles.size());
  for (std::size_t i = 0; i < network->surface.size(); ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      EXPECT_EQ(network->render.vertexToPoint[network->render.triangles[i][corner]],
                network->surface[i][corner]);
    }
  }
}
