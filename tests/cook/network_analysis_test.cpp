// SPDX-License-Identifier: Zlib
#include <limber/network_analysis.h>
#include <limber/spring_network.h>

#include "mesh/random.h"
#include "support/network_shapes.h"
#include "support/networks.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

bool hasRemark(const NetworkAnalysis& analysis, const std::string& text) {
  return std::any_of(analysis.remarks.begin(), analysis.remarks.end(),
                     [&](const std::string& r) { return r.find(text) != std::string::npos; });
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
  EXPECT_TRUE(hasRemark(cube, "not globally rigid"));
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
  EXPECT_NEAR(*heavy.standingStiffness,
              1000.0 * *analyseQuickly(*limber::test::closedCubeNetwork()).standingStiffness,
              1e-9 * *heavy.standingStiffness);
  settings.stiffness = 0.5 * *heavy.standingStiffness;
  EXPECT_TRUE(hasRemark(analyse(*limber::test::closedCubeNetwork(), settings),
                        "below 90 % of its height under its own weight"));
  settings.stiffness = 2.0 * *heavy.standingStiffness;
  EXPECT_FALSE(hasRemark(analyse(*limber::test::closedCubeNetwork(), settings),
                         "below 90 % of its height under its own weight"));
}

TEST(Analyse, flatBodiesAreJudgedInTheirPlane) {
  const NetworkAnalysis cloth = analyseQuickly(*bare(network_shapes::cloth100()));
  EXPECT_EQ(cloth.kind, NetworkKind::Cloth);
  EXPECT_EQ(cloth.mechanisms, 97u) << "one for each point, without the plane's own three";
  EXPECT_EQ(cloth.rigidity, Rigidity::Rigid);
  EXPECT_NEAR(cloth.modeRatio, 0.073 / 6.6, 2e-4);
  EXPECT_FALSE(cloth.standingStiffness);
  EXPECT_TRUE(hasRemark(cloth, "it folds freely"));
  EXPECT_FALSE(hasRemark(cloth, "besides bending"));

  limber::ClothSettings shearless;
  shearless.shearScale = 0.0;
  shearless.columns = shearless.rows = 4;
  const NetworkAnalysis net = analyseQuickly(**buildCloth(shearless));
  EXPECT_EQ(net.rigidity, Rigidity::Flexible);
  EXPECT_TRUE(hasRemark(net, "besides bending"));
  EXPECT_TRUE(hasRemark(net, "bending springs resist once it is bent"));
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
  EXPECT_EQ(parts.rigidity, Rigidity::Rigid) << "each of them";
  EXPECT_EQ(parts.pieces, 2u);
  EXPECT_EQ(parts.mechanisms, 36u) << "not that along the line between them";
  EXPECT_TRUE(hasRemark(parts, "2 pieces that no spring joins"));
}

TEST(Analyse, aCurvedRopeFoldsAndIsNotJudgedAsASolid) {
  SpringNetwork rope = *network_shapes::rope20();
  for (Eigen::Vector3d& p : rope.restPoints) p += Eigen::Vector3d(0.0, std::cos(p.x()), std::sin(p.x()));
  const NetworkAnalysis curved = analyse(rope);
  EXPECT_EQ(curved.kind, NetworkKind::Solid) << "by its shape";
  EXPECT_TRUE(curved.folds);
  EXPECT_EQ(curved.allReturns().runs, 0u);
  EXPECT_FALSE(curved.standingStiffness);
  EXPECT_TRUE(curved.remarks.empty()) << curved.remarks.front();
  EXPECT_EQ(describe(curved).rfind("curved: 20 points", 0), 0u) << describe(curved);
}

TEST(Analyse, nearlyFlatIsFlat) {
  SpringNetwork cloth = *bare(network_shapes::cloth100());
  limber::Random random(1);
  for (Eigen::Vector3d& p : cloth.restPoints) p.y() += 6e-5 * (random.uniform() - 0.5);
  const NetworkAnalysis uneven = analyseQuickly(cloth);
  EXPECT_EQ(uneven.kind, NetworkKind::Cloth);
  EXPECT_EQ(uneven.mechanisms, 97u);
  EXPECT_EQ(uneven.rigidity, Rigidity::Rigid);
  SpringNetwork rope = *network_shapes::rope20();
  for (Eigen::Vector3d& p : rope.restPoints) p.z() += 3e-5 * (random.uniform() - 0.5);
  EXPECT_EQ(analyseQuickly(rope).rigidity, Rigidity::Rigid);
  EXPECT_EQ(analyseQuickly(rope).mechanisms, 36u);
}

/// Returns the mesh with a scaled copy at `displacement`, whose triangles are inverted.
limber::TriangleMesh withInvertedCopy(const limber::TriangleMesh& mesh, const Eigen::Vector3d& displacement,
                                      double scale) {
  return small_meshes::joined(mesh, small_meshes::inverted(small_meshes::moved(mesh, displacement, scale)));
}

TEST(Analyse, piecesAreJudgedEachByItself) {
  const NetworkAnalysis one = analyseQuickly(*bare(network_shapes::cube8()));
  const NetworkAnalysis two =
      analyseQuickly(*bare(withInvertedCopy(network_shapes::cube8(), {0, 3, 0}, 1.0)));
  EXPECT_EQ(two.pieces, 2u);
  EXPECT_TRUE(hasRemark(two, "2 pieces"));
  EXPECT_EQ(two.rank, 2 * one.rank);
  EXPECT_EQ(two.mechanisms, 0u);
  EXPECT_EQ(two.rigidity, one.rigidity);
  EXPECT_NEAR(two.modeRatio, one.modeRatio, 1e-9);
  EXPECT_EQ(two.globallyRigid, one.globallyRigid);
  EXPECT_NEAR(two.volume, 2.0, 1e-12);
  EXPECT_NEAR(*two.standingStiffness, 0.5 * *one.standingStiffness, 1e-6 * *one.standingStiffness);
  EXPECT_FALSE(hasRemark(two, "braces help"));
  EXPECT_FALSE(hasRemark(two, "collapses"));
}

TEST(Analyse, surfacesThatFaceInwardAreTurned) {
  AnalysisSettings settings;
  settings.runs = 2;
  const limber::TriangleMesh ball = network_shapes::ico42();
  const SharedNetwork outward = *limber::buildNetwork(ball);
  const SharedNetwork inward = *limber::buildNetwork(small_meshes::inverted(ball));
  EXPECT_EQ(inward->surface, outward->surface);
  EXPECT_EQ(inward->render.triangles, outward->render.triangles);
  EXPECT_EQ(describe(analyse(*inward, settings)), describe(analyse(*outward, settings)));
  SpringNetwork asItCame = *outward;
  for (limber::Triangle& t : asItCame.surface) std::swap(t[1], t[2]);
  EXPECT_EQ(analyse(asItCame, settings).springsOutside, 0u);
  EXPECT_GT(analyse(asItCame, settings).volume, 0.0);
}

TEST(Analyse, hollowsFaceIntoThemselves) {
  const limber::TriangleMesh shell = withInvertedCopy(network_shapes::cube8(), {0, 0, 0}, 0.5);
  const SharedNetwork hollow = bare(shell);
  EXPECT_EQ(hollow->render.triangles, shell.triangles);
  EXPECT_NEAR(analyseQuickly(*hollow).volume, 1.0 - 0.125, 1e-12);
  EXPECT_EQ(bare(small_meshes::inverted(shell))->surface, hollow->surface);
  EXPECT_NEAR(analyseQuickly(*bare(withInvertedCopy(network_shapes::cube8(), {2, 0, 0}, 0.5))).volume, 1.125,
              1e-12);
}

TEST(Analyse, extremeFilesEnd) {
  const SharedNetwork golden = *limber::loadNetwork(std::string(LIMBER_GOLDEN_DIR) + "/version-1.limber");
  const NetworkAnalysis a = analyse(*golden);
  EXPECT_FALSE(a.standingStiffness);
  EXPECT_EQ(a.allReturns().runs, 0u);
  EXPECT_GE(a.stiffestEigenvalue, 1e300);
  EXPECT_TRUE(hasRemark(a, "not known whether it carries its own weight"));
  EXPECT_TRUE(hasRemark(a, "were not tested"));
  EXPECT_FALSE(hasRemark(a, "however stiff"));
}

/// After progress() returned false it is not called again, at any stage.
TEST(Analyse, endsWhenProgressSaysSo) {
  const SharedNetwork cube = limber::test::closedCubeNetwork();
  AnalysisSettings settings;
  settings.runs = 3;
  int all = 0;
  settings.progress = [&](const char*, double done) {
    EXPECT_GE(done, 0.0);
    EXPECT_LE(done, 1.0);
    return ++all > 0;
  };
  std::vector<std::string> stages;
  EXPECT_FALSE(analyse(*cube, settings).endedEarly);
  for (int last = 1; last <= all; last += 1 + all / 50) {
    int calls = 0;
    settings.progress = [&](const char* what, double) {
      if (calls + 1 == last) stages.push_back(what);
      return ++calls < last;
    };
    const NetworkAnalysis a = analyse(*cube, settings);
    EXPECT_TRUE(a.endedEarly);
    EXPECT_EQ(calls, last);
    EXPECT_TRUE(hasRemark(a, "ended early"));
    EXPECT_FALSE(hasRemark(a, "collapses"));
  }
  for (const char* stage : {"small deformations", "global rigidity", "return rate", "own weight"})
    EXPECT_NE(std::find(stages.begin(), stages.end(), stage), stages.end()) << stage;
}

TEST(Analyse, springsThatLeaveTheBody) {
  SpringNetwork l = *bare(network_shapes::lshape90());
  EXPECT_EQ(analyseQuickly(l).springsOutside, 0u);
  const auto pointAt = [&](double x, double y, double z) {
    const Eigen::Vector3d position(x, y, z);
    for (std::uint32_t i = 0; i < l.restPoints.size(); ++i)
      if ((l.restPoints[i] - position).norm() < 1e-9) return i;
    return 0xffffffffu;
  };
  // one spring from the end of one arm to the end of the other, and one through an arm
  const std::uint32_t a = pointAt(-0.5 + 1.0 / 6, 0.5, 0.0), b = pointAt(0.5, -0.5 + 1.0 / 6, 0.0),
                      c = pointAt(-0.5, 0.0, 0.0), d = pointAt(-0.5 + 1.0 / 3, 0.0, 0.0);
  ASSERT_NE(std::max({a, b, c, d}), 0xffffffffu);
  l.springs.push_back({std::min(a, b), std::max(a, b), limber::SpringKind::Brace, 0.3});
  l.springs.push_back({std::min(c, d), std::max(c, d), limber::SpringKind::Brace, 0.3});
  const NetworkAnalysis analysis = analyseQuickly(l);
  EXPECT_EQ(analysis.springsOutside, 1u);
  EXPECT_EQ(analysis.braces, 2u);
  EXPECT_TRUE(hasRemark(analysis, "1 spring leaves"));
}

TEST(Analyse, badSurfacesAreReported) {
  const NetworkAnalysis fin = analyseQuickly(*bare(small_meshes::nonManifoldEdge()));
  EXPECT_TRUE(hasRemark(fin, "more than two triangles"));
  EXPECT_TRUE(hasRemark(fin, "the surface is open"));
  EXPECT_EQ(fin.volume, 0.0);
  EXPECT_TRUE(hasRemark(analyseQuickly(*bare(small_meshes::flippedTriangle())), "face opposite directions"));
  EXPECT_TRUE(hasRemark(analyseQuickly(*bare(small_meshes::twoIslands())), "2 pieces"));
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
