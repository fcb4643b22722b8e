// SPDX-License-Identifier: Zlib
// Contacts of a surface with itself; order and memory use of every search.
#include "support/moving_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace limber {
namespace {

using Eigen::Vector3d;
using test::MovingShape;

std::vector<SurfaceContact> selfContacts(MovingShape& shape, double margin) {
  ContactSearch search;
  std::vector<SurfaceContact> found;
  findSelfContacts(shape.surface(), margin, search, found);
  return found;
}

TEST(SelfContacts, noneAtRest) {
  MovingShape cloth = test::clothShape(10, 0.05, 0.01), rope = test::ropeShape(20, 0.05, 0.02);
  EXPECT_TRUE(selfContacts(cloth, 0.003).empty());
  EXPECT_TRUE(selfContacts(rope, 0.006).empty());
  // segments shorter than the rope's thickness
  MovingShape thick = test::ropeShape(40, 0.01, 0.03);
  EXPECT_TRUE(selfContacts(thick, 0.001).empty());
}

/// The diagonals of a square, also with a corner moved so that they cross at another point.
TEST(SelfContacts, springsThatCrossAtRestDoNotTouch) {
  Points square(3, 4);
  square << 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 1, 1;
  SurfaceFeatures diagonals;
  diagonals.segments = {{0, 2}, {1, 3}};
  MovingShape shape = test::makeShape(square, diagonals, 0.01);
  EXPECT_TRUE(selfContacts(shape, 0.003).empty());
  shape.position.col(2) = Vector3d(0.7, 0, 0.7);
  EXPECT_TRUE(selfContacts(shape, 0.003).empty());
}

/// A cloth folded over: every point of the upper half rests on the lower one.
TEST(SelfContacts, foldedClothLiesOnItself) {
  MovingShape cloth = test::clothShape(10, 0.05, 0.01);
  for (Eigen::Index i = 0; i < cloth.position.cols(); ++i) {
    auto p = cloth.position.col(i);
    if (p.x() > 0.02) p = Vector3d(0.021 - p.x(), 0.02, p.z());
  }
  const auto found = selfContacts(cloth, 0.003);
  std::set<std::uint32_t> upper;
  for (const SurfaceContact& c : found) {
    EXPECT_NEAR(std::abs(c.normal.y()), 1.0, 1e-9);
    EXPECT_NEAR(c.gap, 0.0, 1e-12);
    for (const SurfacePoint* point : {&c.a, &c.b})
      if (point->kind == FeatureKind::OnVertex && cloth.position(1, point->feature) > 0.01)
        upper.insert(point->feature);
  }
  // rows 6 to 10 are above; those next to the fold are connected to the lower half by one edge
  for (std::uint32_t row = 8; row <= 10; ++row)
    for (std::uint32_t k = 0; k <= 10; ++k) EXPECT_TRUE(upper.count(row * 11 + k)) << row << " " << k;
}

/// The layers of a spiral ramp all face up, like a flat cloth, and are near where they were not at rest.
TEST(SelfContacts, layersOfASpiralRampLieOnEachOther) {
  MovingShape cloth = test::clothShape(40, 0.05, 0.005);
  for (Eigen::Index i = 0; i < cloth.position.cols(); ++i) {
    const Vector3d flat = cloth.position.col(i);
    const double angle = 2.0 * M_PI * flat.x(), radius = 0.16 + 0.05 * flat.z();
    cloth.position.col(i) = Vector3d(radius * std::cos(angle), 0.011 * flat.x(), radius * std::sin(angle));
  }
  const auto found = selfContacts(cloth, 0.003);
  std::set<std::uint32_t> touching;
  for (const SurfaceContact& c : found)
    for (const SurfacePoint* point : {&c.a, &c.b})
      if (point->kind == FeatureKind::OnVertex) touching.insert(point->feature);
  EXPECT_GE(touching.size(), 40 * 41);  // of 41 x 41
}

/// A cloth folded like a Z over its first row of cells, which are ten times as long as the others.
TEST(SelfContacts, aSmallPartFoldedTwiceLiesOnALargeOne) {
  MovingShape cloth = test::clothShape(10, 0.05, 0.002);
  SurfaceTopology& t = cloth.topology;
  const auto rowOf = [&](Eigen::Index i) { return std::lround((cloth.position(0, i) + 0.25) / 0.05); };
  for (Eigen::Index i = 0; i < cloth.position.cols(); ++i) {
    const auto row = static_cast<double>(rowOf(i));
    const double z = cloth.position(2, i), stretched = row > 0 ? 0.5 + 0.05 * (row - 1) : 0.0;
    t.rest.col(i) = Vector3d(stretched, 0.0, z);
    // back from row 1 to row 3, then forth again
    const double back = row <= 1 ? stretched : 0.5 - 0.05 * (row - 1);
    cloth.position.col(i) = Vector3d(row <= 3 ? back : 0.4 + 0.05 * (row - 3),
                                     row <= 1   ? 0.0
                                     : row <= 3 ? 0.005
                                                : 0.01,
                                     z);
  }
  const auto found = selfContacts(cloth, 0.003);
  const auto isOnFirstCells = [&](const SurfacePoint& point) {
    return point.kind == FeatureKind::OnTriangle &&
           std::any_of(point.points.begin(), point.points.end(),
                       [&](std::uint32_t i) { return t.rest(0, i) == 0.0; });
  };
  EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const SurfaceContact& c) {
    return isOnFirstCells(c.a) || isOnFirstCells(c.b);
  }));
}

TEST(SelfContacts, knottedRopeTouchesAtItsCrossing) {
  MovingShape rope = test::ropeShape(40, 0.05, 0.02);
  for (int i = 0; i <= 40; ++i) {  // a loop whose ends cross at right angles at the origin
    const double t = (i - 20) / 20.0 * 0.75 * M_PI;
    rope.position.col(i) = Vector3d(std::sin(2.0 * t), 0.021 * t / (0.5 * M_PI), std::cos(t));
  }
  const auto found = selfContacts(rope, 0.006);
  ASSERT_FALSE(found.empty());
  for (const SurfaceContact& c : found) {
    EXPECT_LT(test::placeAt(rope, c.a, 0.0).head<1>().norm(), 0.1);
    EXPECT_NEAR(c.gap, 0.002, 0.001);
    EXPECT_GT(std::abs(c.normal.y()), 0.99);
  }
}

bool mayTouchItself(MovingShape& shape, double displacement) {
  ContactSearch search;
  std::vector<SurfaceContact> found;
  return mayTouchItself(shape.surface(), 0.003, displacement, 0.0, search, found);
}

/// Parts of a flag move fast, but next to each other alike.
TEST(SelfContacts, aFlagThatFlapsDoesNotTouchItself) {
  MovingShape flag = test::clothShape(10, 0.05, 0.002);
  for (Eigen::Index i = 0; i < flag.position.cols(); ++i)
    flag.motion.col(i) =
        Vector3d(0.2, 0.06 * std::sin(12.0 * flag.position(0, i)), 0.3 * flag.position(0, i));
  EXPECT_FALSE(mayTouchItself(flag, 0.4));
}

/// The upper half of a folded cloth comes down on the lower one, or may if it falls by a quarter more than
/// expected.
TEST(SelfContacts, aFoldThatClosesMayTouch) {
  for (const double motion : {0.0, -0.05, -0.07, -0.1}) {
    MovingShape cloth = test::clothShape(10, 0.05, 0.002);
    for (Eigen::Index i = 0; i < cloth.position.cols(); ++i) {
      if (cloth.position(0, i) < 0.02) continue;
      cloth.position.col(i) = Vector3d(0.021 - cloth.position(0, i), 0.1, cloth.position(2, i));
      cloth.motion.col(i) = Vector3d(0.0, motion, 0.0);
    }
    const double needed = 0.1 - 2.0 * cloth.radius - 0.003;
    EXPECT_EQ(mayTouchItself(cloth, -motion), -1.25 * motion >= needed) << motion;
  }
}

TEST(ContactSearch, isReproducible) {
  std::mt19937 random(16);
  MovingShape a = test::ballShape(3, 0.01), b = test::hullShape(12, 0.02, random);
  a.move(Eigen::Affine3d(Eigen::Translation3d(0.4, 1.6, 0.3)));
  for (Eigen::Index i = 0; i < a.motion.cols(); ++i)
    a.motion.col(i) = Vector3d(0, -0.5, 0) + 0.02 * test::randomVector(random);
  ContactSearch search;
  std::vector<SurfaceContact> first, second;
  findSurfaceContacts(a.surface(), b.surface(), 0.006, search, first);
  std::vector<SurfaceContact> other;
  findSelfContacts(a.surface(), 0.006, search, other);
  findSurfaceContacts(a.surface(), b.surface(), 0.006, search, second);
  ASSERT_EQ(first.size(), second.size());
  ASSERT_FALSE(first.empty());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].key, second[i].key);
    EXPECT_EQ(first[i].gap, second[i].gap);
  }
}

/// Arrays that are large enough are not reallocated.
TEST(ContactSearch, keepsItsArrays) {
  MovingShape a = test::boxShape(Vector3d::Ones(), 0.02), b = test::boxShape(Vector3d::Ones(), 0.02);
  a.move(Eigen::Affine3d(Eigen::Translation3d(0.2, 1.0, 0.1)));
  ContactSearch search;
  std::vector<SurfaceContact> found;
  findSurfaceContacts(a.surface(), b.surface(), 0.006, search, found);
  const void* before[] = {search.near.data(),        search.waiting.data(), search.candidates.data(),
                          search.penetrating.data(), found.data(),          a.boxes.nodes.data()};
  a.move(Eigen::Affine3d(Eigen::Translation3d(0.001, 0.001, 0)));
  findSurfaceContacts(a.surface(), b.surface(), 0.006, search, found);
  const void* after[] = {search.near.data(),        search.waiting.data(), search.candidates.data(),
                         search.penetrating.data(), found.data(),          a.boxes.nodes.data()};
  EXPECT_TRUE(std::equal(before, before + 6, after));
  EXPECT_FALSE(found.empty());
}

}  // namespace
}  // namespace limber
