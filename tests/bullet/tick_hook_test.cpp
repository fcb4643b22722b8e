// SPDX-License-Identifier: Zlib
// The plugin shares Bullet's only pre-tick callback with the application.
#include "support/soft_world.h"

#include <stdexcept>

namespace limber::test {
namespace {

int preTicks = 0, postTicks = 0;
void countPreTick(btDynamicsWorld* world, btScalar) {
  ++preTicks;
  // real programs also cast their user info without a check
  if (world->getWorldUserInfo()) ++*static_cast<int*>(world->getWorldUserInfo());
}
void countPostTick(btDynamicsWorld*, btScalar) { ++postTicks; }

struct TickHookTest : testing::Test {
  TickHookTest() { preTicks = postTicks = 0; }
  BulletWorld bullet;
  int info = 0;
};

/// Adds a body one metre long that is pinned at one end. It extends only if its spring is stepped.
SoftBody* hangingPair(SoftBodySystem& system) {
  SoftBodySettings s;
  s.collisionMask = 0;
  SoftBody* body = *system.createBody(pairNetwork(), s);
  body->pin(0);
  return body;
}

TEST_F(TickHookTest, chainsAnExistingCallbackAndLeavesItsUserInfoAlone) {
  bullet.world->setInternalTickCallback(countPreTick, &info, true);
  SoftBodySystem system(*bullet.world);
  hangingPair(system);
  EXPECT_EQ(bullet.world->getWorldUserInfo(), &info);
  EXPECT_EQ(system.hookState(), HookState::Attached);
  bullet.simulate(0.5);
  EXPECT_EQ(preTicks, 30);
  EXPECT_EQ(info, 30);
}

void throwPreTick(btDynamicsWorld*, btScalar) {
  if (++preTicks == 5) throw std::runtime_error("of the user");
}

TEST_F(TickHookTest, goesOnAfterAnExceptionOfTheUsersCallback) {
  bullet.world->setInternalTickCallback(throwPreTick, nullptr, true);
  SoftBodySystem system(*bullet.world);
  const SoftBody* body = hangingPair(system);
  const Eigen::Vector3d start = body->position(1);
  int thrown = 0;
  for (int i = 0; i < 30; ++i) {
    try {
      bullet.tick();
    } catch (const std::runtime_error&) {
      ++thrown;
      EXPECT_LT((body->position(1) - start).norm(), 0.1);
    }
  }
  EXPECT_EQ(thrown, 1);
  EXPECT_EQ(preTicks, 30);
  EXPECT_GT((body->position(1) - start).norm(), 0.2);
}

TEST_F(TickHookTest, leavesThePostTickSlotToTheUser) {
  SoftBodySystem system(*bullet.world);
  SoftBody* body = hangingPair(system);
  // setting the post-tick callback overwrites the user info, which both callbacks share in Bullet
  bullet.world->setInternalTickCallback(countPostTick, &info, false);
  bullet.simulate(0.5);
  EXPECT_EQ(postTicks, 30);
  EXPECT_EQ(system.hookState(), HookState::Attached);
  EXPECT_GT(body->substeps(), 0);
}

TEST_F(TickHookTest, isIdleUntilThereIsSomethingToStep) {
  SoftBodySystem system(*bullet.world);
  EXPECT_EQ(system.hookState(), HookState::Idle);
  SoftBody* body = hangingPair(system);
  EXPECT_EQ(system.hookState(), HookState::Attached);
  system.destroyBody(body);
  EXPECT_EQ(system.hookState(), HookState::Idle);
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 0);
}

TEST_F(TickHookTest, givesTheSlotBack) {
  bullet.world->setInternalTickCallback(countPreTick, &info, true);
  {
    SoftBodySystem system(*bullet.world);
    hangingPair(system);
    bullet.tick();
  }
  EXPECT_EQ(preTicks, 1);
  bullet.tick();
  EXPECT_EQ(preTicks, 2) << "the user's callback is called, once";
  EXPECT_EQ(bullet.world->getWorldUserInfo(), &info);
}

TEST_F(TickHookTest, tellsWhenItWasOverwrittenAndCanComeBack) {
  SoftBodySystem system(*bullet.world);
  std::vector<std::string> warnings;
  system.onWarning([&](const std::string& text) { warnings.push_back(text); });
  SoftBody* body = hangingPair(system);
  bullet.tick();
  bullet.world->setInternalTickCallback(countPreTick, nullptr, true);
  bullet.simulate(0.1);
  EXPECT_EQ(system.hookState(), HookState::Overwritten);
  ASSERT_EQ(warnings.size(), 1u) << "said once";
  EXPECT_NE(warnings[0].find("rehook"), std::string::npos);

  system.rehook();
  EXPECT_EQ(system.hookState(), HookState::Attached);
  const int before = preTicks;
  body->wake();
  bullet.simulate(0.1);
  EXPECT_EQ(preTicks, before + 6) << "who took the slot is now called first";
  EXPECT_EQ(warnings.size(), 1u);
}

TEST_F(TickHookTest, twoSystemsShareAWorld) {
  auto first = std::make_unique<SoftBodySystem>(*bullet.world);
  SoftBodySystem second(*bullet.world);
  SoftBody* a = hangingPair(*first);
  SoftBody* b = hangingPair(second);
  bullet.simulate(0.3);
  EXPECT_GT(a->substeps(), 0);
  EXPECT_EQ(a->stateHash(), b->stateHash()) << "both are stepped, alike";
  first.reset();
  bullet.simulate(0.3);
  EXPECT_EQ(second.hookState(), HookState::Attached);
  EXPECT_GT(b->substeps(), 0);
}

TEST_F(TickHookTest, attachedTwiceByOneProgramIsStillSteppedOnce) {
  // two systems, or rehook() called twice: the callback is never chained to itself
  SoftBodySystem system(*bullet.world);
  SoftBody* body = hangingPair(system);
  system.rehook();
  system.rehook();
  SoftBodySystem other(*bullet.world);
  other.rehook();
  bullet.tick();
  BulletWorld alone;
  SoftBodySystem aloneSystem(*alone.world);
  SoftBody* same = hangingPair(aloneSystem);
  alone.tick();
  EXPECT_EQ(body->stateHash(), same->stateHash());
}

TEST_F(TickHookTest, aCallbackThatCallsUsOnDoesNotLoop) {
  SoftBodySystem system(*bullet.world);
  hangingPair(system);
  struct Peek : btDynamicsWorld {
    static btInternalTickCallback of(const btDynamicsWorld& w) {
      return w.*(&Peek::m_internalPreTickCallback);
    }
  };
  static btInternalTickCallback ours;
  ours = Peek::of(*bullet.world);
  bullet.world->setInternalTickCallback(
      [](btDynamicsWorld* w, btScalar h) {
        ++preTicks;
        ours(w, h);
      },
      nullptr, true);
  bullet.tick();
  system.rehook();
  bullet.tick();
  EXPECT_EQ(preTicks, 2);
}

SoftBodySystem* manualSystem = nullptr;

TEST_F(TickHookTest, whoOwnsTheSlotStepsByHand) {
  SoftBodySystem system(*bullet.world, SoftBodySystem::Hook::Manual);
  manualSystem = &system;
  bullet.world->setInternalTickCallback([](btDynamicsWorld*, btScalar h) { manualSystem->beforeTick(h); },
                                        &info, true);
  SoftBody* body = hangingPair(system);
  BulletWorld other;
  SoftBodySystem automatic(*other.world);
  SoftBody* same = hangingPair(automatic);
  bullet.simulate(0.5);
  other.simulate(0.5);
  EXPECT_EQ(system.hookState(), HookState::Attached);
  EXPECT_EQ(body->stateHash(), same->stateHash());
}

}  // namespace
}  // namespace limber::test
