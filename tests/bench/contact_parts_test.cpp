// SPDX-License-Identifier: Zlib
// The measurements of the contact bench, compared with known values.
#include "contact/contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace limber::bench {
namespace {

/// Returns a scene with only a cube of 1 m in the air, at rest at the start.
ContactScene fallingCube(int settle, int measured) {
  ContactScene scene;
  scene.name = "falling";
  scene.bodies = {bodyOf(closedCubeNetwork(), 0.8, 1000.0, 1.0)};
  scene.bodies[0].settings.position.y() = 20.0;
  scene.bodies[0].settings.pointRadius = 0.02;
  scene.addRigidBodies = [](RigidBodies&) {};
  scene.distance = [](const Eigen::Vector3d& x) { return x.y(); };
  scene.settleTicks = settle;
  scene.measuredTicks = measured;
  return scene;
}

EngineChoice engineOf(const std::string& name) {
  for (EngineChoice& choice : contactEngines())
    if (choice.engine + choice.setting == name) return std::move(choice);
  return {};
}

TEST(BoxSurface, isClosedOutwardAndOfTheBoxsVolume) {
  for (const int side : {2, 3, 5}) {
    const SharedNetwork lattice = latticeNetwork(side, side, side, 1.0 / (side - 1));
    const std::vector<Triangle> surface = boxSurface(side);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    double volume = 0.0;
    for (const Triangle& t : surface) {
      const auto& p = lattice->restPoints;
      volume += p[t[0]].dot(p[t[1]].cross(p[t[2]])) / 6.0;
      for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    }
    EXPECT_NEAR(volume, 1.0, 1e-12);  // negative if it faced inward
    EXPECT_EQ(surface.size(), 12u * static_cast<std::size_t>((side - 1) * (side - 1)));
    for (const auto& [edge, times] : edges) {
      EXPECT_EQ(times, 1);
      EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
  }
}

TEST(ContactStage, knowsTheSpeedOfWhatFalls) {
  for (const EngineChoice& engine : contactEngines()) {
    const ContactScene scene = fallingCube(10, 20);
    ContactStage stage(scene, engine);
    while (!stage.over()) stage.advance(7, 60.0);
    ASSERT_EQ(stage.error(), "") << engine.engine << " " << engine.setting;
    EXPECT_EQ(stage.points(), 8u);
    EXPECT_EQ(stage.ticks().size(), 20u);
    // during the 30th tick; engines move bodies by the mean velocity of a tick or by that at its end
    EXPECT_NEAR(stage.residualSpeed(), 29.75 * kContactTick * kGravity, 0.3 * kContactTick * kGravity)
        << engine.engine << " " << engine.setting;
    EXPECT_EQ(stage.deepestPenetration(), 0.0);
    EXPECT_EQ(stage.asleep(), 0.0);
  }
}

TEST(ContactStage, seesWhatIsInTheFloor) {
  ContactScene scene = fallingCube(0, 1);
  scene.bodies[0].settings.position.y() =
      0.4;  // the lower corners are 0.1 m below the floor, which does not exist
  ContactStage stage(scene, engineOf("loose spheres"));
  stage.advance(1, 60.0);
  // 0.02 m more for their spheres, and the fall in a tick
  EXPECT_NEAR(stage.deepestPenetration(), 0.12, kGravity * kContactTick * kContactTick + 1e-6);
}

TEST(ContactStage, givesUpWhatIsGone) {
  ContactScene scene = fallingCube(0, 200);
  ContactStage stage(scene, engineOf("loose spheres"));
  while (!stage.over()) stage.advance(10, 60.0);
  EXPECT_EQ(stage.error(), "goes through what it should lie on");
}

TEST(ContactStage, losesPatience) {
  const ContactScene scene = fallingCube(0, 10);
  ContactStage stage(scene, engineOf("LimberCollision::Points"));
  stage.advance(10, 0.0);
  EXPECT_NE(stage.error().find("given up after 1 ticks"), std::string::npos) << stage.error();
  EXPECT_TRUE(stage.over());
}

TEST(ContactScenes, haveAllRolesAndFewBodiesWhenQuick) {
  const std::vector<ContactScene> quick = allContactScenes(true);
  std::map<Role, int> roles;
  for (const ContactScene& scene : quick) {
    ++roles[scene.role];
    EXPECT_LE(scene.bodies.size(), 10u) << scene.name;
    for (const BodySetup& body : scene.bodies) EXPECT_EQ(body.maySleep, scene.sleeps()) << scene.name;
  }
  EXPECT_EQ(roles.size(), 7u);
}

TEST(SoftContacts, allHoldACubeOnAFloor) {
  for (const SoftContacts contacts : {SoftContacts::Points, SoftContacts::PointsAndFaces,
                                      SoftContacts::PointsAndClusters, SoftContacts::Clusters}) {
    ContactScene scene = fallingCube(0, 60);
    scene.bodies[0].settings.position.y() = 0.53;
    scene.bodies[0].drag = 1.0;
    scene.addRigidBodies = [](RigidBodies& rigid) { addFloor(rigid, Floor::Box, 0.5); };
    const EngineChoice choice{"btSoftBody", "", [=](const EngineUse& use) {
                                return makeSoftBodyEngine(use.dt, 10, LinkStiffness::Full, contacts);
                              }};
    ContactStage stage(scene, choice);
    stage.advance(60, 60.0);
    EXPECT_EQ(stage.error(), "");
    EXPECT_LT(stage.deepestPenetration(), 0.05) << static_cast<int>(contacts);  // Bullet's margin
  }
}

TEST(MemoryUse, countsAtLeastWhatIsThere) {
  const std::optional<MemoryUse> use = measureMemory(false);
  if (!use) GTEST_SKIP() << "the C library does not tell";
  // position, velocity, acceleration, inverse mass and two forces in double precision
  EXPECT_GT(use->perPoint, 6 * 24.0);
  // the impulses of its damper for half a substep and a whole one, in double precision; up to eight bodies
  // that are stepped together use those of the first one
  EXPECT_GT(use->perSpring, 16.0 / 8.0);
}

}  // namespace
}  // namespace limber::bench
