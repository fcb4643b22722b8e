// SPDX-License-Identifier: Zlib
// Springs that break, welds, skeletons, and ropes with heavy loads.
#include "support/soft_world.h"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace limber::test {
namespace {

// --- springs that break ------------------------------------------------------------------------------------

/// A box that hangs by a spring which holds `force`, in N.
double heightAfterASecond(double force, bool& broken) {
  SoftWorld bullet(-10.0);
  btRigidBody* box = bullet.addBox(vec(0.1, 0.1, 0.1), 2.0, vec(0, 0, 0));
  SpringSettings spring;
  spring.stiffness = 1e4;
  spring.damping = 200.0;
  spring.breakForce = force;
  SpringConstraint* held = *bullet.system.addSpring({nullptr, vec(0, 1, 0)}, {box}, spring);
  bullet.simulate(1.0);
  broken = held->broken();
  if (broken) {
    EXPECT_EQ(held->force(), 0.0);
    EXPECT_TRUE(bullet.system.changeSpring(held, held->settings()));
    EXPECT_FALSE(held->broken());
  }
  return heightOf(*box);
}

TEST(BreakForce, aSpringBreaksUnderMoreThanItHolds) {
  bool broken = false;
  // it carries 20 N, and up to twice that while the box swings in
  EXPECT_NEAR(heightAfterASecond(41.0, broken), -20.0 / 1e4, 1e-4);
  EXPECT_FALSE(broken);
  EXPECT_LT(heightAfterASecond(15.0, broken), -4.0);
  EXPECT_TRUE(broken);
  SoftWorld bullet;
  SpringSettings bad;
  bad.breakForce = -1.0;
  EXPECT_EQ(bullet.system.addSpring({nullptr}, {bullet.addBox(vec(1, 1, 1), 1.0, vec(0, 0, 0))}, bad).error(),
            "breakForce is -1, must be from 0 to 1e18");
}

// --- welds -------------------------------------------------------------------------------------------------

/// Two cubes one above the other whose faces are welded, the upper one pinned.
struct WeldedCubes {
  explicit WeldedCubes(double breakForce) : bullet(-10.0), system(*bullet.world) {
    SoftBodySettings s = testedSettings();
    setSprings(s, 2000.0, 10.0);
    upper = *system.createBody(closedCubeNetwork(), s);
    s.position = {0, -1.05, 0};
    lower = *system.createBody(closedCubeNetwork(), s);
    SpringSettings seam;
    seam.stiffness = 2000.0;
    seam.damping = 10.0;
    seam.breakForce = breakForce;
    const auto made = system.weld(upper, lower, 0.06, seam);
    EXPECT_TRUE(made) << made.error();
    if (made) springs = *made;
    for (std::uint32_t i = 0; i < 8; ++i)
      if (upper->position(i).y() > 0.0) upper->pin(i);
  }
  BulletWorld bullet;
  SoftBodySystem system;
  SoftBody *upper, *lower;
  std::vector<SpringConstraint*> springs;
};

TEST(Weld, holdsWhatItCan) {
  WeldedCubes strong(0.0), weak(1.5);
  ASSERT_EQ(strong.springs.size(), 4u) << "one at each corner of the faces that meet";
  strong.bullet.simulate(4.0);
  weak.bullet.simulate(4.0);
  double sum = 0.0;
  for (const SpringConstraint* spring : strong.springs) sum += spring->force();
  EXPECT_NEAR(sum, 10.0, 0.05) << "the seam carries the weight of 1 kg";
  EXPECT_GT(strong.lower->centerOfMass().y(), -1.2);
  for (const SpringConstraint* spring : weak.springs) EXPECT_TRUE(spring->broken());
  EXPECT_LT(weak.lower->centerOfMass().y(), -20.0);
}

TEST(Weld, impossibleOnesAreRefused) {
  WeldedCubes cubes(0.0);
  EXPECT_EQ(cubes.system.weld(cubes.upper, cubes.upper, 1.0).error(),
            "a soft body cannot be welded to itself");
  EXPECT_EQ(cubes.system.weld(cubes.upper, cubes.lower, 0.0).error(),
            "the distance of a weld must be above 0");
  EXPECT_EQ(cubes.system.weld(cubes.upper, cubes.lower, 0.01).error(),
            "no points of the two bodies are within the distance");
  EXPECT_EQ(cubes.system.springCount(), 4u);
}

// --- skeletons ---------------------------------------------------------------------------------------------

btTransform bone(double x, double angle) {
  return btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(angle)), vec(x, 0, 0));
}

TEST(BoundSkeleton, pointsFollowTheirBonesByWeights) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(closedCubeNetwork());
  const Eigen::Vector3d start[] = {body->position(0), body->position(1), body->position(2)};
  std::vector<btTransform> bones = {bone(0, 0), bone(1, 0)};
  auto skeleton = Skeleton::bind(bullet.system, *body,
                                 {{0, {{0, 1.0}}}, {1, {{1, 1.0}}}, {2, {{0, 0.5}, {1, 0.5}}}}, bones);
  ASSERT_TRUE(skeleton) << skeleton.error();
  for (int i = 0; i <= 30; ++i) {
    bones[1] = bone(1, 0.01 * i);
    ASSERT_TRUE(skeleton->moveTo(bones));
    bullet.tick();
  }
  const Eigen::AngleAxisd turn(0.3, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d pivot = Eigen::Vector3d::UnitX();
  const auto turned = [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(pivot + turn * (x - pivot)); };
  EXPECT_LT((body->position(0) - start[0]).norm(), 1e-6);
  EXPECT_LT((body->position(1) - turned(start[1])).norm(), 1e-5);
  EXPECT_LT((body->position(2) - 0.5 * (start[2] + turned(start[2]))).norm(), 1e-5);
  bones = {bone(50, 0), bone(51, 0)};
  ASSERT_TRUE(skeleton->moveTo(bones, true));
  EXPECT_LT((body->position(0) - start[0] - Eigen::Vector3d(50, 0, 0)).norm(), 1e-5);
  EXPECT_LT(body->velocity(0).norm(), 1e-9);
  skeleton->release();
  EXPECT_FALSE(body->pinned(0));
  skeleton = Skeleton::bind(bullet.system, *body, {{0, {{0, 1.0}}}}, bones);
  ASSERT_TRUE(bullet.system.destroyBody(body));
  EXPECT_EQ(skeleton->moveTo(bones).error(), "the soft body of the skeleton has been destroyed");
}

/// A cloth in the plane y = 0 whose normals point up, carried by one bone with the same limits at each point.
struct LimitedCloth {
  LimitedCloth(double gravity, double maxDistance, double backStop, double side = 1.0)
      : bullet(gravity), system(*bullet.world), bones{bone(0, 0)} {
    SoftBodySettings s = testedSettings();
    s.totalMass = 0.1;
    setSprings(s, 100.0, 0.05);
    s.flow.linearDrag = 0.0;
    s.scale.x() = side;
    body = *system.createBody(squareCloth(6), s);
    std::vector<BoundPoint> points;
    for (std::uint32_t i = 0; i < body->pointCount(); ++i)
      points.push_back({i, {{0, 1.0}}, maxDistance, backStop});
    auto made = Skeleton::bind(system, *body, points, bones);
    EXPECT_TRUE(made) << made.error();
    if (made) skeleton.emplace(std::move(*made));
  }

  /// m, the largest distance of a point from its place.
  double largestDistance() const {
    double largest = 0.0;
    for (std::uint32_t i = 0; i < body->pointCount(); ++i)
      largest = std::max(largest, (body->position(i) - fromBt(skeleton->place(i))).norm());
    return largest;
  }

  static Eigen::Vector3d fromBt(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }

  BulletWorld bullet;
  SoftBodySystem system;
  std::vector<btTransform> bones;
  SoftBody* body = nullptr;
  std::optional<Skeleton> skeleton;
};

/// m: a point of 4 g or less on a spring of 100 N/m, at rest.
constexpr double kGivesWay = 0.1 / 25.0 * 10.0 / 100.0;

TEST(BoundSkeleton, limitedPointsFallAsFarAsTheyMay) {
  LimitedCloth cloth(-10.0, 0.05, -1.0);
  for (int i = 0; i < 4; ++i) cloth.bullet.tick();
  EXPECT_NEAR(cloth.body->centerOfMass().y(), -5.0 * std::pow(4.0 / 60.0, 2), 1e-6) << "free fall";
  cloth.bullet.simulate(3.0);
  EXPECT_NEAR(cloth.largestDistance(), 0.05, kGivesWay);
  EXPECT_NEAR(cloth.body->centerOfMass().y(), -0.05, kGivesWay);
}

TEST(BoundSkeleton, theBackStopHoldsThemInFront) {
  LimitedCloth behind(-10.0, 0.05, 0.01), infront(10.0, 0.05, 0.01);
  behind.bullet.simulate(3.0);
  infront.bullet.simulate(3.0);
  EXPECT_NEAR(behind.body->centerOfMass().y(), -0.01, kGivesWay);
  EXPECT_NEAR(infront.body->centerOfMass().y(), 0.05, kGivesWay);
  LimitedCloth mirrored(-10.0, 0.05, 0.01, -1.0);
  mirrored.bullet.simulate(3.0);
  EXPECT_NEAR(mirrored.body->centerOfMass().y(), -0.01, kGivesWay);
  // upside down, behind is above
  LimitedCloth turned(10.0, 0.05, 0.01);
  for (int i = 0; i <= 60; ++i) {
    turned.bones[0] = bone(0, M_PI * i / 60.0);
    ASSERT_TRUE(turned.skeleton->moveTo(turned.bones));
    turned.bullet.tick();
  }
  turned.bullet.simulate(3.0);
  // beside the place the sphere is lower, by up to 0.05^2 / (2 x 0.5)
  EXPECT_GT(turned.body->centerOfMass().y(), 0.01 - kGivesWay);
  EXPECT_LT(turned.body->centerOfMass().y(), 0.01 + 0.0025 + kGivesWay);
}

TEST(BoundSkeleton, limitedPointsKeepUpWithTheirBones) {
  LimitedCloth cloth(0.0, 0.02, 0.0);
  for (int i = 1; i <= 120; ++i) {
    cloth.bones[0].setOrigin(vec(4.0 * i / 60.0, 0, 0));
    ASSERT_TRUE(cloth.skeleton->moveTo(cloth.bones));
    cloth.bullet.tick();
    // from rest to 4 m/s at once: the spring of a point stretches by v sqrt(m / k) at most
    EXPECT_LT(cloth.largestDistance(), 0.02 + 4.0 * std::sqrt(0.1 / 36.0 / 100.0)) << i;
  }
  EXPECT_NEAR(cloth.body->linearMomentum().x(), 0.4, 0.01);
}

TEST(BoundSkeleton, aTeleportTakesTheWholeBodyAlong) {
  LimitedCloth cloth(-10.0, 0.05, 0.01);
  cloth.bullet.simulate(2.0);
  const double before = energyOf(*cloth.body);
  cloth.bones[0].setOrigin(vec(30, 5, 0));
  ASSERT_TRUE(cloth.skeleton->moveTo(cloth.bones, true));
  cloth.bullet.simulate(0.2);
  EXPECT_NEAR(cloth.body->centerOfMass().x(), 30.0, 1e-3);
  EXPECT_LT(energyOf(*cloth.body), before + 1e-4);
  cloth.skeleton->release();
  EXPECT_EQ(cloth.system.springCount(), 0u);
}

/// Points on one line do not say how the body turns about it, nor does one point alone.
TEST(BoundSkeleton, aTeleportByFewPointsTurnsNothing) {
  for (const std::uint32_t count : {1u, 4u}) {
    SoftWorld bullet(0.0);
    SoftBody* cloth = bullet.addSoft(squareCloth(6));
    std::vector<BoundPoint> points;
    for (std::uint32_t i = 0; i < count; ++i) points.push_back({i, {{0, 1.0}}});
    std::vector<btTransform> bones{bone(0, 0)};
    auto skeleton = Skeleton::bind(bullet.system, *cloth, points, bones);
    ASSERT_TRUE(skeleton);
    bullet.tick();
    std::vector<Eigen::Vector3d> before;
    for (std::uint32_t i = 0; i < cloth->pointCount(); ++i) before.push_back(cloth->position(i));
    bones[0].setOrigin(vec(3, 2, 1));
    ASSERT_TRUE(skeleton->moveTo(bones, true));
    for (std::uint32_t i = 0; i < cloth->pointCount(); ++i)
      EXPECT_LT((cloth->position(i) - before[i] - Eigen::Vector3d(3, 2, 1)).norm(), 1e-3)
          << count << ' ' << i;
  }
}

TEST(BoundSkeleton, aRefusedTeleportMovesNothing) {
  LimitedCloth cloth(0.0, 0.05, -1.0);
  cloth.bullet.tick();
  btRigidBody* object = cloth.body->surfaceObject();
  if (!object) GTEST_SKIP() << "needs Collision::Surface";
  const btVector3 place = cloth.skeleton->place(0);
  cloth.bullet.world->removeRigidBody(object);
  cloth.bones[0].setOrigin(vec(10, 0, 0));
  EXPECT_FALSE(cloth.skeleton->moveTo(cloth.bones, true));
  EXPECT_EQ(cloth.skeleton->place(0), place);
  cloth.bullet.world->addRigidBody(object);
  ASSERT_TRUE(cloth.skeleton->moveTo(cloth.bones, true));
  EXPECT_NEAR(cloth.body->centerOfMass().x(), 10.0, 1e-3);
}

/// Retries of a tick start from the same places: the body stays behind its bones.
TEST(BoundSkeleton, aToleranceDoesNotThrowThePointsAhead) {
  LimitedCloth cloth(0.0, 0.02, -1.0);
  SoftBodySettings s = cloth.body->settings();
  s.stepping.tolerance = 1e-4;
  ASSERT_TRUE(cloth.body->change(s));
  for (int i = 1; i <= 30; ++i) {
    cloth.bones[0].setOrigin(vec(6.0 * i / 60.0, 0, 0));
    ASSERT_TRUE(cloth.skeleton->moveTo(cloth.bones));
    cloth.bullet.tick();
    EXPECT_LT(cloth.body->centerOfMass().x(), 6.0 * i / 60.0) << i;
  }
}

TEST(BoundSkeleton, itMayOutliveTheBodyAndTheSystem) {
  std::optional<Skeleton> skeleton;
  {
    LimitedCloth cloth(-10.0, 0.05, 0.01);
    skeleton.emplace(std::move(*cloth.skeleton));
    EXPECT_EQ(cloth.system.springCount(), 2u * cloth.body->pointCount());
    ASSERT_TRUE(cloth.system.destroyBody(cloth.body));
    EXPECT_EQ(cloth.system.springCount(), 0u);
    EXPECT_FALSE(skeleton->moveTo(cloth.bones));
  }
  skeleton.reset();
}

TEST(BoundSkeleton, badBindingsAreNamedAndPinNothing) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(closedCubeNetwork());
  const std::vector<btTransform> bones = {bone(0, 0)};
  EXPECT_EQ(Skeleton::bind(bullet.system, *body, {{0, {{0, 1.0}}}, {99, {{0, 1.0}}}}, bones).error(),
            "bound point 1: there is no point 99");
  EXPECT_EQ(Skeleton::bind(bullet.system, *body, {{0, {{3, 1.0}}}}, bones).error(),
            "bound point 0: there is no bone 3");
  EXPECT_EQ(Skeleton::bind(bullet.system, *body, {{0, {{0, 0.7}}}}, bones).error(),
            "bound point 0: the weights do not sum to 1");
  EXPECT_EQ(Skeleton::bind(bullet.system, *body, {{0, {{0, 1.0}}}, {0, {{0, 1.0}}}}, bones).error(),
            "bound point 1: the point is bound twice");
  EXPECT_EQ(Skeleton::bind(bullet.system, *body, {{0, {{0, 1.0}}, -1.0}}, bones).error(),
            "bound point 0: maxDistance must be from 0 to 1e6");
  EXPECT_EQ(Skeleton::bind(bullet.system, *body, {{0, {{0, 1.0}}, 0.0, 0.1}}, bones).error(),
            "bound point 0: a back stop needs a maxDistance above 0");
  const btScalar lostAt = std::numeric_limits<btScalar>::quiet_NaN();
  for (const btScalar x : {lostAt, btScalar(1e7)})
    EXPECT_EQ(Skeleton::bind(bullet.system, *body, {{0, {{0, 1.0}}}}, {bone(x, 0)}).error(),
              "bone 0 is not finite, or farther than 1e6 m");
  btTransform crushed = bones[0];
  crushed.setBasis(btMatrix3x3(0, 0, 0, 0, 0, 0, 0, 0, 0));
  EXPECT_EQ(Skeleton::bind(bullet.system, *body, {{0, {{0, 1.0}}}}, {crushed}).error(),
            "bone 0 has a basis without volume");
  EXPECT_FALSE(body->pinned(0));
  EXPECT_EQ(bullet.system.springCount(), 0u);
  auto skeleton = Skeleton::bind(bullet.system, *body, {{0, {{0, 1.0}}}}, bones);
  EXPECT_EQ(skeleton->moveTo({}).error(), "0 bones, bound were 1");
  btTransform lost = bones[0];
  lost.setOrigin(vec(NAN, 0, 0));
  EXPECT_EQ(skeleton->moveTo({lost}).error(), "bone 0 is not finite, or farther than 1e6 m");
}

// --- anchors and events ------------------------------------------------------------------------------------

/// Notes what breaks.
struct BreakListener : ContactListener {
  void springBreaks(SpringConstraint& spring) override { springs.push_back(&spring); }
  void anchorBreaks(const BrokenAnchor& anchor) override { anchors.push_back(anchor); }
  void bodyTears(SoftBody&, const std::vector<Tear>& places) override { tears += places.size(); }
  std::vector<SpringConstraint*> springs;
  std::vector<BrokenAnchor> anchors;
  std::size_t tears = 0;
};

/// A rope of 0.1 kg that hangs from a static box by an anchor, with a load of 2 kg at its lower end.
struct HangingLoad {
  explicit HangingLoad(double breakForce) : bullet(-10.0), system(*bullet.world) {
    SoftBodySettings s = testedSettings();
    s.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(-M_PI / 2.0, Eigen::Vector3d::UnitZ()));
    s.totalMass = 0.1;
    setSprings(s, 5e3, 20.0);
    s.flow.linearDrag = 0.0;
    rope = *system.createBody(ropeNetwork(5, 1.0), s);
    hook = bullet.addBox(vec(0.1, 0.1, 0.1), 0.0, toBt(rope->position(0)) + vec(0, 0.1, 0));
    load = bullet.addBox(vec(0.1, 0.1, 0.1), 2.0, toBt(rope->position(5)) - vec(0, 0.1, 0));
    EXPECT_TRUE(system.attach(rope, 0, *hook, breakForce));
    EXPECT_TRUE(system.attach(rope, 5, *load));
    system.setContactListener(&listener);
  }
  static btVector3 toBt(const Eigen::Vector3d& v) { return vec(v.x(), v.y(), v.z()); }

  BreakListener listener;
  BulletWorld bullet;
  SoftBodySystem system;
  SoftBody* rope;
  btRigidBody *hook, *load;
};

TEST(Anchors, theirForcesAreThoseOfTheLoad) {
  HangingLoad hanging(0.0);
  hanging.load->setActivationState(DISABLE_DEACTIVATION);
  hanging.bullet.simulate(4.0);
  double upper = 0.0, lower = 0.0;
  // means over several swings
  for (int i = 0; i < 240; ++i) {
    hanging.bullet.tick();
    upper += double(hanging.rope->anchorForce(0).y()) / 240.0;
    lower += double(hanging.rope->anchorForce(5).y()) / 240.0;
  }
  EXPECT_NEAR(upper, 21.0, 0.05);
  EXPECT_NEAR(lower, -20.0, 0.05);
  EXPECT_EQ(hanging.rope->anchorForce(2).length(), btScalar(0));
  EXPECT_TRUE(hanging.rope->attached(0));
  hanging.bullet.world->removeRigidBody(hanging.load);
  hanging.bullet.tick();
  EXPECT_EQ(hanging.rope->anchorForce(5).length(), btScalar(0)) << "its body is in no world";
  EXPECT_FALSE(hanging.rope->attached(1));
  EXPECT_FALSE(hanging.rope->attached(99));
}

TEST(Anchors, theyBreakUnderMoreThanTheyHold) {
  // the load swings in to at most twice its weight
  HangingLoad holds(43.0), breaks(15.0);
  holds.bullet.simulate(2.0);
  breaks.bullet.simulate(2.0);
  EXPECT_TRUE(holds.listener.anchors.empty());
  ASSERT_EQ(breaks.listener.anchors.size(), 1u);
  const BrokenAnchor& broken = breaks.listener.anchors[0];
  EXPECT_EQ(broken.body, breaks.rope);
  EXPECT_EQ(broken.point, 0u);
  EXPECT_EQ(broken.other, breaks.hook);
  EXPECT_GT(broken.force, 15.0);
  EXPECT_FALSE(breaks.rope->attached(0));
  EXPECT_TRUE(breaks.rope->attached(5));
  EXPECT_LT(double(breaks.load->getCenterOfMassPosition().y()), -10.0);
  EXPECT_EQ(breaks.system.attach(breaks.rope, 0, *breaks.hook, -1.0).error(),
            "breakForce must be from 0 to 1e18");
  EXPECT_TRUE(breaks.system.attach(breaks.rope, 0, *breaks.hook, 1.0));
}

/// A part of the rope lies within the body. Friction there must act on both at the same place.
TEST(Anchors, aRopeFromTheMiddleOfASpinningBodyTakesNoAngularMomentum) {
  if (!kSurface) GTEST_SKIP() << "points are balls that do not turn when friction acts on them";
  for (const bool ball : {false, true})
    for (const double length : {0.2, 1.0}) {
      SCOPED_TRACE(testing::Message() << (ball ? "ball, " : "box, ") << length << " m");
      SoftWorld bullet(0.0);
      btRigidBody* body = ball ? bullet.add(std::make_unique<btSphereShape>(btScalar(0.2)), 1.0, vec(0, 0, 0))
                               : bullet.addBox(vec(0.2, 0.2, 0.2), 1.0, vec(0, 0, 0));
      body->setActivationState(DISABLE_DEACTIVATION);
      body->setAngularVelocity(vec(0, 3, 0));
      SoftBodySettings s = testedSettings();
      s.totalMass = 0.1;
      s.friction = 0.5;
      SoftBody* rope = bullet.addSoft(ropeNetwork(8, length), s);
      ASSERT_TRUE(bullet.system.attach(rope, 0, *body));
      const double spin = angularMomentumOf(*body).y();
      bullet.simulate(5.0);
      // Bullet's floats
      EXPECT_NEAR(rope->angularMomentum().y() + angularMomentumOf(*body).y(), spin, 1e-3 * spin);
    }
}

/// Its last points are inside the ball, which pushed them out against the anchor: 73 to 150 N.
TEST(Anchors, aRopeMayBeginInTheMiddleOfABall) {
  SoftWorld bullet(-10.0);
  SoftBodySettings s = settingsAt({0, 8, 0});
  s.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(-M_PI / 2.0, Eigen::Vector3d::UnitZ()));
  s.damping = 5.0;
  SoftBody* rope = bullet.addSoft(*buildRope({}), s);
  const std::uint32_t last = rope->pointCount() - 1;
  ASSERT_TRUE(rope->pin(0));
  btRigidBody* ball = bullet.add(std::make_unique<btSphereShape>(btScalar(0.2)), 2.0,
                                 vec(rope->position(last).x(), rope->position(last).y(), 0));
  ball->setActivationState(DISABLE_DEACTIVATION);
  ASSERT_TRUE(bullet.system.attach(rope, last, *ball));
  bullet.simulate(20.0);
  EXPECT_NEAR(double(rope->anchorForce(last).y()), -20.0, 0.1) << "the weight of the ball";
  for (std::uint32_t i = 0; i < last; ++i) EXPECT_LT(rope->position(i + 1).y(), rope->position(i).y());
}

TEST(Anchors, anEdgeIsAttachedAsAWholeOrNotAtAll) {
  SoftWorld bullet(-10.0);
  SoftBodySettings s = testedSettings();
  s.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitX()));
  s.totalMass = 0.5;
  setSprings(s, 2e3, 5.0);
  SoftBody* cloth = bullet.addSoft(squareCloth(5), s);
  std::vector<std::uint32_t> edge;
  for (std::uint32_t i = 0; i < cloth->pointCount(); ++i)
    if (cloth->position(i).y() > 0.499) edge.push_back(i);
  btRigidBody* rod = bullet.addBox(vec(0.6, 0.02, 0.02), 0.0, vec(0, 0.52, 0));
  ASSERT_EQ(edge.size(), 6u);
  std::vector<std::uint32_t> twice = edge;
  twice.push_back(edge.front());
  const std::vector<std::uint8_t> before = cloth->saveState();
  EXPECT_EQ(bullet.system.attach(cloth, twice, *rod).error(),
            "point " + std::to_string(edge.front()) + " is listed twice");
  EXPECT_FALSE(cloth->attached(edge.front()));
  EXPECT_EQ(cloth->saveState(), before) << "nor is it woken";
  ASSERT_TRUE(bullet.system.attach(cloth, edge, *rod, 5.0));
  bullet.simulate(10.0);
  double weight = 0.0;
  for (std::uint32_t i : edge) {
    EXPECT_TRUE(cloth->attached(i));
    EXPECT_NEAR(cloth->position(i).y(), 0.5, 1e-3);
    weight += double(cloth->anchorForce(i).y());
  }
  EXPECT_NEAR(weight, 5.0, 0.05);
}

TEST(BreakForce, theListenerHearsOfEachBreakOnce) {
  WeldedCubes weak(1.5);
  BreakListener listener;
  weak.system.setContactListener(&listener);
  weak.bullet.simulate(2.0);
  EXPECT_EQ(listener.springs.size(), 4u);
  for (const SpringConstraint* spring : listener.springs) EXPECT_TRUE(spring->broken());
  weak.system.setContactListener(nullptr);
}

TEST(TearEvents, theListenerHearsOfEachTear) {
  SoftWorld bullet(-10.0);
  BreakListener listener;
  bullet.system.setContactListener(&listener);
  SoftBodySettings s = settingsAt({0, 3, 0});
  s.totalMass = 1.0;
  s.extensionStiffness = s.compressionStiffness = 1000.0;
  s.elasticLimit.breakStrain = 0.01;
  s.elasticLimit.tear = true;
  SoftBody* rope = bullet.addSoft(ropeNetwork(10, 1.0), s);
  ASSERT_TRUE(rope->pin(0));
  ASSERT_TRUE(rope->pin(10));
  std::size_t polled = 0;
  for (int i = 0; i < 120; ++i) {
    bullet.tick();
    polled += rope->tears().size();
  }
  EXPECT_GT(listener.tears, 0u);
  EXPECT_EQ(listener.tears, polled);
  EXPECT_EQ(rope->pointCount(), 11u + polled);
  bullet.system.setContactListener(nullptr);
}

// --- heavy loads -------------------------------------------------------------------------------------------

TEST(HeavyLoad, aBoxOfATonHangsFromARopeOfAHundredGrams) {
  SoftWorld bullet(-10.0);
  RopeSettings shape;
  shape.length = 2.0;
  shape.segments = 20;
  shape.bendingScale = 0.0;
  SoftBodySettings s = testedSettings();
  s.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(-M_PI / 2.0, Eigen::Vector3d::UnitZ()));
  s.totalMass = 0.1;
  setSprings(s, 2e7, 2e3);
  SoftBody* rope = bullet.addSoft(*buildRope(shape), s);
  ASSERT_TRUE(rope->pin(0));
  btRigidBody* box = bullet.addBox(vec(0.3, 0.3, 0.3), 1000.0, vec(0, -2.3, 0));
  ASSERT_TRUE(bullet.system.attach(rope, 20, *box, vec(0, 0.3, 0)));
  double lowest = 0.0, sum = 0.0;
  for (int i = 0; i < 240; ++i) {
    bullet.tick();
    const double y = heightOf(*box);
    lowest = std::min(lowest, y);
    sum += y / 240.0;
  }
  // 1e4 N stretch each of 20 springs of 2e7 N/m by 0.5 mm: 10 mm; dropped at rest, it swings at most twice as
  // far
  EXPECT_GT(lowest, -2.3 - 0.0202);
  // about that place, over twenty swings
  EXPECT_NEAR(sum, -2.31, 0.001);
}

TEST(HeavyLoad, aWinchLiftsItsLoad) {
  SoftWorld bullet(-10.0);
  btRigidBody* box = bullet.addBox(vec(0.1, 0.1, 0.1), 50.0, vec(0, -3, 0));
  SpringSettings cable;
  cable.stiffness = 1e5;
  cable.damping = 2e3;
  cable.action = SpringAction::ExtensionOnly;
  cable.restLength = 3.0;
  SpringConstraint* winch = *bullet.system.addSpring({nullptr}, {box}, cable);
  double before = 0.0;
  for (int i = 0; i < 240; ++i) {
    cable.restLength = 3.0 - 0.5 * i / 60.0;
    ASSERT_TRUE(bullet.system.changeSpring(winch, cable));
    bullet.tick();
    if (i == 179) before = heightOf(*box);
  }
  const double height = heightOf(*box);
  // at 0.5 m/s for 4 s; 500 N stretch the cable by 5 mm, and a tick's pull is 8 mm
  EXPECT_NEAR(height, -3.0 + 0.5 * 239 / 60.0 - 0.005, 0.01);
  EXPECT_NEAR(height - before, 0.5, 1e-3);
}

}  // namespace
}  // namespace limber::test
