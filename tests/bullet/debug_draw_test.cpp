// SPDX-License-Identifier: Zlib
// The output of soft bodies to the user's btIDebugDraw.
#include "support/soft_world.h"

#include <algorithm>

namespace limber::test {
namespace {

constexpr int kWireframe = btIDebugDraw::DBG_DrawWireframe, kAabb = btIDebugDraw::DBG_DrawAabb;
constexpr int kContacts = btIDebugDraw::DBG_DrawContactPoints;
constexpr int kConstraints = btIDebugDraw::DBG_DrawConstraints;

/// Records all lines and contact points.
struct DrawRecorder final : btIDebugDraw {
  struct Line {
    btVector3 from, to, colour;
  };
  struct Contact {
    btVector3 at, normal;
    double distance;
  };
  int mode = 0;
  std::vector<Line> lines;
  std::vector<Contact> contacts;

  void drawLine(const btVector3& from, const btVector3& to, const btVector3& colour) override {
    lines.push_back({from, to, colour});
  }
  void drawContactPoint(const btVector3& at, const btVector3& normal, btScalar distance, int,
                        const btVector3&) override {
    contacts.push_back({at, normal, double(distance)});
  }
  void reportErrorWarning(const char*) override {}
  void draw3dText(const btVector3&, const char*) override {}
  void setDebugMode(int m) override { mode = m; }
  int getDebugMode() const override { return mode; }
};

DrawRecorder drawn(const SoftBodySystem& system, int mode) {
  DrawRecorder recorder;
  recorder.mode = mode;
  system.debugDraw(recorder);
  return recorder;
}

bool has(const DrawRecorder& recorder, const btVector3& from, const btVector3& to) {
  const auto isThis = [&](const DrawRecorder::Line& line) {
    return line.from.distance(from) < btScalar(1e-5) && line.to.distance(to) < btScalar(1e-5);
  };
  return std::any_of(recorder.lines.begin(), recorder.lines.end(), isThis);
}

struct DebugDraw : testing::Test {
  BulletWorld bullet{0.0};
  SoftBodySystem system{*bullet.world};
};

TEST_F(DebugDraw, showsEverySpringColouredByItsStrain) {
  SoftBody* body = *system.createBody(pairNetwork(), testedSettings());
  ASSERT_EQ(drawn(system, kWireframe).lines.size(), 1u);
  const DrawRecorder::Line rest = drawn(system, kWireframe).lines[0];
  EXPECT_NEAR(double(rest.from.distance(rest.to)), 1.0, 1e-6);
  EXPECT_EQ(rest.colour.x(), rest.colour.z()) << "grey";

  for (const double length : {1.2, 0.8}) {
    body->pin(0), body->pin(1);
    body->point(1)->getWorldTransform().setOrigin(vec(length, 0, 0));
    bullet.tick();
    const DrawRecorder::Line line = drawn(system, kWireframe).lines[0];
    EXPECT_NEAR(double(line.from.distance(line.to)), length, 1e-5);
    if (length > 1.0)
      EXPECT_GT(line.colour.x(), 2 * line.colour.z()) << "red where it is stretched";
    else
      EXPECT_GT(line.colour.z(), 2 * line.colour.x()) << "blue where it is pressed together";
  }
}

TEST_F(DebugDraw, marksPinnedPoints) {
  SoftBody* body = *system.createBody(cubeNetwork(), testedSettings());
  const std::size_t springs = body->network().springs.size();
  body->pin(3);
  bullet.tick();
  EXPECT_EQ(drawn(system, kWireframe).lines.size(), springs + 3) << "a cross has three arms";
}

TEST_F(DebugDraw, drawsABoxAroundABodyWithItsRadius) {
  SoftBodySettings s = settingsAt({1, 2, 3});
  s.pointRadius = 0.1;
  system.createBody(pairNetwork(), s);
  const DrawRecorder box = drawn(system, kAabb);
  ASSERT_EQ(box.lines.size(), 12u);
  EXPECT_TRUE(has(box, vec(0.9, 1.9, 2.9), vec(2.1, 1.9, 2.9)) ||
              has(box, vec(2.1, 1.9, 2.9), vec(0.9, 1.9, 2.9)));
}

TEST(DebugDrawContacts, areThoseOfTheLastTick) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBodySettings s = settingsAt({0, 0.52, 0});
  s.pointRadius = 0.02;
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
  bullet.simulate(1.0);
  const DrawRecorder recorder = drawn(bullet.system, kContacts);
  ASSERT_EQ(recorder.contacts.size(), cube->contacts().size());
  ASSERT_GE(recorder.contacts.size(), 4u);
  for (const DrawRecorder::Contact& contact : recorder.contacts) {
    EXPECT_NEAR(double(contact.at.y()), 0.0, 1e-3) << "on the floor";
    EXPECT_GT(double(contact.normal.y()), 0.999);
  }
}

TEST_F(DebugDraw, drawsAnchorsAndSingleSpringsWithConstraints) {
  btRigidBody* box = bullet.addBox(vec(0.1, 0.1, 0.1), 1.0, vec(0, 1, 0));
  SoftBody* body = *system.createBody(pairNetwork(), settingsAt({3, 0, 0}));
  SpringSettings spring;
  ASSERT_TRUE(system.addSpring({box, vec(0, -0.1, 0)}, {nullptr, vec(0, 0.5, 0)}, spring));
  ASSERT_TRUE(system.attach(body, 0, *box, vec(0, 0.1, 0)));
  const DrawRecorder recorder = drawn(system, kConstraints);
  EXPECT_EQ(recorder.lines.size(), 2u);
  EXPECT_TRUE(has(recorder, vec(0, 0.9, 0), vec(0, 0.5, 0)));
  EXPECT_TRUE(has(recorder, vec(0, 1, 0), vec(0, 1.1, 0)));
}

TEST_F(DebugDraw, isPartOfTheWorldsOwn) {
  SoftBody* body = *system.createBody(pairNetwork(), testedSettings());
  DrawRecorder recorder;
  bullet.world->setDebugDrawer(&recorder);
  bullet.world->debugDrawWorld();
  EXPECT_TRUE(recorder.lines.empty()) << "no mode, nothing drawn";
  recorder.mode = kWireframe;
  bullet.world->debugDrawWorld();
  EXPECT_TRUE(has(recorder, vec(0, 0, 0), vec(1, 0, 0)));
  system.destroyBody(body);
  recorder.lines.clear();
  bullet.world->debugDrawWorld();
  EXPECT_TRUE(recorder.lines.empty());
  bullet.world->setDebugDrawer(nullptr);
}

}  // namespace
}  // namespace limber::test
