// SPDX-License-Identifier: Zlib
// Worlds full of bodies in air, water and fields: threads, lanes, memory.
#include "support/allocation_counter.h"
#include "support/soft_world.h"

#include <cmath>

namespace limber::test {
namespace {

using Eigen::Vector3d;

SoftBodySettings settingsInAir() {
  SoftBodySettings s = testedSettings();
  s.flow = FlowCoefficients();
  return s;
}

/// A world with every kind of body, in gusts, water and a field.
struct BusyWorld {
  BusyWorld() {
    Air air;
    air.wind = {4, 0, 1};
    air.windAt = gusts(air.wind, 3.0, 1.0);
    EXPECT_TRUE(system.setAir(air));
    EXPECT_TRUE(system.setWater(Water()));
    EXPECT_TRUE(system.addField([](const FieldPoints& p) {
      for (std::size_t i = 0; i < 3 * p.count; ++i) p.accelerations[i] -= 0.3 * p.velocities[i];
    }));
    const SharedNetwork rope = *buildRope(), cloth = *buildCloth(), cube = closedCubeNetwork();
    SoftBodySettings s = settingsInAir();
    s.flow.displacedVolume = 1e-3;
    for (int i = 0; i < 12; ++i) {
      s.position = {1.5 * i, 0.5, -2.0};
      s.totalMass = 0.3;
      EXPECT_TRUE(system.createBody(rope, s));
      if (i % 4 == 0) (*system.createBody(cloth, placed(s, 2.0)))->pin(0);
      s.totalMass = 300.0;
      s.extensionStiffness = s.compressionStiffness = 1e5;
      EXPECT_TRUE(system.createBody(cube, placed(s, 5.0)));
      s = settingsInAir();
    }
  }
  static SoftBodySettings placed(SoftBodySettings s, double z) {
    s.position.z() = z;
    return s;
  }
  std::uint64_t hash() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < system.bodyCount(); ++i) sum = 31 * sum + system.body(i)->stateHash();
    return sum;
  }

  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};
};

TEST(BusySurroundings, givesTheSameBitsOnAnyNumberOfThreads) {
  BusyWorld alone, together;
  ThreadPool pool(2);
  together.system.setParallelFor(pool.parallelFor(), 0);
  for (int i = 0; i < 120; ++i) {
    alone.bullet.tick();
    together.bullet.tick();
    ASSERT_EQ(alone.hash(), together.hash()) << i;
  }
}

TEST(BusySurroundings, allocatesNothingAfterWarmUp) {
  BusyWorld busy;
  busy.bullet.simulate(5.0);
  EXPECT_EQ(allocationsIn([&] { busy.bullet.simulate(1.0); }), 0u);
}

TEST(BusySurroundings, bodiesStepTheSameAloneAndInLanes) {
  const auto run = [](int count) {
    SoftWorld bullet;
    Air air;
    air.windAt = [](const Vector3d& place, double time) {
      return Vector3d(3.0 * std::sin(place.z() + time), 2.0 * std::cos(time), 0);
    };
    EXPECT_TRUE(bullet.system.setAir(air));
    const SharedNetwork rope = *buildRope();
    for (int i = 0; i < count; ++i) {
      SoftBodySettings s = settingsInAir();
      s.totalMass = 0.05;
      s.position = {0, 0, 3.0 * i};
      EXPECT_TRUE(bullet.addSoft(rope, s)->pin(0));
    }
    bullet.simulate(2.0);
    return bullet.system.body(0)->stateHash();
  };
  EXPECT_EQ(run(1), run(9));
}

}  // namespace
}  // namespace limber::test
