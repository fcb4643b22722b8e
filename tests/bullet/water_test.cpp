// SPDX-License-Identifier: Zlib
// Bodies in water against closed forms: draught, buoyancy, energy, streams.
#include "support/small_meshes.h"
#include "support/soft_world.h"
#include "support/surroundings.h"
#include "support/variants.h"

#include <cmath>

namespace limber::test {
namespace {

using Eigen::Vector3d;

struct WaterTest : SurroundingsTest {};

// flat boxes: a floating cube of half the density of water lies on an edge
TEST_F(WaterTest, aBoxFloatsAtItsDraught) {
  setWater(3.0);
  for (const double density : {250.0, 500.0, 900.0}) {
    SoftBodySettings s = stiffSolid(0.4 * density);
    s.scale = {1.0, 0.4, 1.0};
    s.position = {0, 3.1, 0};
    s.sleepingSpeed = 0.01;
    SoftBody* cube = add(bracedNetwork(small_meshes::cube(2)), s);
    bullet.simulate(30.0);
    EXPECT_NEAR(heightOf(*cube), 3.0 + 0.2 - 0.4 * density / 1000.0, 0.004) << density;
    EXPECT_TRUE(cube->sleeping());
    ASSERT_TRUE(system.destroyBody(cube));
  }
}

/// Tetrahedra fill a body and leave its surface to the water.
TEST_F(WaterTest, aBoxOfTetrahedraFloatsAtItsDraught) {
  setWater(0.0);
  const SharedNetwork block = solidNetwork(small_meshes::cube(), 40);
  SoftBodySettings s = usualSettings();
  s.position = {0, 0.1, 0};
  s = *withMaterial(*block, Material{1e6, 0.3, 250.0, 0.003}, s);
  const SoftBody* body = add(block, s);
  bullet.simulate(20.0);
  // a cube of this density floats on an edge: a triangle of a quarter of its section is under water
  EXPECT_NEAR(heightOf(*body), std::sqrt(0.5) - 0.5, 0.01);
}

TEST_F(WaterTest, itBobsWithItsPeriodAndKeepsTheEnergy) {
  setWater(0.0);
  SoftBodySettings s = stiffSolid(200.0);
  s.scale = {1.0, 0.4, 1.0};
  s.flow.drag = s.flow.linearDrag = 0.0;
  s.sleepingSpeed = 0.0;
  s.position = {0, 0.1, 0};
  const SoftBody* cube = add(bracedNetwork(small_meshes::cube(2)), s);
  double before = heightOf(*cube), first = 0.0, last = 0.0, highest = 0.0;
  int periods = -1;
  for (int i = 1; i <= 1800; ++i) {
    bullet.tick();
    const double now = heightOf(*cube), t = i / 60.0;
    if (before < 0.0 && now >= 0.0) {
      last = t - now / (now - before) / 60.0;
      if (++periods == 0) first = last;
    }
    if (i > 1500) highest = std::max(highest, now);
    before = now;
  }
  EXPECT_NEAR((last - first) / periods, 2.0 * kPi * std::sqrt(0.2 / kGravity), 0.01);
  EXPECT_NEAR(highest, 0.1, 0.01);
}

/// The mass is that of the points, not that of the settings.
TEST_F(WaterTest, itBobsAlikeWithMassesOfTheUsers) {
  setWater(0.0);
  double heights[2][60];
  for (const bool own : {false, true}) {
    SoftBodySettings s = stiffSolid(500.0);
    if (own) s.totalMass = 1.0;
    s.flow.drag = s.flow.linearDrag = 0.0;
    s.position = {5.0 * own, 1.0, 0};
    SoftBody* cube = add(bracedNetwork(small_meshes::cube(1)), s);
    if (own)
      for (std::uint32_t i = 0; i < cube->pointCount(); ++i)
        cube->point(i)->setMassProps(btScalar(500.0 / cube->pointCount()), btVector3(0, 0, 0));
    for (double& height : heights[own]) bullet.tick(), bullet.tick(), height = heightOf(*cube);
  }
  for (int i = 0; i < 60; ++i) EXPECT_NEAR(heights[0][i], heights[1][i], 0.01) << i;
}

TEST_F(WaterTest, buoyancyIsTheWeightOfTheDisplacedWater) {
  setWater(100.0);
  for (const double mirror : {1.0, -1.0}) {
    SoftBodySettings s = stiffSolid(700.0);
    s.scale = {mirror, 1.3, 0.7};
    s.rotation = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized());
    s.flow.drag = s.flow.linearDrag = 0.0;
    SoftBody* box = add(bracedNetwork(small_meshes::cube(3)), s);
    bullet.tick();
    const double expected = (1000.0 * 1.3 * 0.7 / 700.0 - 1.0) * kGravity / 60.0;
    EXPECT_NEAR(-fallOf(*box), expected, 1e-4 * std::abs(expected)) << mirror;
    EXPECT_NEAR(box->linearMomentum().x(), 0.0, 1e-2);
    ASSERT_TRUE(system.destroyBody(box));
  }
}

TEST_F(WaterTest, lightFoamAndRopesFloatInLongTicks) {
  setWater(0.0);
  SoftBodySettings s = stiffSolid(2.0);
  s.scale = {1.0, 0.1, 1.0};
  s.position = {0, 0.3, 0};
  const SoftBody* raft = add(bracedNetwork(small_meshes::cube(3)), s);
  SoftBodySettings thin = usualSettings();
  thin.position = {3, 0.2, 0};
  thin.totalMass = 0.2;
  thin.flow.displacedVolume = 0.4e-3;
  const SoftBody* rope = add(*buildRope(), thin);
  for (int i = 0; i < 600; ++i) {
    bullet.tick(1.0 / 15.0);
    ASSERT_LT(std::abs(heightOf(*raft)), 1.0) << i;
    ASSERT_LT(std::abs(heightOf(*rope)), 0.5) << i;
  }
  EXPECT_NEAR(heightOf(*raft), 0.048, 0.005);
  EXPECT_NEAR(heightOf(*rope), 0.0, 0.02);
}

// The water's spring is up to a thousand times as stiff as such a body resolves in a tick.
TEST_F(WaterTest, lightSolidsComeToRestOnWater) {
  setWater(0.0);
  const SharedNetwork cube = bracedNetwork(small_meshes::cube(2)),
                      ball = bracedNetwork(small_meshes::icosphere(2));
  for (const double tick : {1.0 / 120.0, 1.0 / 60.0, 1.0 / 30.0})
    for (const double mass : {0.3, 1.0, 3.0, 10.0, 30.0}) {
      SoftBodySettings s = usualSettings();
      s.totalMass = mass;
      s.position = {0, 0.7, 0};
      SoftBody* floating = add(cube, s);
      s.scale.setConstant(0.5);
      s.position = {4, 0.7, 0};
      SoftBody* rolling = add(ball, s);
      for (int i = 0; i * tick < 30.0; ++i) bullet.tick(tick);
      for (SoftBody* body : {floating, rolling}) {
        EXPECT_TRUE(body->sleeping()) << mass << " kg, tick " << tick;
        EXPECT_LT(body->kineticEnergy(), 1e-12) << mass << " kg, tick " << tick;
      }
      // heavier cubes of this stiffness are pressed in by their weight
      if (mass < 10.0) {
        EXPECT_NEAR(heightOf(*floating), 0.5 - mass / 1000.0, 0.005) << mass << " kg, tick " << tick;
      }
      ASSERT_TRUE(system.destroyBody(floating));
      ASSERT_TRUE(system.destroyBody(rolling));
    }
}

TEST_F(WaterTest, undampedLightSolidsGainNoEnergyOnWater) {
  setWater(0.0);
  for (const double mass : variants({1.0, 10.0, 100.0}, {3.0, 30.0})) {
    SoftBodySettings s = stiffSolid(mass);
    const double draught = mass / 1000.0, rise = 0.1 * draught;
    s.flow.drag = s.flow.linearDrag = 0.0;
    s.sleepingSpeed = 0.0;
    s.position = {0, 0.5 - draught + rise, 0};
    SoftBody* cube = add(bracedNetwork(small_meshes::cube(2)), s);
    for (int i = 0; i < 3000; ++i) {
      bullet.tick();
      const double up = heightOf(*cube) - (0.5 - draught), speed = fallOf(*cube);
      // of a plane of 1 m^2. The scheme conserves v^2/2 (1 - p/4) + w^2 x^2/2, where the square p of the
      // phase is at most 1/2 for a body on which water acts locally: 1.14. The pressure also stretches the
      // body
      ASSERT_LT(0.5 * mass * speed * speed + 0.5 * 1000.0 * kGravity * up * up,
                1.25 * 0.5 * 1000.0 * kGravity * rise * rise)
          << mass << " kg, tick " << i;
    }
    ASSERT_TRUE(system.destroyBody(cube));
  }
}

// The inertia of the water must not be missing in its force: bodies that are held or loaded kept 9 % of it.
TEST_F(WaterTest, lightSolidsUnderWaterPullWithTheirBuoyancy) {
  setWater(10.0);
  for (const double tick : {1.0 / 240.0, 1.0 / 60.0, 1.0 / 30.0})
    for (const double size : {0.05, 0.3})
      for (const double density : {10.0, 50.0, 300.0}) {
        const double volume = size * size * size, mass = density * volume;
        SoftBodySettings s = stiffSolid(mass);
        s.scale.setConstant(size);
        s.extensionStiffness = s.compressionStiffness = 2e6 * size * size;
        s.damping *= 5.0;
        SoftBody* cube = add(bracedNetwork(small_meshes::cube(2)), s);
        SpringSettings rope;
        rope.stiffness = 1e5 * volume;
        rope.damping = 20.0 * mass;
        const Result<SpringConstraint*> tether =
            system.addSpring({cube->point(0)}, {nullptr, btVector3(0, -1, 0)}, rope);
        ASSERT_TRUE(tether) << tether.error();
        for (int i = 0; i * tick < 10.0; ++i) bullet.tick(tick);
        EXPECT_NEAR((*tether)->force() / ((1000.0 - density) * volume * kGravity), 1.0, 0.01)
            << size << " m, " << density << " kg/m^3, tick " << tick;
        ASSERT_TRUE(system.destroyBody(cube));
      }
}

TEST_F(WaterTest, lightRaftsFloatAtTheDraughtOfTheirLoad) {
  setWater(0.0);
  for (const double tick : {1.0 / 120.0, 1.0 / 60.0, 1.0 / 30.0})
    for (const double size : {0.1, 1.0})
      for (const double density : {20.0, 100.0, 300.0}) {
        const double height = 0.4 * size, area = size * size, mass = density * area * height;
        SoftBodySettings s = stiffSolid(mass);
        s.extensionStiffness = s.compressionStiffness = 1e6 * height * size;
        s.scale = {size, height, size};
        SoftBody* raft = add(bracedNetwork(small_meshes::cube(2)), s);
        const double load = 0.5 * (1000.0 * area * height - mass);
        for (int i = 0; i * tick < 8.0; ++i) {
          ASSERT_TRUE(raft->applyForce(btVector3(0, btScalar(-load * kGravity), 0)));
          bullet.tick(tick);
        }
        EXPECT_NEAR((0.5 * height - heightOf(*raft)) / height, (mass + load) / (1000.0 * area * height), 0.02)
            << size << " m, " << density << " kg/m^3, tick " << tick;
        ASSERT_TRUE(system.destroyBody(raft));
      }
}

TEST_F(WaterTest, aSavedRaftUnderALoadContinuesAlike) {
  setWater(0.0);
  SoftBodySettings s = stiffSolid(0.008);
  s.scale = {0.1, 0.04, 0.1};
  SoftBody* raft = add(bracedNetwork(small_meshes::cube(2)), s);
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      EXPECT_TRUE(raft->applyForce(btVector3(0, i % 2 ? -2 : -1, 0)));
      bullet.tick(1.0 / 30.0);
    }
    return raft->stateHash();
  };
  run(11);
  const auto saved = system.saveState();
  const std::uint64_t hash = run(7);
  ASSERT_TRUE(system.restoreState(saved));
  EXPECT_EQ(run(7), hash);
}

// Dampers of the body with the water's mass are far too strong for the body alone.
TEST_F(WaterTest, aDampedLightSolidLeapsOutOfTheWaterInItsShape) {
  setWater(0.0);
  for (const double tick : {1.0 / 60.0, 1.0 / 30.0}) {
    const double mass = 0.1;
    SoftBodySettings s = stiffSolid(mass);
    s.damping = 500.0 * mass;
    s.scale.setConstant(0.3);
    s.position = {0, -1.5, 0};
    SoftBody* cube = add(bracedNetwork(small_meshes::cube(2)), s);
    const double rest = 0.027;
    for (int i = 0; i * tick < 3.0; ++i) {
      bullet.tick(tick);
      ASSERT_NEAR(volumeOf(*cube) / rest, 1.0, 0.2) << "tick " << tick << ", " << i;
      ASSERT_LT(std::abs(fallOf(*cube)), 15.0) << "tick " << tick << ", " << i;
      ASSERT_EQ(cube->restorations(), 0u);
    }
    ASSERT_TRUE(system.destroyBody(cube));
  }
}

/// A stiff ball of a 270th of the water's density.
SoftBodySettings lightBall() {
  SoftBodySettings s = usualSettings();
  s.extensionStiffness = s.compressionStiffness = 1e4;
  s.scale.setConstant(0.4);
  s.position = {0, -1.2, 0};
  return s;
}

// The bounds of the frequency with the water's mass do not hold for the body alone.
TEST_F(WaterTest, aLightStiffBallRisesAndFloatsCalmly) {
  for (const double tick : {1.0 / 60.0, 1.0 / 30.0}) {
    setWater(0.0);
    const SharedNetwork network = bracedNetwork(small_meshes::icosphere(1));
    SoftBody* ball = add(network, lightBall());
    for (int i = 0; i * tick < 4.0; ++i) {
      bullet.tick(tick);
      ASSERT_LT(ball->elasticEnergy(), 10.0) << "tick " << tick << ", " << i;
      ASSERT_LT(std::abs(fallOf(*ball)), 5.0) << "tick " << tick << ", " << i;
    }
    EXPECT_LT(ball->kineticEnergy(), 1e-3) << "tick " << tick;
    ASSERT_TRUE(system.destroyBody(ball));
  }
}

// A tick takes them from above the water to far below it.
TEST_F(WaterTest, bodiesOfMillimetresComeToRestAtLongTicks) {
  constexpr double kSize = 0.005, kTick = 1.0 / 15.0;
  for (const double density : {30.0, 300.0, 900.0}) {
    setWater(0.0);
    SoftBodySettings s = usualSettings();
    s.scale = Vector3d::Constant(0.5 * kSize);
    s.position = {0, 1.5 * kSize, 0};
    s.totalMass = density * 0.42 * std::pow(kSize, 3);
    setSprings(s, 5.0, 1e-3);
    SoftBody* ball = add(bracedNetwork(small_meshes::icosphere(1)), s);
    for (int i = 0; i < 300; ++i) {
      bullet.tick(kTick);
      ASSERT_LT(heightOf(*ball), 2.0 * kSize) << density << ", tick " << i;
    }
    EXPECT_NEAR(heightOf(*ball), 0.0, kSize) << density;
    EXPECT_LT(std::abs(fallOf(*ball)), 0.02) << density;
    ASSERT_TRUE(system.destroyBody(ball));
  }
}

TEST_F(WaterTest, aLightStiffBallFallsInItsShapeWhenTheWaterIsDrained) {
  setWater(0.0);
  SoftBody* ball = add(bracedNetwork(small_meshes::icosphere(1)), lightBall());
  for (int i = 0; i < 20; ++i) bullet.tick();
  ASSERT_TRUE(system.setWater(std::nullopt));
  const double energy = ball->elasticEnergy() + ball->kineticEnergy();
  for (int i = 0; i < 20; ++i) {
    bullet.tick();
    ASSERT_LT(ball->elasticEnergy(), energy + 1.0) << i;
  }
}

// Springs far weaker than the water's pressure: it would turn the ball inside out.
TEST_F(WaterTest, verySoftBodiesFloatInTheirShape) {
  setWater(0.0);
  const SharedNetwork ball = bracedNetwork(small_meshes::icosphere(1));
  for (const double tick : {1.0 / 240.0, 1.0 / 60.0, 1.0 / 30.0})
    for (const double stiffness : {30.0, 300.0, 1000.0}) {
      SoftBodySettings s = usualSettings();
      s.extensionStiffness = s.compressionStiffness = stiffness;
      s.totalMass = 100.0;
      s.scale.setConstant(0.5);
      SoftBody* floating = add(ball, s);
      const double rest = volumeOf(*floating);
      for (int i = 0; i * tick < 20.0; ++i) {
        bullet.tick(tick);
        ASSERT_LT(2.0 * floating->kineticEnergy() / s.totalMass, 2.0) << stiffness << " N/m, tick " << tick;
        ASSERT_NEAR(volumeOf(*floating) / rest, 1.0, 0.2) << stiffness << " N/m, tick " << tick;
      }
      EXPECT_LT(floating->kineticEnergy(), 1e-3) << stiffness << " N/m, tick " << tick;
      ASSERT_TRUE(system.destroyBody(floating));
    }
}

// The energy of the water's forces belongs to a rigid shape, which this body only follows.
TEST_F(WaterTest, undampedVerySoftBodiesGainNoEnergyOnWater) {
  setWater(0.0);
  const double mass = 300.0, draught = 0.3, rise = 0.03;
  SoftBodySettings s = usualSettings();
  setSprings(s, 100.0, 0.0);
  s.flow.drag = s.flow.linearDrag = 0.0;
  s.totalMass = mass;
  s.sleepingSpeed = 0.0;
  s.position = {0, 0.5 - draught + rise, 0};
  SoftBody* cube = add(bracedNetwork(small_meshes::cube(2)), s);
  for (int i = 0; i < 3000; ++i) {
    bullet.tick();
    const double up = heightOf(*cube) - (0.5 - draught);
    ASSERT_LT(cube->kineticEnergy() + cube->elasticEnergy() + 0.5 * 1000.0 * kGravity * up * up,
              1.2 * 0.5 * 1000.0 * kGravity * rise * rise)
        << i;
  }
}

TEST_F(WaterTest, lightSolidsRiseAlikeAtAnyTick) {
  setWater(10.0);
  for (const double mass : {1.0, 5.0, 20.0})
    for (const double tick : {1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0, 1.0 / 480.0}) {
      SoftBodySettings s = stiffSolid(mass);
      s.flow.drag = s.flow.linearDrag = 0.0;
      SoftBody* cube = add(bracedNetwork(small_meshes::cube(2)), s);
      const int ticks = static_cast<int>(std::lround(0.1 / tick));
      for (int i = 0; i < ticks; ++i) bullet.tick(tick);
      // half the displaced mass of 1000 kg moves with it; the pressure compresses the body by 3 %
      const double expected = 0.1 * kGravity * (1000.0 - mass) / (500.0 + mass);
      EXPECT_NEAR(-fallOf(*cube), expected, 0.05 * expected) << mass << " kg, tick " << tick;
      ASSERT_TRUE(system.destroyBody(cube));
    }
}

TEST_F(WaterTest, lightSoftBodiesDeepUnderWaterAreNotCrushed) {
  setWater(20.0);
  SoftBodySettings s = usualSettings();
  s.totalMass = 2.0;
  s.damping = 0.0;
  const SoftBody* cube = add(bracedNetwork(small_meshes::cube(2)), s);
  for (int i = 0; i < 90; ++i) {
    bullet.tick(1.0 / 30.0);
    // the weight of a cubic metre of water against the drag of its face
    const double steady = i > 10 ? -fallOf(*cube) : std::sqrt(2.0 * kGravity);
    ASSERT_NEAR(steady, std::sqrt(2.0 * kGravity), 0.5) << i;
    Eigen::AlignedBox3d box;
    for (std::uint32_t p = 0; p < cube->pointCount(); ++p) box.extend(cube->position(p));
    ASSERT_GT(box.sizes().minCoeff(), 0.5) << i;
  }
}

TEST_F(WaterTest, aStreamCarriesAFloatingCube) {
  Water water;
  water.flow = {0.8, 0, 0};
  ASSERT_TRUE(system.setWater(water));
  const SoftBody* cube = add(bracedNetwork(small_meshes::cube(2)), stiffSolid(100.0));
  bullet.simulate(60.0);
  EXPECT_NEAR(cube->linearMomentum().x() / 100.0, 0.8, 0.1);
}

}  // namespace
}  // namespace limber::test
