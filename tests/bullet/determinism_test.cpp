// SPDX-License-Identifier: Zlib
// The same build and input give the same bits in every tick.
#include "support/networks.h"
#include "support/soft_world.h"
#include "support/tested_way.h"

#include <limber/soft_body_system.h>

#include <gtest/gtest.h>

#include <cinttypes>

namespace limber {
namespace {

using test::BulletWorld;
using test::SoftWorld;

/// Six cubes tumbling onto a box floor, two of them joined by a spring, one dragging a rigid box.
struct Tumble {
  BulletWorld bullet;
  std::unique_ptr<SoftBodySystem> system;

  Tumble() {
    bullet.addBoxFloor();
    system = std::make_unique<SoftBodySystem>(*bullet.world);
    for (int i = 0; i < 6; ++i) {
      SoftBodySettings s = test::settingsAt({1.3 * i, 1.5 + 0.3 * i, 0.2 * i});
      s.rotation = Eigen::Quaterniond(0.5, 0.5, i % 2 ? 0.5 : -0.5, 0.5);
      s.angularVelocity = {1.0 * i, 0.5, -1.0};
      (void)*system->createBody(test::cubeNetwork(), s);
    }
    btRigidBody* box = bullet.addBox(test::vec(0.3, 0.3, 0.3), 0.5, test::vec(2.6, 4, 0));
    (void)*system->addSpring({system->body(0)->point(1)}, {system->body(1)->point(2)});
    (void)system->attach(system->body(2), 3, *box);
  }

  std::uint64_t hash() const {
    std::uint64_t h = 0;
    for (std::size_t i = 0; i < system->bodyCount(); ++i) h = h * 31 + system->body(i)->stateHash();
    return h;
  }
};

TEST(Determinism, twoWorldsAgreeBitForBitEveryTick) {
  Tumble a, b;
  for (int i = 0; i < 300; ++i) {
    a.bullet.tick();
    b.bullet.tick();
    ASSERT_EQ(a.hash(), b.hash()) << "tick " << i;
  }
}

TEST(Determinism, springsAloneGiveTheGoldenHash) {
  // Without contacts only the plugin's arithmetic and Bullet's transfer of velocities take part. The bits are
  // therefore the same on every x86-64 machine and in every build type. A change of the hash is a change of
  // the physics and needs an explanation.
  SoftWorld bullet;
  SoftBodySettings s = test::testedSettings();
  s.rotation = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5);
  s.angularVelocity = {1.0, 0.5, -1.0};
  SoftBody* body = bullet.addSoft(test::cubeNetwork(), s);
  body->pin(3);
  bullet.simulate(5.0);
#ifdef BT_USE_DOUBLE_PRECISION
  const std::uint64_t golden = 0x623feb9d3aaba068;
#else
  const std::uint64_t golden = 0xdf3a2497735f2b1e;
#endif
  EXPECT_EQ(body->stateHash(), golden) << "new hash: 0x" << std::hex << body->stateHash();
}

}  // namespace
}  // namespace limber
