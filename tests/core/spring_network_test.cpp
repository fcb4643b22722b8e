// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>

#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <cmath>

using limber::SpringKind;
using limber::SpringNetwork;

namespace {

/// What validate() says about a cube with textures after `change`.
template <class Change>
std::string validateChanged(Change change) {
  limber::TriangleMesh mesh = small_meshes::cube();
  mesh.uvs.resize(mesh.positions.size(), Eigen::Vector2f::Zero());
  SpringNetwork network = **buildNetwork(mesh);
  change(network);
  return validate(network);
}

}  // namespace

TEST(SpringNetwork, soundNetwork) {
  EXPECT_EQ(validateChanged([](SpringNetwork&) {}), "");
}

TEST(SpringNetwork, emptyNetwork) { EXPECT_EQ(validate(SpringNetwork{}), "the network has no points"); }

TEST(SpringNetwork, nanPoint) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.restPoints[5].z() = std::nan(""); }),
            "point 5 is not finite");
}

TEST(SpringNetwork, massShares) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.massShares.pop_back(); }), "7 mass shares for 8 points");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.massShares[2] = 0.0; }), "mass share 2 is not above 0");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.massShares[3] = std::nan(""); }),
            "mass share 3 is not above 0");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.massShares[0] = 0.25; }),
            "the mass shares sum to 1.125000, not to 1");
}

TEST(SpringNetwork, springEnds) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { std::swap(n.springs[1].a, n.springs[1].b); }),
            "spring 1 does not go from a lower to a higher point");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.springs[1].b = n.springs[1].a; }),
            "spring 1 does not go from a lower to a higher point");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.springs.back().b = 8; }), "spring 23 uses point 8 of 8");
}

TEST(SpringNetwork, springOrder) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { std::swap(n.springs[6], n.springs[7]); }),
            "spring 7 is not in the order of its points");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.springs.insert(n.springs.begin(), n.springs.front()); }),
            "spring 1 joins the same points as the one before");
}

TEST(SpringNetwork, stiffnessScale) {
  for (const double scale : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(validateChanged([&](SpringNetwork& n) { n.springs[4].stiffnessScale = scale; }),
              "spring 4 has a stiffness scale that is not above 0");
  }
}

TEST(SpringNetwork, surfaceTriangles) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.surface[3][1] = 8; }),
            "surface triangle 3 uses point 8 of 8");
}

TEST(SpringNetwork, renderSurface) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.render.uvs.pop_back(); }),
            "23 texture coordinates for 24 render vertices");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.render.vertexToPoint[9] = 8; }),
            "render vertex 9 rides on point 8 of 8");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.render.triangles[2][0] = 24; }),
            "render triangle 2 uses vertex 24 of 24");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.render.vertexToPoint[0] = limber::kNoPoint; }),
            "render triangle 0 uses vertex 0, which rides on no point");
}

TEST(SpringNetwork, ropeWithASurface) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.kind = limber::NetworkKind::Rope; }),
            "a rope has no surface");
}
