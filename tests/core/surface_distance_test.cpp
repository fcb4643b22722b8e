// SPDX-License-Identifier: Zlib
// The smallest gap of the contacts of convex bodies must be their distance.
#include "mesh/surface.h"
#include "support/moving_shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;
using test::MovingShape;

/// The distance of the nearest points of two hulls; `offset` is from b to a.
struct Nearest {
  Vector3d offset;
  double distance = 1e300;

  void update(const Vector3d& difference) {
    if (difference.norm() >= distance) return;
    offset = difference;
    distance = difference.norm();
  }
};

TriangleCorners cornersOf(const MovingShape& shape, const Triangle& t) {
  return {shape.position.col(t[0]), shape.position.col(t[1]), shape.position.col(t[2])};
}

Vector3d nearestOn(const TriangleCorners& t, const Vector3d& p) {
  const Vector3d w = nearestBarycentric(t, p);
  return w[0] * t[0] + w[1] * t[1] + w[2] * t[2];
}

/// Returns the offset between two edges. The distance of a point of one edge from the other edge is a convex
/// function of its position, minimised by ternary search.
Vector3d betweenEdges(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0, const Vector3d& b1) {
  const auto offset = [&](double s) -> Vector3d {
    const Vector3d p = a0 + s * (a1 - a0), along = b1 - b0;
    const double t = std::min(1.0, std::max(0.0, along.dot(p - b0) / along.squaredNorm()));
    return p - b0 - t * along;
  };
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 80; ++i) {
    const double lowThird = low + (high - low) / 3.0, highThird = high - (high - low) / 3.0;
    (offset(lowThird).norm() < offset(highThird).norm() ? high : low) =
        offset(lowThird).norm() < offset(highThird).norm() ? highThird : lowThird;
  }
  return offset(0.5 * (low + high));
}

Nearest nearestOf(const MovingShape& a, const MovingShape& b) {
  Nearest nearest;
  for (Eigen::Index i = 0; i < a.position.cols(); ++i)
    for (const Triangle& t : b.topology.triangles)
      nearest.update(a.position.col(i) - nearestOn(cornersOf(b, t), a.position.col(i)));
  for (Eigen::Index i = 0; i < b.position.cols(); ++i)
    for (const Triangle& t : a.topology.triangles)
      nearest.update(nearestOn(cornersOf(a, t), b.position.col(i)) - b.position.col(i));
  for (const Edge& e : a.topology.edges)
    for (const Edge& f : b.topology.edges)
      nearest.update(betweenEdges(a.position.col(e[0]), a.position.col(e[1]), b.position.col(f[0]),
                                  b.position.col(f[1])));
  return nearest;
}

double smallestGap(const std::vector<SurfaceContact>& found) {
  double smallest = 1e300;
  for (const SurfaceContact& c : found) smallest = std::min(smallest, c.gap);
  return smallest;
}

/// The hulls are moved to a distance between 2 cm and the sum of the radii and the margin. A vertex outside a
/// triangle by 1e-4 of its size counts as above it, so its height is less than its distance by up to (2e-4
/// m)^2 / 2 / 2 cm.
TEST(SurfaceDistance, smallestGapIsThatOfTheHulls) {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> fraction(0.34, 0.99);
  for (int trial = 0; trial < 400; ++trial) {
    MovingShape a = trial % 2 ? test::boxShape({1, 0.6, 0.8}, 0.02) : test::hullShape(10, 0.02, random);
    MovingShape b = trial % 3 ? test::hullShape(8, 0.03, random) : test::boxShape({0.2, 1.5, 0.9}, 0.03);
    a.move(Eigen::Translation3d(3.0 * (test::randomTurn(random) * Vector3d::UnitX())) *
           test::randomTurn(random));
    b.move(test::randomTurn(random));
    const Nearest before = nearestOf(a, b);
    // moved along the line between the nearest points these stay the nearest, because the bodies are convex
    const double margin = 0.01, distance = fraction(random) * (0.05 + margin);
    a.move(Eigen::Affine3d(Eigen::Translation3d(before.offset.normalized() * (distance - before.distance))));
    const auto found = test::contactsOf(a, b, margin);
    ASSERT_FALSE(found.empty()) << "trial " << trial;
    EXPECT_NEAR(smallestGap(found), distance - 0.05, 1e-6) << "trial " << trial;
  }
}

TEST(SurfaceDistance, hullsThatAreFartherHaveNoContacts) {
  std::mt19937 random(14);
  for (int trial = 0; trial < 200; ++trial) {
    MovingShape a = test::hullShape(10, 0.02, random), b = test::hullShape(8, 0.03, random);
    a.move(Eigen::Affine3d(Eigen::Translation3d(3.0 * (test::randomTurn(random) * Vector3d::UnitX()))));
    const Nearest before = nearestOf(a, b);
    a.move(Eigen::Affine3d(Eigen::Translation3d(before.offset.normalized() * (0.061 - before.distance))));
    EXPECT_TRUE(test::contactsOf(a, b, 0.01).empty()) << "trial " << trial;
  }
}

/// Hulls that move towards each other touch when their distance has fallen to the sum of the radii.
TEST(SurfaceDistance, hullsMeetInTime) {
  std::mt19937 random(15);
  for (int trial = 0; trial < 150; ++trial) {
    MovingShape a = test::hullShape(10, 0.02, random), b = test::hullShape(8, 0.03, random);
    a.move(Eigen::Affine3d(Eigen::Translation3d(2.2 * (test::randomTurn(random) * Vector3d::UnitX()))));
    const Vector3d motion = -a.position.rowwise().mean() + 0.8 * test::randomVector(random);
    // finds the time of impact; the distance is a convex function of time
    const Points start = a.position;
    const auto distanceAt = [&](double time) {
      a.position = start.colwise() + time * motion;
      return nearestOf(a, b).distance;
    };
    double impactTime = -1.0;
    for (double time = 0.0;
         time <= 1.0 && impactTime < 0.0;) {  // safe steps: the distance shrinks no faster than the motion
      const double gap = distanceAt(time) - 0.05;
      if (gap < 1e-5) impactTime = time;
      time += std::max(gap, 1e-6) / motion.norm();
      if (gap > 0.0 && gap < 1e-3 && motion.norm() * (1.0 - time) < gap) break;
    }
    a.position = start;
    a.setMotion(motion);
    const auto found = test::contactsOf(a, b, 0.001);
    double first = 1e300;
    for (const SurfaceContact& c : found) first = std::min(first, c.time);
    if (impactTime >= 0.0) {
      // features touch a hundredth of the margin early; the slope of the distance is at least a tenth of the
      // motion
      EXPECT_NEAR(first, impactTime, 1e-5 / (0.05 * motion.norm())) << "trial " << trial;
    } else {
      EXPECT_TRUE(found.empty()) << "trial " << trial;
    }
  }
}

}  // namespace
}  // namespace limber
