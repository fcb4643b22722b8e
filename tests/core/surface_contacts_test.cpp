// SPDX-License-Identifier: Zlib
// Surfaces that rest on each other: the contacts found, the loads that they can carry, and contacts from the
// cache.
#include "collide/surface_contacts.h"

#include "support/moving_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace limber {
namespace {

using Eigen::Affine3d;
using Eigen::AngleAxisd;
using Eigen::Translation3d;
using Eigen::Vector3d;
using test::kMargin;
using test::kRadius;
using test::kRounding;
using test::MovingShape;

MovingShape cube() { return test::boxShape(Vector3d::Ones(), kRadius); }
Affine3d shift(double x, double y, double z) { return Affine3d(Translation3d(x, y, z)); }

void expectValid(const std::vector<SurfaceContact>& found, const MovingShape& a, const MovingShape& b) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    const SurfaceContact& c = found[i];
    if (i > 0) {
      EXPECT_LT(found[i - 1].key, c.key);
    }
    EXPECT_NEAR(c.normal.norm(), 1.0, 1e-14);
    for (const SurfacePoint* point : {&c.a, &c.b}) {
      EXPECT_NEAR(point->weights.sum(), 1.0, 1e-14);
      EXPECT_GE(point->weights.minCoeff(), 0.0);
    }
    const Vector3d difference = test::placeAt(a, c.a, 0.0) - test::placeAt(b, c.b, 0.0);
    EXPECT_NEAR(c.gap, c.normal.dot(difference) - a.radius - b.radius, kRounding);
  }
}

/// Expects upward normals and the given gap, and that the contacts can carry a load at `weight`: seen from
/// above it is a convex combination of the contact points.
void expectSupports(const std::vector<SurfaceContact>& found, const MovingShape& a, double gap,
                    const Vector3d& weight) {
  ASSERT_GE(found.size(), 3u);
  for (const SurfaceContact& c : found) {
    EXPECT_LT((c.normal - Vector3d::UnitY()).norm(), 1e-9) << c.normal.transpose();
    EXPECT_NEAR(c.gap, gap, kRounding);
  }
  for (int i = 0; i < 64; ++i) {  // no line through the weight has all contacts on one side
    const Vector3d side(std::cos(0.1 * i), 0.0, std::sin(0.1 * i));
    double maxSide = -1.0;
    for (const SurfaceContact& c : found)
      maxSide = std::max(maxSide, side.dot(test::placeAt(a, c.a, 0.0) - weight));
    EXPECT_GT(maxSide, 0.01) << "falls over towards " << side.transpose();
  }
}

TEST(SurfaceContacts, boxLiesOnAFace) {
  MovingShape box = test::boxShape({0.2, 0.1, 0.3}, 0.0, true), soft = cube();
  box.move(shift(0.1, 0.57, 0.05));
  const auto found = test::contactsOf(box, soft, kMargin);
  expectValid(found, box, soft);
  expectSupports(found, box, 0.0, {0.1, 0, 0.05});
  EXPECT_EQ(found.size(), 4u);
}

TEST(SurfaceContacts, softPointsUnderABoxTouchItsFace) {
  MovingShape cloth = test::clothShape(10, 0.1, kRadius), box = test::boxShape({0.35, 0.2, 0.35}, 0.0, true);
  box.move(shift(0, 0.12, 0));
  const auto found = test::contactsOf(box, cloth, kMargin);
  expectValid(found, box, cloth);
  expectSupports(found, box, 0.0, {0, 0, 0});
  // 3 x 3 points of the cloth, 4 corners of the box, and the crossings of the box's edges with those of the
  // cloth: 3 lines and 3 diagonals each
  const auto points = std::count_if(
      found.begin(), found.end(), [](const SurfaceContact& c) { return c.b.kind == FeatureKind::OnVertex; });
  const auto crossings = std::count_if(
      found.begin(), found.end(), [](const SurfaceContact& c) { return c.b.kind == FeatureKind::OnEdge; });
  EXPECT_EQ(points, 9);
  EXPECT_EQ(crossings, 24);
  EXPECT_EQ(found.size(), 37u);
}

TEST(SurfaceContacts, cubesLieFlush) {
  struct Pose {
    double x, z, angle;
  };
  for (const Pose& pose :
       {Pose{0, 0, 0}, Pose{0.2, 0, 0}, Pose{0.2, 0.1, 0}, Pose{0, 0, 0.4}, Pose{0.2, 0.1, 0.4},
        Pose{0.001, 0, 0}, Pose{1e-5, -1e-5, 0}, Pose{0, 0, 1e-4}, Pose{0.1, 0.1, 3e-3}}) {
    SCOPED_TRACE(testing::Message() << pose.x << " " << pose.z << " " << pose.angle);
    MovingShape upper = cube(), lower = cube();
    upper.move(Translation3d(pose.x, 1.04, pose.z) * Affine3d(AngleAxisd(pose.angle, Vector3d::UnitY())));
    const auto found = test::contactsOf(upper, lower, kMargin);
    expectValid(found, upper, lower);
    expectSupports(found, upper, 0.0, {pose.x, 0, pose.z});
    EXPECT_LE(found.size(), 12u);
  }
}

/// Returns the shape with so many unused points that nothing is left out along the line between surfaces.
MovingShape withUnusedPoints(MovingShape shape) {
  const Eigen::Index used = shape.position.cols(), all = used + 200;
  for (Points* array : {&shape.position, &shape.motion}) {
    array->conservativeResize(3, all);
    array->rightCols(all - used).setZero();
  }
  return shape;
}

TEST(SurfaceContacts, areCompleteAlongTheLineBetweenSurfaces) {
  std::mt19937 random(5);
  const std::vector<MovingShape> shapes = {cube(),
                                           test::boxShape({0.2, 1.0, 0.6}, 0.0, true),
                                           test::ballShape(1, kRadius),
                                           test::hullShape(20, 0.0, random),
                                           test::ropeShape(6, 0.2, kRadius),
                                           test::clothShape(5, 0.2, kRadius),
                                           test::sphereShape(0.4)};
  std::size_t contacts = 0, empty = 0;
  for (int i = 0; i < 3000; ++i) {
    MovingShape a = shapes[random() % shapes.size()], b = shapes[random() % shapes.size()];
    a.move(test::randomTurn(random));
    b.move(Translation3d(1.3 * test::randomVector(random)) * test::randomTurn(random));
    const double speed = 0.1 * static_cast<double>(random() % 4);
    a.setMotion(speed * test::randomVector(random) + Vector3d(0.0, -1.0, 0.0));
    b.setMotion(speed * test::randomVector(random) + Vector3d(0.0, -1.0, 0.0));
    MovingShape all = withUnusedPoints(a);
    const auto found = test::contactsOf(a, b, kMargin), wanted = test::contactsOf(all, b, kMargin);
    SCOPED_TRACE(i);
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t c = 0; c < found.size(); ++c) {
      EXPECT_EQ(found[c].key, wanted[c].key);
      EXPECT_EQ(found[c].gap, wanted[c].gap);
      EXPECT_EQ(found[c].normal, wanted[c].normal);
    }
    contacts += found.size();
    empty += found.empty();
  }
  EXPECT_GT(contacts, 3000u);
  EXPECT_GT(empty, 500u);
}

/// The cubes overlap slightly, as after a hard landing.
TEST(SurfaceContacts, cubesInEachOtherPartUpward) {
  for (const double angle : {0.0, 0.4}) {
    MovingShape upper = cube(), lower = cube();
    upper.move(Translation3d(0.1, 0.99, 0.05) * Affine3d(AngleAxisd(angle, Vector3d::UnitY())));
    expectSupports(test::contactsOf(upper, lower, kMargin), upper, -0.05, {0.1, 0, 0.05});
  }
}

TEST(SurfaceContacts, railsCarryACube) {
  MovingShape upper = cube(),
              rails[2] = {test::boxShape({0.1, 0.1, 3}, 0.0, true), test::boxShape({0.1, 0.1, 3}, 0.0, true)};
  upper.move(shift(0, 0.57, 0));
  std::vector<SurfaceContact> all;
  for (int i = 0; i < 2; ++i) {
    rails[i].move(shift(i == 0 ? -0.3 : 0.3, 0, 0));
    const auto found = test::contactsOf(upper, rails[i], kMargin);
    EXPECT_EQ(found.size(), 4u);
    for (const SurfaceContact& c : found) {
      EXPECT_EQ(c.a.kind, FeatureKind::OnEdge);
      EXPECT_EQ(c.b.kind, FeatureKind::OnEdge);
    }
    all.insert(all.end(), found.begin(), found.end());
  }
  expectSupports(all, upper, 0.0, {0, 0, 0});
}

/// Each fold of the sheet is nearest to the ridge if the sheet bends there. So all of them have contacts
/// before it bends.
TEST(SurfaceContacts, aSheetMeetsARidgeWithAllItsFolds) {
  MovingShape ridge = test::boxShape({0.2, 0.2, 3}, 0.0, true);
  ridge.move(Translation3d(0.03, -kRadius - 0.2 * std::sqrt(0.5), 0) *
             Affine3d(AngleAxisd(M_PI / 4, Vector3d::UnitZ())));
  for (const double lift : {0.0, 0.003, -0.003}) {
    MovingShape cloth = test::clothShape(4, 0.1, kRadius);
    for (Eigen::Index i = 0; i < cloth.position.cols(); i += 2)  // every second point of each line
      if (cloth.position(0, i) > 0.05) cloth.position(1, i) += lift;
    const auto found = test::contactsOf(cloth, ridge, kMargin);
    expectValid(found, cloth, ridge);
    // 5 edges across the ridge, and the diagonals between them
    EXPECT_EQ(found.size(), 9u) << lift;
    for (const SurfaceContact& c : found) {
      EXPECT_EQ(c.a.kind, FeatureKind::OnEdge);
      EXPECT_GT(c.normal.y(), 0.999);
    }
  }
}

/// A ridge on the diagonal of a face, which it presses flat: the contact of the two edges lasts as long as it
/// bears, also on a slightly concave face. Other edges in flat faces have no contacts.
TEST(SurfaceContacts, anEdgePressedFlatStaysInContact) {
  const auto contactsAt = [](double height, const std::vector<std::uint64_t>& bearing) {
    MovingShape ridge = test::boxShape({0.2, 0.2, 0.6}, 0.0), lower = cube();
    ridge.move(Translation3d(0.03, 0.52 + 0.2 * std::sqrt(0.5), 0) *
               Affine3d(AngleAxisd(M_PI / 4, Vector3d::UnitZ())));
    for (const Eigen::Index end : {2, 7}) lower.position(1, end) += height;  // of the diagonal
    auto found = test::contactsOf(ridge, lower, kMargin, bearing);
    expectValid(found, ridge, lower);
    const auto isOther = [](const SurfaceContact& c) { return c.a.kind != FeatureKind::OnEdge; };
    found.erase(std::remove_if(found.begin(), found.end(), isOther), found.end());
    return found;
  };
  const auto raised = contactsAt(0.01, {});
  ASSERT_EQ(raised.size(), 1u);
  const std::vector<std::uint64_t> bearing = {raised[0].key};
  for (const double height : {0.001, 0.0, -0.001}) {
    EXPECT_TRUE(contactsAt(height, {}).empty()) << height;
    const auto flat = contactsAt(height, bearing);
    ASSERT_EQ(flat.size(), 1u) << height;
    EXPECT_EQ(flat[0].key, bearing[0]);
    EXPECT_NEAR(flat[0].gap, -height, kRounding);
    EXPECT_GT(flat[0].normal.y(), 0.999);
  }
  EXPECT_TRUE(contactsAt(-0.02, bearing).empty()) << "the face is concave";
}

/// A cloth on a face, whose diagonals cross: the contact of these lasts while it bears, until the face is
/// flat, too. Then the corners carry.
TEST(SurfaceContacts, edgesOfFlatFacesThatLieOnEachOtherHaveNone) {
  const auto edgesAt = [](double height, const std::vector<std::uint64_t>& bearing) {
    MovingShape upper = test::clothShape(1, 0.6, kRadius), lower = cube();
    upper.move(Translation3d(0.02, 0.5 + 2.0 * kRadius + height, 0.01) *
               Affine3d(AngleAxisd(0.3, Vector3d::UnitY())));
    for (const Eigen::Index end : {2, 7}) lower.position(1, end) += height;  // of the diagonal
    auto found = test::contactsOf(upper, lower, kMargin, bearing);
    expectValid(found, upper, lower);
    std::vector<std::uint64_t> keys;
    for (const SurfaceContact& c : found) {
      if (c.a.kind != FeatureKind::OnEdge || c.b.kind != FeatureKind::OnEdge) continue;
      const Vector3d along = upper.position.col(c.a.points[0]) - upper.position.col(c.a.points[1]);
      if (along.norm() > 0.7) keys.push_back(c.key);  // a diagonal, not one of the rim's edges
    }
    return keys;
  };
  const std::vector<std::uint64_t> raised = edgesAt(0.01, {});
  ASSERT_FALSE(raised.empty());
  EXPECT_EQ(edgesAt(0.003, raised), raised) << "one of the faces is not flat";
  for (const double height : {2e-4, 0.0, -2e-4}) EXPECT_TRUE(edgesAt(height, raised).empty()) << height;
}

/// Two edges that a load has pushed through each other, farther than the margin between their boxes, which
/// have no height where the edges are along world axes.
TEST(SurfaceContacts, edgesUnderLoadAreFoundInAnyDirection) {
  for (const double angle : {0.0, 0.7}) {
    const Affine3d turn(AngleAxisd(angle, Vector3d(1, 0.3, 0.6).normalized()));
    const auto keyOfEdges = [&](double depth, const std::vector<std::uint64_t>& bearing) {
      MovingShape upper = test::boxShape({0.2, 0.2, 0.6}, 0.0), lower = upper;
      const double half = 0.2 * std::sqrt(0.5);
      lower.move(turn * Translation3d(0, -half, 0) * Affine3d(AngleAxisd(M_PI / 4, Vector3d::UnitZ())));
      upper.move(turn * Translation3d(0, half - depth, 0) *
                 Affine3d(AngleAxisd(M_PI / 2, Vector3d::UnitY())) *
                 Affine3d(AngleAxisd(M_PI / 4, Vector3d::UnitZ())));
      for (const SurfaceContact& c : test::contactsOf(upper, lower, kMargin, bearing))
        if (c.a.kind == FeatureKind::OnEdge && c.b.kind == FeatureKind::OnEdge) return c.key;
      return std::uint64_t{0};
    };
    const std::uint64_t key = keyOfEdges(0.0, {});
    ASSERT_NE(key, 0u);
    for (const double depth : {0.5, 2.0, 4.0}) EXPECT_EQ(keyOfEdges(depth * kMargin, {key}), key) << depth;
  }
}

/// Over a ridge whose fold is small beside that of an edge, the feet of the ball's centre are beside both
/// faces: the ball touches the ridge itself.
TEST(SurfaceContacts, aBallTouchesARidgeHoweverFlat) {
  const double r = 0.3, radiusSum = r + kRadius;
  for (const double height : {0.01, 0.003, 0.001, 1e-4, 1e-5, 1e-6, 0.0}) {
    MovingShape ball = test::sphereShape(r), soft = cube();
    for (const Eigen::Index end : {2, 7}) soft.position(1, end) += height;  // of the diagonal of the top
    const Vector3d a = soft.position.col(2), b = soft.position.col(7), foot = 0.6 * a + 0.4 * b;
    ball.position.col(0) = foot + Vector3d(0, radiusSum + 0.001, 0);
    const auto found = test::contactsOf(ball, soft, kMargin);
    ASSERT_EQ(found.size(), 1u) << height;
    EXPECT_NEAR(found[0].gap, 0.001, 1e-4 * height + kRounding) << height;
    EXPECT_GT(std::abs(found[0].normal.y()), 0.9999);
  }
}

/// In a shallow dent a ball touches both faces, since each may give way by itself; points of the usual radius
/// touch one.
TEST(SurfaceContacts, aBallInAShallowDentTouchesBothFaces) {
  for (const double r : {0.3, 0.005}) {
    MovingShape ball = test::sphereShape(r), soft = cube();
    for (const Eigen::Index end : {2, 7}) soft.position(1, end) -= 0.02;  // of the diagonal of the top
    const Vector3d foot = 0.5 * (soft.position.col(2) + soft.position.col(7));
    ball.position.col(0) = foot + Vector3d(0, r + kRadius + 0.002, 0);
    const auto found = test::contactsOf(ball, soft, 0.01);
    ASSERT_EQ(found.size(), r > 0.1 ? 2u : 1u) << r;
    for (const SurfaceContact& c : found) EXPECT_EQ(c.b.kind, FeatureKind::OnTriangle);
  }
}

/// A ball above the edge between two faces, above a corner, and above faces.
TEST(SurfaceContacts, ballTouchesWhatIsNearest) {
  const double r = 0.05, radiusSum = r + kRadius;
  struct Case {
    Vector3d foot, normal;
    FeatureKind kind;
  };
  for (const Case& expected : {Case{{0.5, 0.5, 0.2}, Vector3d(1, 2, 0).normalized(), FeatureKind::OnEdge},
                               Case{{0.5, -0.5, 0.5}, Vector3d(1, -1, 2).normalized(), FeatureKind::OnVertex},
                               Case{{0.5, 0.2, 0.3}, Vector3d(1, 0, 0), FeatureKind::OnTriangle},
                               Case{{0.5, 0.2, 0.2}, Vector3d(1, 0, 0), FeatureKind::OnTriangle}}) {
    MovingShape ball = test::sphereShape(r), soft = cube();
    ball.position.col(0) = expected.foot + (radiusSum + 0.001) * expected.normal;
    const auto found = test::contactsOf(ball, soft, kMargin);
    ASSERT_EQ(found.size(), 1u) << expected.foot.transpose();
    expectValid(found, ball, soft);
    EXPECT_EQ(found[0].b.kind, expected.kind);
    EXPECT_LT((found[0].normal - expected.normal).norm(), kRounding);
    EXPECT_NEAR(found[0].gap, 0.001, kRounding);
    EXPECT_LT((test::placeAt(soft, found[0].b, 0) - expected.foot).norm(), kRounding);
    const auto reverse = test::contactsOf(soft, ball, kMargin);
    ASSERT_EQ(reverse.size(), 1u);
    EXPECT_LT((reverse[0].normal + expected.normal).norm(), kRounding);
  }
}

TEST(SurfaceContacts, ropesTouchAcrossAndEndToEnd) {
  MovingShape a = test::ropeShape(3, 0.3, kRadius), across = test::ropeShape(4, 0.25, kRadius);
  across.move(Translation3d(0.4, 0.041, 0.6) * Affine3d(AngleAxisd(0.5 * M_PI, Vector3d::UnitY())));
  auto found = test::contactsOf(a, across, kMargin);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].a.kind, FeatureKind::OnEdge);
  EXPECT_EQ(found[0].a.feature, 1u);
  EXPECT_LT((found[0].normal + Vector3d::UnitY()).norm(), kRounding);
  EXPECT_NEAR(found[0].gap, 0.001, kRounding);

  MovingShape behind = test::ropeShape(3, 0.3, kRadius);
  behind.move(shift(0.9 + 0.042, 0, 0));
  found = test::contactsOf(a, behind, kMargin);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].a.kind, FeatureKind::OnVertex);
  EXPECT_EQ(found[0].b.kind, FeatureKind::OnVertex);
  EXPECT_LT((found[0].normal + Vector3d::UnitX()).norm(), kRounding);
  EXPECT_NEAR(found[0].gap, 0.002, kRounding);
}

/// Only rounding decides on which side of the other rope each one is, so the normal must follow from their
/// motion.
TEST(SurfaceContacts, ropesThatCrossInOnePlacePartAgainstTheirMotion) {
  for (const double offset : {-1e-16, 0.0, 1e-16}) {
    MovingShape a = test::ropeShape(1, 1.0, 0.02), b = test::ropeShape(1, 1.0, 0.02);
    a.position.colwise() -= Vector3d(0.5, -offset, 0);
    b.position.col(0) = Vector3d(0.1, 0, -0.5);
    b.position.col(1) = Vector3d(0.1, 0, 0.5);
    for (const double velocity : {-1e-3, 1e-3}) {
      a.setMotion(Vector3d(0, velocity, 0));
      const auto found = test::contactsOf(a, b, test::kMargin);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_NEAR(found[0].normal.y(), velocity > 0.0 ? -1.0 : 1.0, 1e-9) << offset << ", " << velocity;
    }
  }
}

TEST(SurfaceContacts, ropeHangsOverTheEdgeOfABox) {
  MovingShape rope = test::ropeShape(1, 1.0, kRadius), box = test::boxShape(Vector3d::Ones(), 0.0, true);
  rope.move(Translation3d(0.5, 0.5, 0.1) * Affine3d(AngleAxisd(-0.25 * M_PI, Vector3d::UnitZ())) *
            shift(-0.5, kRadius, 0));
  const auto found = test::contactsOf(rope, box, kMargin);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].b.kind, FeatureKind::OnEdge);
  EXPECT_LT((found[0].normal - Vector3d(1, 1, 0).normalized()).norm(), kRounding);
  EXPECT_NEAR(found[0].gap, 0.0, kRounding);
}

/// Every point of a cloth on a thick body without triangles has a contact.
TEST(SurfaceContacts, clothLiesOnABall) {
  MovingShape cloth = test::clothShape(8, 0.05, 0.01), ball = test::sphereShape(0.5);
  const double radiusSum = 0.51;
  for (Eigen::Index i = 0; i < cloth.position.cols(); ++i)
    cloth.position.col(i) = radiusSum * (cloth.position.col(i) + Vector3d(0, 0.5, 0)).normalized();
  const auto found = test::contactsOf(cloth, ball, 0.002);
  std::vector<int> uses(static_cast<std::size_t>(cloth.position.cols()));
  for (const SurfaceContact& c : found) {
    if (c.a.kind == FeatureKind::OnVertex) ++uses[c.a.feature];
    EXPECT_LE(std::abs(c.gap), 0.002);
  }
  for (std::size_t i = 0; i < uses.size(); ++i) EXPECT_EQ(uses[i], 1) << "point " << i;
}

/// A cloth pushes objects to the side on which they are, a closed surface always outward.
TEST(SurfaceContacts, sidesOfCloth) {
  for (const double y : {0.04, -0.04}) {
    MovingShape cloth = test::clothShape(4, 0.3, 0.01), ball = test::sphereShape(0.03);
    ball.position.col(0) = Vector3d(0.1, y, 0.05);
    const auto found = test::contactsOf(ball, cloth, kMargin);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_LT((found[0].normal - Vector3d(0, y > 0 ? 1 : -1, 0)).norm(), kRounding);
    EXPECT_NEAR(found[0].gap, 0.0, kRounding);
  }
}

TEST(SurfaceContacts, insideIsPushedOutOfTheNearestFace) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 200; ++trial) {
    MovingShape ball = test::sphereShape(0.03), soft = cube();
    const Vector3d centre = 0.49 * test::randomVector(random);
    ball.position.col(0) = centre;
    Eigen::Index axis = 0;
    const double depth = 0.5 - centre.cwiseAbs().maxCoeff(&axis);
    const auto found = test::contactsOf(ball, soft, kMargin);
    ASSERT_EQ(found.size(), depth <= 0.25 ? 1u : 0u);  // a quarter of the edge
    if (found.empty()) continue;
    EXPECT_NEAR(found[0].gap, -depth - 0.05, kRounding);
    EXPECT_LT((found[0].normal - (centre[axis] > 0 ? 1.0 : -1.0) * Vector3d::Unit(axis)).norm(), kRounding);
  }
}

/// A point in front of one face of a plate is behind the other face, but not inside.
TEST(SurfaceContacts, aboveAPlateIsNotInside) {
  for (double height = 0.0; height < 0.3; height += 0.01) {
    MovingShape ball = test::sphereShape(0.01), plate = test::boxShape({1, 0.05, 1}, 0.0);
    ball.position.col(0) = Vector3d(0.1, 0.026 + height, 0.07);
    const auto found = test::contactsOf(ball, plate, kMargin);
    for (const SurfaceContact& c : found) EXPECT_LT((c.normal - Vector3d::UnitY()).norm(), kRounding);
    EXPECT_EQ(found.size(), height < 0.0155 ? 1u : 0u) << height;
  }
}

/// The point is inside the solid under a concave edge: the nearest point is on the edge, and no triangle is
/// above it.
TEST(SurfaceContacts, insideBelowAValleyIsPushedOut) {
  Points points(3, 8);
  points << -1, 0, 1, -1, 0, 1, 0, 0,  //
      0.5, 0, 0.5, 0.5, 0, 0.5, -3, -3, -1, -1, -1, 1, 1, 1, -1, 1;
  SurfaceFeatures f;
  f.triangles = {{0, 3, 1}, {3, 4, 1}, {1, 4, 2}, {4, 5, 2}, {6, 1, 2}, {6, 0, 1},
                 {7, 5, 4}, {7, 4, 3}, {0, 6, 3}, {6, 7, 3}, {6, 2, 5}, {6, 5, 7}};
  MovingShape valley = test::makeShape(points, f, 0.0), ball = test::sphereShape(0.03);
  ASSERT_TRUE(valley.topology.oneSided[0]);
  ball.position.col(0) = Vector3d(0.0, -0.02, 0.1);
  const auto found = test::contactsOf(ball, valley, kMargin);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_GT(found[0].normal.y(), 0.8);
  EXPECT_LT(found[0].gap, -0.03);
}

TEST(SurfaceContacts, ballInACornerHasOneContactForEachDirection) {
  MovingShape ball = test::sphereShape(0.05), floor = test::boxShape({4, 1, 4}, 0.0), ground;
  Points points(3, 6);  // a floor and a wall with the z axis as common edge
  points << 0, 0, 2, 2, 0, 0, 0, 0, 0, 0, 2, 2, -2, 2, -2, 2, -2, 2;
  SurfaceFeatures f;
  f.triangles = {{0, 1, 2}, {2, 1, 3}, {0, 4, 1}, {4, 5, 1}};
  f.solid = limber::Solid::AllPieces;
  ground = test::makeShape(points, f, 0.0);
  ball.position.col(0) = Vector3d(0.051, 0.051, 0.0);
  const auto found = test::contactsOf(ball, ground, kMargin);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found[0].normal.dot(found[1].normal), 0.0, kRounding);
}

// --- the cache ---------------------------------------------------------------------------------------------

/// A cube on another, rotated and off-centre: with contacts of vertices with faces and of crossing edges.
struct Pile {
  MovingShape upper = test::boxShape(Vector3d::Ones(), kRadius);
  MovingShape lower = test::boxShape(Vector3d::Ones(), kRadius);
  ContactCache cache;

  Pile() {
    upper.move(Translation3d(0.3, 1.0 + 2.0 * kRadius + 0.001, 0.2) * AngleAxisd(0.4, Vector3d::UnitY()));
    storeContacts(upper.surface(), lower.surface(), test::contactsOf(upper, lower, kMargin), cache);
  }
  bool refresh() { return refreshContacts(upper.surface(), lower.surface(), kMargin, cache); }
};

TEST(ContactCache, areThoseOfANewSearch) {
  Pile pile;
  ASSERT_GE(pile.cache.contacts.size(), 4u);
  // 0.3 mm sideways and 0.2 mm down, 0.1 mrad about all axes: within a fifth of the margin
  pile.upper.move(Translation3d(3e-4, -2e-4, 0.0) * AngleAxisd(1e-4, Vector3d::Ones().normalized()));
  ASSERT_TRUE(pile.refresh());
  const std::vector<SurfaceContact> found = test::contactsOf(pile.upper, pile.lower, kMargin);
  ASSERT_EQ(found.size(), pile.cache.contacts.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const SurfaceContact& cached = pile.cache.contacts[i];
    EXPECT_EQ(cached.key, found[i].key);
    EXPECT_NEAR(cached.gap, found[i].gap, kRounding);
    EXPECT_NEAR((cached.normal - found[i].normal).norm(), 0.0, kRounding);
    EXPECT_NEAR((cached.a.weights - found[i].a.weights).norm(), 0.0, kRounding);
    EXPECT_NEAR((cached.b.weights - found[i].b.weights).norm(), 0.0, kRounding);
  }
}

TEST(ContactCache, goAlongWithBothSurfaces) {
  Pile pile;
  for (MovingShape* shape : {&pile.upper, &pile.lower}) {
    shape->move(Affine3d(Translation3d(3.0, -2.0, 1.0)));
    shape->setMotion({0.5, -0.5, 0.1});
  }
  EXPECT_TRUE(pile.refresh()) << "only motion against each other counts";
}

TEST(ContactCache, areNotTrustedAfterMoreThanAShareOfTheMargin) {
  Pile pile;
  pile.upper.move(Affine3d(Translation3d(0.3 * kMargin, 0.0, 0.0)));
  EXPECT_FALSE(pile.refresh());
}

TEST(ContactCache, areNotTrustedIfSomethingElseMayMeetWithinTheTick) {
  Pile pile;
  pile.upper.setMotion({0.0, -kMargin, 0.0});
  EXPECT_FALSE(pile.refresh());
}

TEST(ContactCache, areNotTrustedOnceAPlaceLeavesItsFeature) {
  MovingShape upper = test::boxShape(Vector3d::Ones(), kRadius);
  MovingShape lower = test::boxShape(Vector3d::Ones(), kRadius);
  // two corners of the upper cube are 0.1 mm inside the rim of the lower cube's face
  upper.move(Affine3d(Translation3d(1.0 - 1e-4, 1.0 + 2.0 * kRadius, 0.3)));
  ContactCache cache;
  storeContacts(upper.surface(), lower.surface(), test::contactsOf(upper, lower, kMargin), cache);
  ASSERT_FALSE(cache.contacts.empty());
  upper.move(Affine3d(Translation3d(9e-4, 0.0, 0.0)));
  EXPECT_FALSE(refreshContacts(upper.surface(), lower.surface(), kMargin, cache));
}

}  // namespace
}  // namespace limber
