// SPDX-License-Identifier: Zlib
// Springs and anchors between points and rigid bodies, without Bullet.
#include "solver/links.h"
#include "solver/point_state.h"
#include "solver/verlet_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

TEST(Rotation, betweenUndoesBy) {
  for (const Vector3d& v :
       {Vector3d(0.3, -0.2, 0.5), Vector3d(1e-9, 2e-9, 0), Vector3d(0, 3.1, 0), Vector3d(0, 0, 0)}) {
    const Eigen::Quaterniond start(Eigen::AngleAxisd(1.1, Vector3d(1, 2, 3).normalized()));
    EXPECT_LT((rotationBetween(start, rotationBy(v) * start) - v).norm(), 1e-14) << v.transpose();
  }
}

/// A body with the moments 1, 2 and 6 kg m^2, or with two of them equal.
RigidState spinningBody(const Vector3d& moments) {
  RigidState body;
  body.inverseMass.setOnes();
  body.inverseInertiaLocal = moments.cwiseInverse();
  body.gyroscopic = true;
  body.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, -2, 3).normalized()));
  body.angularVelocity = body.rotation * Vector3d(0.4, 3.0, -0.7);
  body.turn();
  return body;
}

double rotationEnergy(const RigidState& body) {
  return 0.5 * body.angularVelocity.dot(body.angularMomentum());
}

RigidState turned(RigidState body, double time, int steps) {
  for (int i = 0; i < steps; ++i) body.drift(time / steps);
  return body;
}

TEST(FreeRotation, keepsMomentumAndItsEnergyDoesNotDrift) {
  RigidState body = spinningBody({1, 2, 6});
  const Vector3d momentum = body.angularMomentum();
  const double start = rotationEnergy(body);
  double swing = 0.0;
  for (int i = 0; i < 100000; ++i) {
    body.drift(0.1);
    const double error = std::abs(rotationEnergy(body) - start) / start;
    if (i < 1000)
      swing = std::max(swing, error);
    else
      ASSERT_LT(error, 1.1 * swing) << i;
  }
  EXPECT_LT((body.angularMomentum() - momentum).norm(), 1e-10 * momentum.norm());  // 2e-16 a step
}

TEST(FreeRotation, isOfSecondOrder) {
  const RigidState body = spinningBody({1, 2, 6}), exact = turned(body, 2.0, 20000);
  const auto error = [&](int steps) {
    return rotationBetween(turned(body, 2.0, steps).rotation, exact.rotation).norm();
  };
  EXPECT_NEAR(error(100) / error(200), 4.0, 0.1);
}

TEST(FreeRotation, isExactForTwoEqualMoments) {
  for (const Vector3d& moments : {Vector3d(2, 0.1, 2), Vector3d(1, 1, 1.9)}) {
    const RigidState body = spinningBody(moments);
    EXPECT_LT(rotationBetween(turned(body, 3.0, 2).rotation, turned(body, 3.0, 7).rotation).norm(), 1e-13);
  }
}

/// Two free points and a rigid cube with equal moments of inertia.
struct Linked {
  Linked() {
    points.resize(2);
    points.position.col(1) = Vector3d(0.6, 0.3, 0.2);
    points.inverseMass.setConstant(4.0);
    RigidState rigid;
    rigid.position = {-0.5, 0, 0};
    rigid.inverseMass.setConstant(0.5);
    rigid.inverseInertiaLocal.setConstant(3.0);
    rigid.angularVelocity = {0.5, 1.0, -2.0};
    rigid.velocity = {0.1, 0.2, 0.3};
    island.links.points.push_back(&points);
    island.links.rigids.push_back(rigid);
  }
  Linked(const Linked&) = delete;
  Linked& operator=(const Linked&) = delete;

  LinkEnd point(std::uint32_t i) const { return {LinkEnd::Kind::Point, 0, i, Vector3d::Zero()}; }
  LinkEnd pivot(const Vector3d& p) const { return {LinkEnd::Kind::Rigid, 0, 0, p}; }

  void addSpring(const LinkEnd& a, const LinkEnd& b, double damping) {
    LinkSpring s;
    s.a = a;
    s.b = b;
    s.restLength = 0.8;
    s.extensionStiffness = 40;
    s.compressionStiffness = 25;
    s.damping = damping;
    island.links.springs.push_back(s);
  }

  /// Runs the island. Its springs are links; the points belong to a body without springs.
  void run(double time, int substeps) {
    island.bodies = {{&points, &noSprings, nullptr}};
    stepVerlet(island, time, substeps);
  }

  const RigidState& rigid() const { return island.links.rigids[0]; }
  Vector3d momentum() const { return linearMomentum(points) + rigid().velocity / 0.5; }
  Vector3d angular() const {
    return angularMomentum(points) + rigid().position.cross(rigid().velocity) / 0.5 +
           rigid().angularVelocity / 3.0;
  }
  double energy() const {
    return kineticEnergy(points) + elasticEnergy(island.links) + rigid().velocity.squaredNorm() +
           rigid().angularVelocity.squaredNorm() / 6.0;
  }

  PointState points;
  SpringArrays noSprings;
  SolverIsland island;
};

TEST(Links, keepMomentumAndEnergy) {
  Linked linked;
  linked.addSpring(linked.point(0), linked.pivot({0.2, 0.1, 0}), 0.0);
  linked.addSpring(linked.pivot({0, 0.2, 0.3}), linked.point(1), 0.0);
  linked.addSpring(linked.point(0), linked.point(1), 0.0);
  const Vector3d p = linked.momentum(), l = linked.angular();
  const double e = linked.energy();
  linked.run(5.0, 20000);
  EXPECT_LT((linked.momentum() - p).norm(), 1e-11);
  EXPECT_LT((linked.angular() - l).norm(), 1e-9);
  EXPECT_NEAR(linked.energy(), e, 1e-5 * e) << "(omega dt)^2 / 8";
}

TEST(Links, dampersKeepMomentumAndOnlyTakeEnergy) {
  Linked linked;
  linked.addSpring(linked.point(0), linked.pivot({0.2, 0.1, 0}), 3.0);
  linked.addSpring(linked.pivot({0, 0.2, 0.3}), linked.point(1), 500.0);
  const Vector3d p = linked.momentum(), l = linked.angular();
  double before = linked.energy();
  for (int i = 0; i < 50; ++i) {
    linked.run(0.1, 400);
    EXPECT_LT(linked.energy(), before + 1e-9);
    before = linked.energy();
  }
  EXPECT_LT((linked.momentum() - p).norm(), 1e-11);
  EXPECT_LT((linked.angular() - l).norm(), 1e-9);
}

TEST(Links, thatHoldAPointAtRestMakeNoError) {
  Linked linked;
  linked.points.velocity.setZero();
  linked.points.acceleration.col(0) = Vector3d(0, -9.81, 0);
  LinkEnd place;
  const double stretched = 0.8 + 9.81 / (4.0 * 40.0);
  place.pivot = linked.points.position.col(0) + Vector3d(0, stretched, 0);
  linked.addSpring(linked.point(0), place, 0.0);
  linked.run(0.1, 10);
  EXPECT_LT((linked.points.position.col(0) - place.pivot + Vector3d(0, stretched, 0)).norm(), 1e-12);
  EXPECT_LT(linked.island.bodies[0].errorRate, 1e-12);
}

TEST(Anchors, holdPointsAtTheirPivotsAndKeepMomentum) {
  Linked linked;
  const Vector3d first = Vector3d(0.5, 0, 0), second = Vector3d(0.5, 0.4, 0.1);
  linked.points.position.col(0) = linked.rigid().position + first;
  linked.points.position.col(1) = linked.rigid().position + second;
  linked.island.links.anchors.push_back({linked.point(0), linked.pivot(first)});
  linked.island.links.anchors.push_back({linked.point(1), linked.pivot(second)});
  const Vector3d p = linked.momentum(), l = linked.angular();
  linked.run(2.0, 1000);
  for (const LinkAnchor& anchor : linked.island.links.anchors)
    EXPECT_LT(
        (endPosition(linked.island.links, anchor.point) - endPosition(linked.island.links, anchor.pivot))
            .norm(),
        1e-10);
  EXPECT_LT((linked.momentum() - p).norm(), 1e-11);
  // impulses act at the pivots at the start of a substep and at the points at its end: the error is of second
  // order
  EXPECT_LT((linked.angular() - l).norm(), 1e-3 * l.norm());
}

/// Points on a sphere of 1 m around a body, attached to it, of 130 times its mass and 60 times its moment of
/// inertia.
struct HeavySkin : Linked {
  HeavySkin() {
    constexpr std::uint32_t kCount = 26;
    points.resize(kCount);
    points.inverseMass.setConstant(0.1);
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const double y = (2.0 * i + 1.0) / kCount - 1.0, angle = 2.4 * i, across = std::sqrt(1.0 - y * y);
      const Vector3d arm(across * std::cos(angle), y, across * std::sin(angle));
      points.position.col(i) = rigid().position + arm;
      points.velocity.col(i) = rigid().velocityAt(arm);
      island.links.anchors.push_back({point(i), pivot(arm)});
    }
  }

  double farthest() const {
    double distance = 0.0;
    for (const LinkAnchor& anchor : island.links.anchors)
      distance = std::max(
          distance,
          (endPosition(island.links, anchor.point) - endPosition(island.links, anchor.pivot)).norm());
    return distance;
  }
};

TEST(Anchors, ofManyHeavyPointsOnALightBodyKeepItsMotion) {
  HeavySkin body;
  const Vector3d p = body.momentum(), l = body.angular();
  const double energy = body.energy(), speed = body.rigid().angularVelocity.norm();
  body.run(2.0, 200);
  EXPECT_LT(body.farthest(), 1e-9);
  EXPECT_LT((body.momentum() - p).norm(), 1e-11 * p.norm());
  // of second order in the angle of a substep, 0.023 rad: 5e-4
  EXPECT_LT((body.angular() - l).norm(), 1e-3 * l.norm());
  EXPECT_NEAR(body.energy() / energy, 1.0, 1e-3);
  EXPECT_NEAR(body.rigid().angularVelocity.norm() / speed, 1.0, 1e-3);
}

TEST(Anchors, ofAPinnedPointHoldTheBodyBesideOthers) {
  HeavySkin body;
  body.points.inverseMass.col(3).setZero();
  body.points.velocity.setZero();
  body.island.links.rigids[0].velocity.setZero();
  body.island.links.rigids[0].angularVelocity.setZero();
  const Vector3d place = body.points.position.col(3);
  body.points.acceleration.row(1).setConstant(-9.81);
  body.points.acceleration(1, 3) = 0.0;
  const double height = body.rigid().position.y();
  body.run(0.2, 100);
  EXPECT_EQ((body.points.position.col(3) - place).norm(), 0.0);
  EXPECT_LT(body.farthest(), 1e-5);
  EXPECT_LT(body.rigid().position.y(), height - 0.01);
}

TEST(Anchors, aHeldPointOnAHeldBodyIsLeftAlone) {
  Linked linked;
  linked.points.inverseMass.setZero();
  linked.island.links.rigids[0].inverseMass.setZero();
  linked.island.links.rigids[0].inverseInertiaLocal.setZero();
  linked.island.links.anchors.push_back({linked.point(0), linked.pivot({1, 0, 0})});
  linked.run(0.1, 5);
  EXPECT_TRUE(linked.points.position.allFinite());
  EXPECT_TRUE(linked.rigid().position.allFinite());
}

TEST(LinkFrequency, boundsTheReducedMassOscillator) {
  Linked linked;
  linked.island.links.rigids[0].inverseInertiaLocal.setZero();
  linked.addSpring(linked.point(0), linked.pivot({0.2, 0.1, 0}), 0.0);
  EXPECT_DOUBLE_EQ(linkFrequencyBoundSquared(linked.island.links), 40 * (4.0 + 0.5));
}

TEST(LinkFrequency, boundsAChainWhoseEndsShareNodes) {
  // w = 4 at both points, 0.5 + 3 |r|^2 at the pivots: row sums of sqrt(w_i w_j) k over the ends at one node
  Linked linked;
  linked.addSpring(linked.pivot({0.5, 0, 0}), linked.point(0), 0.0);
  linked.addSpring(linked.point(0), linked.point(1), 0.0);
  linked.addSpring(linked.point(1), linked.pivot({0, 1, 0}), 0.0);
  linked.addSpring(linked.point(1), {LinkEnd::Kind::World, 0, 0, Vector3d(1, 2, 3)}, 0.0);
  const double near = std::sqrt(0.5 + 0.75), far = std::sqrt(0.5 + 3.0);
  const double rows[] = {near * (near + far) + 4.0 * 2, 4.0 * 2 + 4.0 * 3, 4.0 * 3 + far * (near + far),
                         4.0 * 3};
  EXPECT_NEAR(linkFrequencyBoundSquared(linked.island.links), 40 * *std::max_element(rows, rows + 4), 1e-9);
}

TEST(LinkFrequency, boundsAChainOfAnyLength) {
  Linked linked;
  const std::uint32_t count = 100000;
  linked.points.resize(count);
  linked.points.inverseMass.setConstant(4.0);
  for (std::uint32_t i = 1; i < count; ++i) linked.addSpring(linked.point(i - 1), linked.point(i), 0.0);
  EXPECT_DOUBLE_EQ(linkFrequencyBoundSquared(linked.island.links), 40 * 4.0 * 4);
}

}  // namespace
}  // namespace limber
