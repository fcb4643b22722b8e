// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>

#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <cmath>

using limber::BraceRule;
using limber::NetworkSettings;
using limber::SpringKind;
using limber::SpringNetwork;

namespace {

/// Returns the result of validate() for a textured cube after `change`.
template <class Change>
std::string validateChanged(Change change) {
  limber::TriangleMesh mesh = small_meshes::cube();
  mesh.uvs.resize(mesh.positions.size(), Eigen::Vector2f::Zero());
  NetworkSettings settings;
  settings.braces = BraceRule::EqualLength;
  SpringNetwork network = **buildNetwork(mesh, settings);
  change(network);
  return validate(network).error();
}

}  // namespace

TEST(SpringNetwork, soundNetwork) {
  EXPECT_EQ(validateChanged([](SpringNetwork&) {}), "");
}

TEST(SpringNetwork, emptyNetwork) {
  EXPECT_EQ(validate(SpringNetwork{}).error(), "the network has no points");
}

TEST(SpringNetwork, nanPoint) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.restPoints[5].z() = std::nan(""); }),
            "point 5 is not finite");
}

TEST(SpringNetwork, pointBeyondTheBound) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.restPoints[5].x() = 1e62; }),
            "point 5 has a coordinate beyond 1e9");
}

TEST(SpringNetwork, unknownKinds) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.kind = static_cast<limber::NetworkKind>(9); }),
            "the network has an unknown kind");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.springs[2].kind = static_cast<SpringKind>(77); }),
            "spring 2 has an unknown kind");
}

TEST(SpringNetwork, massFractions) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.massFractions.pop_back(); }),
            "7 mass fractions for 8 points");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.massFractions[2] = 0.0; }),
            "mass fraction 2 is not above 0");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.massFractions[3] = std::nan(""); }),
            "mass fraction 3 is not above 0");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.massFractions[0] = 0.25; }),
            "the mass fractions sum to 1.125000, not to 1");
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
            "render vertex 9 follows point 8 of 8");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.render.triangles[2][0] = 24; }),
            "render triangle 2 uses vertex 24 of 24");
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.render.vertexToPoint[0] = limber::kNoPoint; }),
            "render triangle 0 uses vertex 0, which follows no point");
}

TEST(SpringNetwork, ropeWithASurface) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.kind = limber::NetworkKind::Rope; }),
            "a rope has no surface, skin or tetrahedra");
}

namespace {

/// The same for vertices on two points of a skin: the first network point, and the middle of the next two.
template <class Change>
std::string validateSkinned(Change change) {
  return validateChanged([&](SpringNetwork& n) {
    n.render.skin = {{0, 1, 3}, {0, 1, 2}, {1.0f, 0.5f, 0.5f}};
    for (std::uint32_t& skinPoint : n.render.vertexToPoint) skinPoint %= 2;
    change(n);
  });
}

}  // namespace

TEST(SpringNetwork, skinSizes) {
  EXPECT_EQ(validateSkinned([](SpringNetwork&) {}), "");
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.skin.weights.pop_back(); }),
            "the skin has 2 weights for 3 points");
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.skin.firstWeight.back() = 4; }),
            "the skinned points have 4 weights, there are 3");
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.skin.firstWeight.clear(); }),
            "the skinned points have 0 weights, there are 3");
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.skin.firstWeight.front() = 1; }),
            "the first skinned point does not begin at weight 0");
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.skin.firstWeight[1] = 3; }),
            "skinned point 1 has no weights");
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.skin.firstWeight[1] = 900; }),
            "skinned point 1 has no weights");
}

TEST(SpringNetwork, skinPlaces) {
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.skin.points[2] = 8; }),
            "skinned point 1 follows point 8 of 8");
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.skin.weights[1] = std::nanf(""); }),
            "skinned point 1 has a weight that is not finite");
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.skin.weights[0] = 0.9f; }),
            "skinned point 0 has weights that do not sum to 1");
  EXPECT_EQ(validateSkinned([](SpringNetwork& n) { n.render.vertexToPoint[3] = 2; }),
            "render vertex 3 follows skinned point 2 of 2");
}

namespace {

/// Returns the result of validate() for a network whose points 0 to 3 are the origin and the unit vectors.
std::string validateTetrahedron(const limber::Tetrahedron& t) {
  return validateChanged([&](SpringNetwork& n) {
    n.restPoints[0].setZero();
    for (int axis = 0; axis < 3; ++axis) n.restPoints[std::size_t(axis) + 1] = Eigen::Vector3d::Unit(axis);
    n.tetrahedra = {{0, 1, 2, 3}, t};
  });
}

}  // namespace

TEST(SpringNetwork, tetrahedra) {
  EXPECT_EQ(validateTetrahedron({0, 1, 2, 7}), "");
  EXPECT_EQ(validateTetrahedron({1, 2, 0, 3}), "a tetrahedron of point 0, 1, 2 and 3 occurs twice");
  EXPECT_EQ(validateTetrahedron({0, 1, 8, 3}), "tetrahedron 1 uses point 8 of 8");
  EXPECT_EQ(validateTetrahedron({0, 2, 1, 3}), "tetrahedron 1 has a volume that is not above 0");
  EXPECT_EQ(validateTetrahedron({0, 1, 1, 3}), "tetrahedron 1 has a volume that is not above 0");
}

TEST(SpringNetwork, stiffnessPerModulusThicknessAndVolume) {
  EXPECT_EQ(validateChanged([](SpringNetwork& n) { n.stiffnessPerModulus = n.thickness = n.volume = 0.2; }),
            "");
  for (const double value : {-1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(validateChanged([&](SpringNetwork& n) { n.stiffnessPerModulus = value; }),
              "the stiffness per modulus is not a finite number of 0 or more");
    EXPECT_EQ(validateChanged([&](SpringNetwork& n) { n.thickness = value; }),
              "the thickness is not a finite number of 0 or more");
    EXPECT_EQ(validateChanged([&](SpringNetwork& n) { n.volume = value; }),
              "the volume is not a finite number of 0 or more");
  }
}
