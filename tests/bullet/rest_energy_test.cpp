// SPDX-License-Identifier: Zlib
// A body at rest stays at rest: for a minute, on every kind of floor, soft or stiff.
#include "support/soft_world.h"

#include <cmath>

namespace limber::test {
namespace {

void expectLastingRest(BulletWorld& bullet, double stiffness) {
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = settingsAt({0.1, 0.8, 0.05});
  setSprings(s, stiffness, 0.1 * 2.0 * std::sqrt(stiffness * 0.125));
  s.sleepingSpeed = 0.0;
  SoftBody* body = *system.createBody(fullCubeNetwork(), s);
  const double radius = pointRadius(body->network(), s);
  const auto energy = [&] {
    return body->kineticEnergy() + body->elasticEnergy() + kGravity * body->centerOfMass().y();
  };
  bullet.simulate(15.0);
  const double start = energy();
  for (int tick = 0; tick < 3600; ++tick) {
    bullet.tick();
    // rounding of a sum of some fifty terms of a joule
    ASSERT_LE(energy(), start + 1e-13) << "k " << stiffness << ", tick " << tick;
    for (std::uint32_t i = 0; i < body->pointCount(); ++i)
      ASSERT_GT(body->position(i).y(), 0.99 * radius) << "k " << stiffness << ", point " << i;
  }
}

TEST(Rest, energyNeverRisesForAMinuteAndNoPointSinks) {
  void (*const floors[])(BulletWorld&) = {
      [](BulletWorld& b) { b.addPlaneFloor(); }, [](BulletWorld& b) { b.addBoxFloor(); },
      [](BulletWorld& b) { b.addHullFloor(); }, [](BulletWorld& b) { b.addTriangleFloor(); }};
  for (const auto addFloor : floors)
    for (const double stiffness : {1e3, 1e6}) {
      BulletWorld bullet(-kGravity);
      addFloor(bullet);
      expectLastingRest(bullet, stiffness);
    }
}

}  // namespace
}  // namespace limber::test
