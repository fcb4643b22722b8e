// SPDX-License-Identifier: Zlib
// Contacts that begin, persist and end.
#include "support/soft_world.h"

#include <functional>
#include <string>
#include <vector>

namespace limber::test {
namespace {

/// Records the calls as letters: b(egins), p(ersists) and e(nds).
struct CallRecorder : ContactListener {
  std::string calls;
  std::vector<ContactPair> pairs;
  std::function<void(const ContactPair&)> onBegin;

  void note(char kind, const ContactPair& pair) {
    calls += kind;
    pairs.push_back(pair);
  }
  void contactBegins(const ContactPair& pair) override {
    note('b', pair);
    if (onBegin) onBegin(pair);
  }
  void contactPersists(const ContactPair& pair) override { note('p', pair); }
  void contactEnds(const ContactPair& pair) override { note('e', pair); }
};

SoftBody* addLightlyDampedCube(SoftBodySystem& system, double height, double x = 0.0) {
  SoftBodySettings s = settingsAt({x, height, 0});
  setSprings(s, 2000, 2);
  s.pointRadius = kRadius;
  return *system.createBody(closedCubeNetwork(), s);
}

/// A cloth falls on two balls. Points near both have contacts that follow the two surfaces.
TEST(ContactReport, hasNoContactsOfPointsThatHaveNotTouched) {
  for (const double level : {-10.0, 0.0, 10.0}) {
    SoftWorld bullet;
    for (const double x : {-0.4, 0.4}) bullet.add(std::make_unique<btSphereShape>(0.5f), 0, vec(x, level, 0));
    SoftBodySettings s = settingsAt({0, level + 0.55, 0});
    s.pointRadius = kRadius;
    SoftBody* cloth = bullet.addSoft(*buildCloth({}), s);
    for (int i = 0; i < 60; ++i) {
      bullet.tick();
      for (const SoftContact& c : cloth->contacts())
        ASSERT_GT(c.distance, -kRadius) << level << ", tick " << i;
    }
    EXPECT_GT(cloth->contacts().size(), 0u);
  }
}

TEST(ContactListener, tellsOfACubeThatFallsBouncesRestsAndIsLifted) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addBoxFloor();
  CallRecorder recorder;
  bullet.system.setContactListener(&recorder);
  SoftBody* cube = addLightlyDampedCube(bullet.system, 1.5);
  cube->point(0)->setActivationState(DISABLE_DEACTIVATION);
  bool touched = false;
  std::string expected;
  for (int i = 0; i < 900; ++i) {
    if (i == 600) bullet.world->setGravity(vec(0, 9.81, 0));
    bullet.tick();
    const bool touches = !cube->contacts().empty();
    if (touches || touched) expected += touches ? touched ? 'p' : 'b' : 'e';
    touched = touches;
  }
  EXPECT_EQ(recorder.calls, expected);
  EXPECT_EQ(expected.front(), 'b');
  EXPECT_EQ(expected.back(), 'e');
  EXPECT_NE(expected.find("eb"), std::string::npos) << "it does not bounce";
  EXPECT_NE(expected.find(std::string(200, 'p')), std::string::npos) << "it does not rest";
  for (const ContactPair& pair : recorder.pairs) {
    EXPECT_EQ(pair.body, cube);
    EXPECT_EQ(pair.other, floor);
    EXPECT_FALSE(pair.otherGone);
  }
}

TEST(ContactListener, aPairSumsUpItsContacts) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  CallRecorder recorder;
  bullet.system.setContactListener(&recorder);
  SoftBody* cube = addLightlyDampedCube(bullet.system, 0.5 + kRadius);
  bullet.simulate(0.5);
  const ContactPair& last = recorder.pairs.back();
  ASSERT_EQ(last.contacts, cube->contacts().size());
  double sum = 0.0, largest = 0.0;
  for (const SoftContact& c : cube->contacts())
    sum += c.normalImpulse, largest = std::max(largest, c.normalImpulse);
  EXPECT_EQ(last.normalImpulse, sum);
  EXPECT_EQ(last.strongest.normalImpulse, largest);
  if (kSurface) {
    EXPECT_LT(last.strongest.side.triangle, cube->network().surface.size());
  }
}

TEST(ContactListener, sleepIsSilentAndAPartnerThatGoesEndsThePair) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addBoxFloor();
  CallRecorder recorder;
  bullet.system.setContactListener(&recorder);
  SoftBody* cube = addLightlyDampedCube(bullet.system, 0.5 + kRadius);
  bullet.simulate(15.0);
  ASSERT_TRUE(cube->sleeping());
  const std::string calls = recorder.calls;
  bullet.simulate(1.0);
  EXPECT_EQ(recorder.calls, calls);
  bullet.world->removeRigidBody(floor);
  bullet.tick();
  EXPECT_EQ(recorder.calls, calls + 'e');
  EXPECT_EQ(recorder.pairs.back().other, floor);
  EXPECT_TRUE(recorder.pairs.back().otherGone);
  cube->wake();
  bullet.tick();
  EXPECT_EQ(recorder.calls, calls + 'e');
}

TEST(ContactListener, twoSoftBodiesAreTwoPairsAndDestroyingOneEndsBoth) {
  SoftWorld bullet(0.0);
  CallRecorder recorder;
  SoftBody* a = addLightlyDampedCube(bullet.system, 0.0);
  SoftBody* b = addLightlyDampedCube(bullet.system, 1.0 + 2 * kRadius + 0.001);
  bullet.system.setContactListener(&recorder);
  for (std::uint32_t i = 0; i < b->pointCount(); ++i) b->point(i)->setLinearVelocity(vec(0, -0.2, 0));
  for (int i = 0; i < 60 && recorder.calls.empty(); ++i) bullet.tick();
  ASSERT_EQ(recorder.calls, "bb");
  EXPECT_EQ(recorder.pairs[0].body, a);
  EXPECT_EQ(recorder.pairs[0].otherBody, b);
  EXPECT_EQ(recorder.pairs[1].body, b);
  EXPECT_EQ(recorder.pairs[1].otherBody, a);
  bullet.system.destroyBody(b);
  EXPECT_EQ(recorder.calls, "bbee");
  EXPECT_EQ(recorder.pairs[2].body, a);
  EXPECT_EQ(recorder.pairs[3].body, b);
  bullet.tick();
  EXPECT_EQ(recorder.calls, "bbee");
}

TEST(ContactListener, aBodyThatTheApplicationTakesOutOfTheWorldEndsItsPairs) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  CallRecorder recorder;
  bullet.system.setContactListener(&recorder);
  SoftBody* cube = addLightlyDampedCube(bullet.system, 0.5 + kRadius);
  SoftBody* second = addLightlyDampedCube(bullet.system, 5);
  bullet.simulate(0.2);
  btRigidBody* object = kSurface ? cube->surfaceObject() : cube->point(3);
  bullet.world->removeRigidBody(object);
  delete object;
  bullet.tick();
  EXPECT_FALSE(cube->alive());
  EXPECT_TRUE(second->alive());
  EXPECT_EQ(recorder.calls.back(), 'e');
}

TEST(ContactListener, mayDestroyBodiesEvenTheLastAndRemovePartners) {
  for (const bool all : {false, true}) {
    SoftWorld bullet;
    btRigidBody* floor = bullet.addBoxFloor();
    CallRecorder recorder;
    bullet.system.setContactListener(&recorder);
    addLightlyDampedCube(bullet.system, 0.5 + kRadius);
    addLightlyDampedCube(bullet.system, 0.5 + kRadius, 2.0);
    recorder.onBegin = [&](const ContactPair& pair) {
      if (all)
        bullet.system.removeAll();
      else
        bullet.system.destroyBody(pair.body);
      if (floor->isInWorld()) bullet.world->removeRigidBody(floor);
    };
    bullet.simulate(0.5);
    // The first call removed the floor, which therefore cannot begin a contact with the second body.
    EXPECT_EQ(recorder.calls, "be");
    EXPECT_EQ(bullet.system.bodyCount(), all ? 0u : 1u);
  }
}

TEST(ContactListener, nobodyIsToldAfterItIsTakenBack) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  CallRecorder recorder;
  bullet.system.setContactListener(&recorder);
  addLightlyDampedCube(bullet.system, 0.5 + kRadius);
  bullet.simulate(0.1);
  const std::string calls = recorder.calls;
  EXPECT_FALSE(calls.empty());
  bullet.system.setContactListener(nullptr);
  bullet.simulate(0.1);
  EXPECT_EQ(recorder.calls, calls);
  bullet.system.setContactListener(&recorder);
  bullet.tick();
  EXPECT_EQ(recorder.calls, calls + 'b');
}

}  // namespace
}  // namespace limber::test
