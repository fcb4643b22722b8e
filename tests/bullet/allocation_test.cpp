// SPDX-License-Identifier: Zlib
// A tick allocates no memory after a warm-up.
#include "support/allocation_counter.h"
#include "support/networks.h"
#include "support/soft_world.h"
#include "support/tested_way.h"

#include <limber/soft_body_system.h>

#include <gtest/gtest.h>

namespace limber {
namespace {

using test::SoftWorld;

TEST(Allocation, aTickAllocatesNothingAfterWarmUp) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  const SharedNetwork open = test::cubeNetwork(), closed = test::closedCubeNetwork();
  for (int i = 0; i < 12; ++i) {
    SoftBody* body = bullet.addSoft(i < 8 ? open : closed, test::settingsAt({1.5 * i, 1.0, 0}));
    body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  }
  btRigidBody* box = bullet.addBox(test::vec(0.2, 0.2, 0.2), 1, test::vec(0, 3, 0));
  ASSERT_TRUE(bullet.system.addSpring({bullet.system.body(0)->point(0)}, {bullet.system.body(1)->point(0)}));
  ASSERT_TRUE(bullet.system.attach(bullet.system.body(2), 1, *box));
  bullet.simulate(8.0);  // the box rolls for some seconds; its largest number of contacts still grows
  const test::AllocationCounter counter;
  bullet.simulate(1.0);
  EXPECT_EQ(counter.allocations(), 0u);
}

TEST(Allocation, theCounterCounts) {
  const test::AllocationCounter counter;
  const auto made = std::make_unique<int>(1);
  EXPECT_GE(counter.allocations(), 1u);
  EXPECT_EQ(*made, 1);
}

}  // namespace
}  // namespace limber
