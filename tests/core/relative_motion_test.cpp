// SPDX-License-Identifier: Zlib
// How fast surfaces move past each other, against the velocities of their points.
#include "collide/surface.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <algorithm>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr MotionFrame kFrames[] = {MotionFrame::Still, MotionFrame::AtA, MotionFrame::AtB};

/// A cloud of points that moves as a rigid body.
struct Cloud {
  Points positions, velocities;

  Cloud(const Vector3d& centre, const Vector3d& size, const Vector3d& turn, const Vector3d& about) {
    positions = size.asDiagonal() * Points::Random(3, 40);
    positions.colwise() += centre;
    velocities.resize(3, positions.cols());
    for (Index i = 0; i < positions.cols(); ++i)
      velocities.col(i) = turn.cross(Vector3d(positions.col(i) - about));
  }
  SurfaceMotion motion() const { return fittedMotion(positions, velocities); }
};

TEST(RelativeMotion, findsTheTurnOfRigidMotion) {
  const Vector3d turn(1, -2, 3);
  for (const Vector3d& size : {Vector3d(1, 2, 0.5), Vector3d(1, 1, 0), Vector3d(1e-3, 2e-3, 1e-3)}) {
    const SurfaceMotion m = Cloud({3, 4, 5}, size, turn, {0, 1, 0}).motion();
    EXPECT_LT((m.turn - turn).norm(), 1e-6) << "rounding and kRegular";
    EXPECT_LT(m.deformation, 1e-6 * m.spread);
    EXPECT_GT(m.spread, 0.0);
  }
  const SurfaceMotion line = Cloud({0, 0, 0}, {1, 0, 0}, turn, {0, 0, 0}).motion();
  EXPECT_LT((line.turn - Vector3d(0, -2, 3)).norm(), 1e-6) << "a line does not tell its turn about itself";
  const SurfaceMotion point = fittedMotion(Points::Ones(3, 1), Points::Ones(3, 1));
  EXPECT_EQ(point.turn, Vector3d::Zero());
  EXPECT_EQ(point.mean, Vector3d::Ones());
}

TEST(RelativeMotion, whatTurnsTogetherDoesNotMove) {
  const Vector3d turn(0, 0, 10), about(0.5, 0, 0);
  const SurfaceMotion tyre = Cloud({0, 0, 0}, {1, 1, 0.2}, turn, about).motion(),
                      rim = Cloud({0.1, 0, 0}, {0.3, 0.3, 0.3}, turn, about).motion();
  const double features = 0.05;
  EXPECT_NE(calmestFrame(tyre, rim, features), MotionFrame::Still);
  const RelativeMotion calm = relativeMotion(tyre, rim, calmestFrame(tyre, rim, features));
  EXPECT_NEAR(calm.speed(features), 0.5 * features * turn.norm(), 1e-5) << "the turn of features alone";
  EXPECT_GT(relativeMotion(tyre, rim, MotionFrame::Still).speed(features), 10.0);
}

TEST(RelativeMotion, boundsAllRelativeVelocitiesInEachFrame) {
  for (int trial = 0; trial < 50; ++trial) {
    Cloud a(Vector3d::Random(), {1, 0.5, 0.2}, 3.0 * Vector3d::Random(), Vector3d::Random()),
        b(Vector3d::Random(), {0.3, 0.3, 0.6}, 3.0 * Vector3d::Random(), Vector3d::Random());
    a.velocities += 0.1 * Points::Random(3, 40);
    b.velocities += 0.1 * Points::Random(3, 40);
    b.positions = a.positions;  // in contact at each point
    const SurfaceMotion of = a.motion(), to = b.motion();
    for (const MotionFrame frame : kFrames) {
      const RelativeMotion m = relativeMotion(of, to, frame);
      double fastest = 0.0;
      for (Index i = 0; i < 40; ++i)
        fastest = std::max(fastest, (a.velocities.col(i) - b.velocities.col(i)).norm());
      EXPECT_GE(m.mean.norm() + m.spread, fastest * (1.0 - 1e-12)) << trial;
    }
  }
}

}  // namespace
}  // namespace limber
