// SPDX-License-Identifier: Zlib
#include "import/temporary_folder.h"
#include "scenes/arrangement.h"
#include "scenes/networks.h"
#include "scenes/scene_list.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

namespace limber::scenes {
namespace {

SceneOptions optionsFor(std::uint64_t seed) {
  SceneOptions options;
  options.count = 3;
  options.seed = seed;
  options.meshFile = LIMBER_MESH_DIR "/l_shape.obj";
  return options;
}

std::uint64_t hashAfter(const SceneEntry& entry, std::uint64_t seed, int ticks) {
  const SceneResult scene = entry.create(optionsFor(seed));
  EXPECT_TRUE(scene) << scene.error();
  for (int i = 0; i < ticks; ++i) tick(**scene);
  return stateHash(**scene);
}

TEST(Scenes, sameSeedSameBits) {
  for (const SceneEntry& entry : sceneList())
    EXPECT_EQ(hashAfter(entry, 1, 60), hashAfter(entry, 1, 60)) << entry.name;
}

TEST(Scenes, otherSeedOtherBits) {
  for (const SceneEntry& entry : sceneList())
    EXPECT_NE(hashAfter(entry, 1, 2), hashAfter(entry, 2, 2)) << entry.name;
}

TEST(Scenes, takeTheUsersChoicesAndHaveALookForEveryBody) {
  SceneOptions options = optionsFor(1);
  options.stiffness = 123.0;
  options.damping = 0.5;
  options.mass = 2.0;
  for (const SceneEntry& entry : sceneList()) {
    const SceneResult scene = entry.create(options);
    ASSERT_TRUE(scene) << scene.error();
    const std::size_t bodies = entry.bodies > 0 ? entry.bodies : 3;
    ASSERT_EQ((*scene)->soft->bodyCount(), bodies) << entry.name;
    EXPECT_EQ((*scene)->looks.size(), bodies) << entry.name;
    EXPECT_FALSE((*scene)->endChecks.empty());
    EXPECT_FALSE((*scene)->view.box.isEmpty());
    const SoftBody& body = *(*scene)->soft->body(bodies - 1);
    EXPECT_EQ(body.settings().extensionStiffness, 123.0);
    EXPECT_EQ(body.settings().compressionStiffness, 123.0);
    EXPECT_EQ(body.settings().damping, 0.5);
    double pinned = 0.0;
    for (std::uint32_t i = 0; i < body.pointCount(); ++i)
      if (body.pinned(i)) pinned += body.network().massFractions[i];
    EXPECT_NEAR(body.totalMass(), 2.0 * (1.0 - pinned), 1e-6) << "what is pinned does not count";
  }
}

TEST(Scenes, meshIsMadeOneMetreLargeUnlessScaled) {
  SceneOptions options = optionsFor(1);
  options.meshFile = LIMBER_MESH_DIR "/torus.obj";
  const SceneResult fitted = createMeshDrop(options);
  options.scale = 3.0;
  const SceneResult scaled = createMeshDrop(options);
  ASSERT_TRUE(fitted) << fitted.error();
  ASSERT_TRUE(scaled) << scaled.error();
  EXPECT_EQ((*scaled)->soft->body(0)->settings().scale, Eigen::Vector3d::Constant(3.0));
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : (*fitted)->soft->body(0)->network().restPoints) box.extend(p);
  EXPECT_NEAR(box.sizes().maxCoeff() * (*fitted)->soft->body(0)->settings().scale.x(), 1.0, 1e-12);
}

/// A .limber file has all that the material of a rope or a sheet needs.
TEST(Scenes, cookedRopesAndSheetsAreDropped) {
  const TemporaryFolder folder;
  SceneOptions options;
  options.count = 1;
  options.meshFile = folder.path() + "/body.limber";
  RopeSettings rope;
  rope.length = 2.0;
  rope.thickness = 0.02;
  ClothSettings sheet;
  sheet.thickness = 0.005;
  for (const SharedNetwork& network : {*buildRope(rope), *buildCloth(sheet)}) {
    ASSERT_EQ(saveNetwork(*network, options.meshFile).error(), "");
    const SceneResult scene = createMeshDrop(options);
    ASSERT_TRUE(scene) << scene.error();
    const SoftBodySettings& made = (*scene)->soft->body(0)->settings();
    const bool isRope = network->kind == NetworkKind::Rope;  // the rope of 2 m becomes one of 1 m
    EXPECT_NEAR(made.totalMass, 1100.0 * (isRope ? 1e-4 * 0.78539816 : 0.005), 1e-6);
    EXPECT_NEAR(*made.pointRadius, isRope ? 0.005 : 0.0025, 1e-12);
  }
}

TEST(Scenes, missingMeshIsNamed) {
  SceneOptions options;
  options.meshFile = "no/such.obj";
  const SceneResult scene = createMeshDrop(options);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().find("no/such.obj"), std::string::npos);
}

TEST(DropGrid, keepsBodiesApart) {
  for (const std::uint32_t count : {1u, 2u, 5u, 64u, 65u}) {
    Random random(1);
    const std::vector<Placement> placements = dropGrid({count, 2.0, 1.0, 3.0}, random);
    ASSERT_EQ(placements.size(), count);
    for (std::size_t a = 0; a < count; ++a) {
      EXPECT_GE(placements[a].centre.y(), 1.0);
      EXPECT_LE(placements[a].centre.y(), 3.0);
      for (std::size_t b = 0; b < a; ++b) {
        const Eigen::Vector3d offset = placements[a].centre - placements[b].centre;
        EXPECT_GE(std::hypot(offset.x(), offset.z()), 2.0 - 1e-9);
      }
    }
  }
}

TEST(SurfaceBend, tellsBallsFromBoxes) {
  const auto bend = [](const char* file) {
    const Result<TriangleMesh> mesh = importMesh(std::string(LIMBER_MESH_DIR "/") + file);
    return sharpestBend(**buildNetwork(*mesh));
  };
  EXPECT_NEAR(bend("cube.obj"), 1.5708, 1e-3);
  EXPECT_LT(bend("icosphere.obj"), kSmoothBend);
}

}  // namespace
}  // namespace limber::scenes
