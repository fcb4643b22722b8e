// SPDX-License-Identifier: Zlib
// Fast surfaces: features, points and times of impact, and surfaces that miss each other.
#include "support/moving_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;
using test::kMargin;
using test::MovingShape;

/// Returns the distance (m) from the surface of a cube of 1 m around the origin, negative inside.
double distanceToCube(const Vector3d& p) {
  const Vector3d q = p.cwiseAbs() - Vector3d::Constant(0.5);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

Vector3d normalOfCube(const Vector3d& p) { return (p - p.cwiseMin(0.5).cwiseMax(-0.5)).normalized(); }

/// The path of a ball past or into the cube. Outside a convex body the distance is a convex function of the
/// path: its minimum is found by ternary search, the time of impact by bisection.
struct Shot {
  Vector3d from, motion;

  double distance(double time) const { return distanceToCube(from + time * motion); }
  double nearestTime() const {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 200; ++i) {
      const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
      (distance(a) < distance(b) ? high : low) = distance(a) < distance(b) ? b : a;
    }
    return low;
  }
  double timeOfImpact(double radiusSum) const {
    double low = 0.0, high = nearestTime();
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (distance(middle) > radiusSum ? low : high) = middle;
    }
    return high;
  }
};

/// Returns a shot at a random face, edge or corner, displaced by up to 6 cm per axis, from 0.1 to 1 m away.
Shot randomShot(std::mt19937& random, double speed) {
  std::uniform_int_distribution<int> features(0, 2);
  std::uniform_real_distribution<double> fraction(0.0, 1.0);
  Vector3d target = 0.5 * test::randomVector(random);
  for (int i = features(random); i >= 0; --i) target[i] = target[i] < 0.0 ? -0.5 : 0.5;
  target += 0.06 * test::randomVector(random);
  Shot shot;
  const Vector3d direction = (test::randomTurn(random) * Vector3d::UnitX());
  shot.from = target - (0.1 + 0.9 * fraction(random)) * direction;
  shot.motion = speed / 60.0 * direction;
  return shot;
}

TEST(SurfaceMotion, shotsMeetTheCubeWhereTheyEnter) {
  std::mt19937 random(8);
  int hits = 0, misses = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const double speed = trial % 3 == 0 ? 20.0 : trial % 3 == 1 ? 50.0 : 100.0;
    const Shot shot = randomShot(random, speed);
    MovingShape ball = test::sphereShape(trial % 2 == 0 ? 0.02 : 0.05);
    MovingShape cube = test::boxShape(Vector3d::Ones(), 0.02);
    const double radiusSum = ball.radius + cube.radius;
    if (shot.distance(0.0) < radiusSum + 2.0 * kMargin) continue;
    ball.position.col(0) = shot.from;
    ball.setMotion(shot.motion);
    const auto found = test::contactsOf(ball, cube, kMargin);
    const double minimum = shot.distance(shot.nearestTime());
    SCOPED_TRACE(testing::Message() << "trial " << trial << ", least " << minimum - radiusSum);
    if (minimum > radiusSum + 0.01 * kMargin) {  // within this distance a contact may be found
      EXPECT_TRUE(found.empty());
      ++misses;
    } else if (minimum < radiusSum) {
      ASSERT_EQ(found.size(), 1u);
      // contact is assumed a hundredth of the margin early, which for a glancing ball is earlier in time
      const Vector3d position = shot.from + found[0].time * shot.motion;
      EXPECT_NEAR(distanceToCube(position), radiusSum, 0.0101 * kMargin);
      EXPECT_LE(found[0].time, shot.timeOfImpact(radiusSum) + 1e-9);
      // an edge counts as nearest up to 0.01 rad beyond its faces' normals
      EXPECT_LT((found[0].normal - normalOfCube(position)).norm(), 0.0101);
      EXPECT_LT(found[0].normal.dot(shot.motion), 0.0);
      ++hits;
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 200);
}

TEST(SurfaceMotion, weightsAreThoseOfThePlaceOfImpact) {
  MovingShape ball = test::sphereShape(0.03), cube = test::boxShape(Vector3d::Ones(), 0.02);
  ball.position.col(0) = Vector3d(-0.5, 0.9, 0.05);
  ball.setMotion({0.6, -1.2, 0.3});  // through the cube and out below
  const auto found = test::contactsOf(ball, cube, kMargin);
  ASSERT_EQ(found.size(), 1u);
  // the ball touches the face after 0.35 m of 1.2 m, or a hundredth of the margin before
  EXPECT_NEAR(found[0].time, 0.35 / 1.2, 0.01 * kMargin / 1.2 + 1e-12);
  const Vector3d impactPoint = Vector3d(-0.5, 0.5, 0.05) + 0.35 / 1.2 * Vector3d(0.6, 0, 0.3);
  EXPECT_LT((test::placeAt(cube, found[0].b, found[0].time) - impactPoint).norm(), 0.01 * kMargin);
  EXPECT_LT((found[0].normal - Vector3d::UnitY()).norm(), 1e-12);
}

/// Only the relative motion matters, and the order of the two surfaces does not.
TEST(SurfaceMotion, movingTogetherChangesNothing) {
  std::mt19937 random(9);
  int hits = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Shot shot = randomShot(random, 50.0);
    MovingShape ball = test::sphereShape(0.04), cube = test::boxShape(Vector3d::Ones(), 0.02);
    ball.position.col(0) = shot.from;
    ball.setMotion(shot.motion);
    const auto reference = test::contactsOf(ball, cube, kMargin);
    const Vector3d commonMotion = 2.0 * test::randomVector(random);
    ball.setMotion(shot.motion + commonMotion);
    cube.setMotion(commonMotion);
    const auto found = test::contactsOf(cube, ball, kMargin);
    ASSERT_EQ(found.size(), reference.size()) << "trial " << trial;
    for (std::size_t i = 0; i < found.size(); ++i, ++hits) {
      EXPECT_NEAR(found[i].time, reference[i].time, 1e-9);
      EXPECT_LT((found[i].normal + reference[i].normal).norm(), 1e-6);
    }
  }
  EXPECT_GT(hits, 100);
}

/// A box that flies past a post has no contacts unless features come near enough, which is sampled at 400
/// times of the tick.
TEST(SurfaceMotion, passersByHaveNoContacts) {
  std::mt19937 random(10);
  int passed = 0;
  for (int trial = 0; trial < 400; ++trial) {
    MovingShape box = test::boxShape({0.5, 0.3, 0.4}, 0.01), post = test::boxShape({0.2, 2, 0.2}, 0.01);
    const Eigen::Affine3d start =
        Eigen::Translation3d(2.0 * test::randomVector(random)) * test::randomTurn(random);
    const Eigen::Affine3d end = Eigen::Translation3d(test::randomVector(random)) * start;
    const Points first = start * box.position, second = end * box.position;
    box.position = first;
    box.motion = second - first;
    double minimum = 1e300;
    for (int i = 0; i <= 400; ++i) {  // convex bodies: their distance is at least that along any direction
      const Points position = first + i / 400.0 * box.motion;
      minimum =
          std::min(minimum, std::max({position.row(0).minCoeff() - 0.1, -position.row(0).maxCoeff() - 0.1,
                                      position.row(2).minCoeff() - 0.1, -position.row(2).maxCoeff() - 0.1}));
    }
    if (minimum < 0.02 + kMargin + 0.005) continue;  // 0.005 m: half of the motion between samples
    EXPECT_TRUE(test::contactsOf(box, post, kMargin).empty()) << "trial " << trial << " " << minimum;
    ++passed;
  }
  EXPECT_GT(passed, 100);
}

/// A falling, rotated cube has a contact for each corner that reaches the floor.
TEST(SurfaceMotion, everyCornerThatLandsHasAContact) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 100; ++trial) {
    MovingShape cube = test::boxShape(Vector3d::Ones(), 0.02), floor = test::boxShape({20, 2, 20}, 0.0, true);
    cube.move(Eigen::Translation3d(0, 1.0 + 1.2, 0) * test::randomTurn(random));
    cube.setMotion({0.3, -0.6, 0.1});
    const auto found = test::contactsOf(cube, floor, kMargin);
    for (std::uint32_t i = 0; i < 8; ++i) {
      const double end = cube.position(1, i) + cube.motion(1, i) - 1.0 - 0.02;
      if (end > -1e-3 && end < 1e-3) continue;
      // corners that face up would reach the floor after all others, through the cube
      bool facesDown = false;
      for (const Triangle& t : cube.topology.triangles) {
        const Vector3d u = cube.position.col(t[1]) - cube.position.col(t[0]);
        const Vector3d n = u.cross(Vector3d(cube.position.col(t[2]) - cube.position.col(t[0])));
        if (t[0] == i || t[1] == i || t[2] == i) facesDown = facesDown || n.normalized().y() < -0.05;
      }
      if (end < 0.0 && !facesDown) continue;
      const auto touches = std::count_if(found.begin(), found.end(), [&](const SurfaceContact& c) {
        return c.a.kind == FeatureKind::OnVertex && c.a.feature == i;
      });
      EXPECT_EQ(touches, end < 0.0 ? 1 : 0) << "trial " << trial << " corner " << i << " " << end;
    }
  }
}

/// Two edges cross at high speed: the time and the points of impact have a closed form.
TEST(SurfaceMotion, crossingEdgesMeet) {
  MovingShape a = test::ropeShape(1, 1.0, 0.02), b = test::ropeShape(1, 1.0, 0.01);
  a.move(Eigen::Affine3d(Eigen::Translation3d(-0.3, 0.53, 0.0)));
  b.move(Eigen::Translation3d(0, 0, 0.4) * Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitY()));
  a.setMotion({0.0, -1.0, 0.2});
  const auto found = test::contactsOf(a, b, 0.001);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].time, 0.5, 1.1e-5);  // a hundredth of the margin early
  EXPECT_NEAR(found[0].a.weights[1], 0.3, 1e-12);
  EXPECT_NEAR(found[0].b.weights[1], 0.4 - 0.1, 1e-5);
  EXPECT_NEAR(found[0].gap, 0.5, 1e-12);
  a.setMotion({0.0, -0.499, 0.2});
  EXPECT_TRUE(test::contactsOf(a, b, 0.001).empty());
}

/// A cloth stops fast balls from either side.
TEST(SurfaceMotion, clothStopsShots) {
  std::mt19937 random(12);
  for (int trial = 0; trial < 200; ++trial) {
    MovingShape ball = test::sphereShape(0.02), cloth = test::clothShape(10, 0.1, 0.01);
    const double side = trial % 2 == 0 ? 1.0 : -1.0;
    Vector3d target = 0.45 * test::randomVector(random), from = test::randomVector(random);
    target.y() = 0.0;
    from.y() = side * (0.2 + std::abs(from.y()));
    ball.position.col(0) = from;
    ball.setMotion(1.5 * (target - from));
    const auto found = test::contactsOf(ball, cloth, kMargin);
    ASSERT_EQ(found.size(), 1u) << "trial " << trial;
    EXPECT_LT((found[0].normal - Vector3d(0, side, 0)).norm(), 1e-12);
    EXPECT_NEAR(from.y() + found[0].time * ball.motion(1, 0), side * 0.03, 0.01 * kMargin);
  }
}

}  // namespace
}  // namespace limber
