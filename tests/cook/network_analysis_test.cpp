// SPDX-License-Identifier: Zlib
#include <limber/network_analysis.h>

#include "support/network_shapes.h"
#include "support/networks.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using limber::analyse;
using limber::AnalysisSettings;
using limber::NetworkAnalysis;
using limber::NetworkKind;
using limber::ReturnRate;
using limber::Rigidity;
using limber::SharedNetwork;
using limber::SpringNetwork;
using network_shapes::bare;

namespace {

NetworkAnalysis analyseQuickly(const SpringNetwork& network) {
  AnalysisSettings settings;
  settings.runs = 0;
  return analyse(network, settings);
}

bool saysOf(const NetworkAnalysis& analysis, const std::string& words) {
  return std::any_of(analysis.remarks.begin(), analysis.remarks.end(),
                     [&](const std::string& r) { return r.find(words) != std::string::npos; });
}

}  // namespace

TEST(Analyse, gradesOfTheNotes) {
  EXPECT_EQ(analyseQuickly(*bare(network_shapes::cube26())).rigidity, Rigidity::Flexible);
  EXPECT_EQ(analyseQuickly(*bare(network_shapes::noise162())).rigidity, Rigidity::NearlyFlexible);
  EXPECT_EQ(analyseQuickly(*bare(network_shapes::star162())).rigidity, Rigidity::Soft);
  const NetworkAnalysis ico = analyseQuickly(*bare(network_shapes::ico42()));
  EXPECT_EQ(ico.rigidity, Rigidity::Rigid);
  EXPECT_NEAR(ico.modeRatio, 3.4e-2, 5e-4);
}

TEST(Analyse, thePapersCube) {
  AnalysisSettings settings;
  settings.runs = 8;
  settings.stiffness = 20.0;
  const NetworkAnalysis cube = analyse(*bare(network_shapes::cube8()), settings);
  EXPECT_EQ(cube.kind, NetworkKind::Solid);
  EXPECT_EQ(cube.points, 8u);
  EXPECT_EQ(cube.springs, 18u);
  EXPECT_EQ(cube.braces, 0u);
  EXPECT_EQ(cube.mechanisms, 0u) << "its collapse is no mechanism";
  EXPECT_TRUE(cube.globallyRigidKnown);
  EXPECT_FALSE(cube.globallyRigid);
  EXPECT_TRUE(saysOf(cube, "not globally rigid"));
  EXPECT_NEAR(cube.volume, 1.0, 1e-12);
  EXPECT_EQ(cube.springsOutside, 0u);
  EXPECT_TRUE(cube.mesh.watertight());
  EXPECT_EQ(cube.allReturns().runs, 40u);
  EXPECT_GT(cube.allReturns().rate(), 0.9) << "with its volume it comes back (the notes: 100 %)";
  EXPECT_LT(cube.safeTimeStep, cube.criticalTimeStep);
}

TEST(Analyse, tooSoftForItsWeight) {
  AnalysisSettings settings;
  settings.runs = 0;
  settings.totalMass = 1000.0;
  const NetworkAnalysis heavy = analyse(*limber::test::closedCubeNetwork(), settings);
  EXPECT_NEAR(heavy.leastStiffness,
              1000.0 * analyseQuickly(*limber::test::closedCubeNetwork()).leastStiffness,
              1e-9 * heavy.leastStiffness);
  settings.stiffness = 0.5 * heavy.leastStiffness;
  EXPECT_TRUE(
      saysOf(analyse(*limber::test::closedCubeNetwork(), settings), "collapses under its own weight"));
  settings.stiffness = 2.0 * heavy.leastStiffness;
  EXPECT_FALSE(
      saysOf(analyse(*limber::test::closedCubeNetwork(), settings), "collapses under its own weight"));
}

TEST(Analyse, flatBodiesAreJudgedInTheirPlane) {
  const NetworkAnalysis cloth = analyseQuickly(*bare(network_shapes::cloth100()));
  EXPECT_EQ(cloth.kind, NetworkKind::Cloth);
  EXPECT_EQ(cloth.mechanisms, 97u) << "one for each point, without the plane's own three";
  EXPECT_EQ(cloth.rigidity, Rigidity::Rigid);
  EXPECT_NEAR(cloth.modeRatio, 0.073 / 6.6, 2e-4);
  EXPECT_EQ(cloth.leastStiffness, 0.0);
  EXPECT_TRUE(saysOf(cloth, "it is limp"));
  EXPECT_FALSE(saysOf(cloth, "besides bending"));

  limber::ClothSettings shearless;
  shearless.shearScale = 0.0;
  shearless.columns = shearless.rows = 4;
  const NetworkAnalysis net = analyseQuickly(**buildCloth(shearless));
  EXPECT_EQ(net.rigidity, Rigidity::Flexible);
  EXPECT_TRUE(saysOf(net, "besides bending"));
  EXPECT_TRUE(saysOf(net, "bending springs do once it is bent"));
}

TEST(Analyse, ropesAreJudgedAlongTheirLine) {
  const NetworkAnalysis rope = analyseQuickly(*network_shapes::rope20());
  EXPECT_EQ(rope.kind, NetworkKind::Rope);
  EXPECT_EQ(rope.mechanisms, 36u);
  EXPECT_EQ(rope.selfStresses, 0u);
  EXPECT_EQ(rope.rigidity, Rigidity::Rigid);
  SpringNetwork cut = *network_shapes::rope20();
  cut.springs.erase(cut.springs.begin() + 9);
  const NetworkAnalysis parts = analyseQuickly(cut);
  EXPECT_EQ(parts.rigidity, Rigidity::Flexible);
  EXPECT_TRUE(saysOf(parts, "2 pieces that no spring joins"));
}

TEST(Analyse, springsThatLeaveTheBody) {
  SpringNetwork l = *bare(network_shapes::lshape90());
  EXPECT_EQ(analyseQuickly(l).springsOutside, 0u);
  const auto at = [&](double x, double y, double z) {
    const Eigen::Vector3d place(x, y, z);
    for (std::uint32_t i = 0; i < l.restPoints.size(); ++i)
      if ((l.restPoints[i] - place).norm() < 1e-9) return i;
    return 0xffffffffu;
  };
  // from the end of one arm to the end of the other, and through an arm
  const std::uint32_t a = at(-0.5 + 1.0 / 6, 0.5, 0.0), b = at(0.5, -0.5 + 1.0 / 6, 0.0),
                      c = at(-0.5, 0.0, 0.0), d = at(-0.5 + 1.0 / 3, 0.0, 0.0);
  ASSERT_NE(std::max({a, b, c, d}), 0xffffffffu);
  l.springs.push_back({std::min(a, b), std::max(a, b), limber::SpringKind::Brace, 0.3});
  l.springs.push_back({std::min(c, d), std::max(c, d), limber::SpringKind::Brace, 0.3});
  const NetworkAnalysis analysis = analyseQuickly(l);
  EXPECT_EQ(analysis.springsOutside, 1u);
  EXPECT_EQ(analysis.braces, 2u);
  EXPECT_TRUE(saysOf(analysis, "1 spring leaves"));
}

TEST(Analyse, badSurfacesAreReported) {
  const NetworkAnalysis fin = analyseQuickly(*bare(small_meshes::nonManifoldEdge()));
  EXPECT_TRUE(saysOf(fin, "more than two triangles"));
  EXPECT_TRUE(saysOf(fin, "the surface is open"));
  EXPECT_EQ(fin.volume, 0.0);
  EXPECT_TRUE(saysOf(analyseQuickly(*bare(small_meshes::flippedTriangle())), "face opposite ways"));
  EXPECT_TRUE(saysOf(analyseQuickly(*bare(small_meshes::twoIslands())), "2 pieces"));
}

TEST(Analyse, smallestNetworks) {
  const NetworkAnalysis pair = analyseQuickly(*limber::test::pairNetwork());
  EXPECT_EQ(pair.kind, NetworkKind::Rope);
  EXPECT_EQ(pair.mechanisms, 0u);
  EXPECT_EQ(pair.rigidity, Rigidity::Rigid);
  EXPECT_EQ(analyseQuickly(*bare(small_meshes::singleTriangle())).mechanisms, 0u);
}

TEST(Analyse, sameEveryTime) {
  AnalysisSettings settings;
  settings.runs = 3;
  const SharedNetwork cube = bare(network_shapes::cube26());
  EXPECT_EQ(describe(analyse(*cube, settings)), describe(analyse(*cube, settings)));
}

TEST(Describe, saysWhatWasFound) {
  const std::string text = describe(analyseQuickly(*bare(network_shapes::cube26())));
  for (const char* words :
       {"solid: 26 points, 72 springs, 0 of them braces", "watertight", "flexible: rank 66",
        "6 mechanisms, 6 self-stresses", "! 6 deformations stretch no spring"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " in\n" << text;
}

TEST(ReturnRate, standardError) {
  EXPECT_EQ(ReturnRate{}.rate(), 0.0);
  EXPECT_EQ(ReturnRate{}.standardError(), 0.0);
  const ReturnRate half{100, 50, 0};
  EXPECT_NEAR(half.standardError(), 0.05, 1e-12);
}
