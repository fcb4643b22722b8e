// SPDX-License-Identifier: Zlib
#include "cook/cook_options.h"

#include "import/temporary_folder.h"

#include <limber/mesh.h>
#include <limber/spring_network.h>

#include <gtest/gtest.h>

#include <filesystem>

namespace limber::demo {
namespace {

namespace fs = std::filesystem;

CookOptions cooking(const std::string& mesh, const std::string& body = {}) {
  CookOptions options;
  options.meshFile = LIMBER_MESH_DIR "/" + mesh;
  options.bodyFile = body;
  options.network.braces = BraceRule::TwoRing;
  options.analysis.runs = 0;
  options.quiet = true;
  return options;
}

SharedNetwork cook(const CookOptions& options) {
  const Result<SharedNetwork> network = cookBody(options);
  if (!network) {
    ADD_FAILURE() << network.error();
    return std::make_shared<SpringNetwork>();
  }
  EXPECT_EQ(validate(**network).error(), "");
  return *network;
}

TEST(CookBody, theFileHoldsWhatTheLibraryMakesInProcess) {
  const TemporaryFolder folder;
  CookOptions options = cooking("torus.obj", folder.path() + "/torus.limber");
  options.network.braces = BraceRule::Pipeline;
  ASSERT_EQ(runCook(options), kSuccess);
  const Result<SharedNetwork> loaded = loadNetwork(options.bodyFile);
  ASSERT_TRUE(loaded) << loaded.error();
  const Result<TriangleMesh> mesh = importMesh(options.meshFile);
  ASSERT_TRUE(mesh) << mesh.error();
  EXPECT_EQ(toBytes(**loaded), toBytes(**buildNetwork(*mesh, options.network)));
}

TEST(CookBody, aSimplifiedBodyIsDrawnInFull) {
  CookOptions options = cooking("figure.obj");
  const SharedNetwork whole = cook(options);
  options.points = 100;
  const SharedNetwork coarse = cook(options);
  EXPECT_GE(coarse->restPoints.size(), 100u);
  EXPECT_LT(coarse->restPoints.size(), 120u);
  EXPECT_EQ(coarse->render.triangles.size(), whole->render.triangles.size());
  EXPECT_GT(coarse->render.skin.size(), coarse->restPoints.size());
}

TEST(CookBody, aCoarseMeshIsLeftAsItIs) {
  CookOptions options = cooking("cube.obj");
  const SharedNetwork whole = cook(options);
  options.points = 8;
  EXPECT_EQ(toBytes(*cook(options)), toBytes(*whole));
}

TEST(CookBody, weldingReachesTheSimplifiedMeshAndItsSkin) {
  CookOptions options = cooking("icosphere.obj");
  options.network.weldTolerance = 1e-3;
  options.points = 30;
  const SharedNetwork network = cook(options);
  EXPECT_LT(network->restPoints.size(), 40u);
  EXPECT_EQ(network->report.components, 1u);
}

TEST(CookBody, errorsNameTheMesh) {
  CookOptions options = cooking("cube.obj");
  options.network.maxBracesPerPoint = -1.0;
  options.network.braces = BraceRule::Pipeline;
  const std::string reason = cookBody(options).error();
  EXPECT_EQ(reason.rfind(options.meshFile + ": ", 0), 0u) << reason;
}

TEST(CookBody, aFailedCookLeavesNothingBehind) {
  const TemporaryFolder folder;
  CookOptions options = cooking("no_such.obj", folder.path() + "/a.limber");
  options.jsonFile = folder.path() + "/a.json";
  EXPECT_EQ(runCook(options), kFailure);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace limber::demo
