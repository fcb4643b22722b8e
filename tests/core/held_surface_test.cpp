// SPDX-License-Identifier: Zlib
// Contacts of points with the static surfaces around them.

#include "solver/plane_contacts.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Two triangles of a sheet at right angles around a point of radius 0.1 m.
struct Corner {
  Corner() {
    for (const Vector3d& up : {Vector3d(0, 1, 0), Vector3d(1, 0, 0)}) {
      HeldPiece piece;
      piece.kind = HeldPiece::Kind::Sheet;
      piece.center = up;
      const Vector3d along = Vector3d::UnitZ(), side = up.cross(along);
      piece.axes << -along - side, along - side, 2.0 * side;
      all.pieces.push_back(piece);
    }
    around.all = &all, around.end = 2, around.radius = 0.1;
  }
  Corner(const Corner&) = delete;
  Corner& operator=(const Corner&) = delete;

  HeldSurroundings all;
  HeldNeighbourhood around;
};

/// Returns the position (m) at time t on a path through the corner and back.
Vector3d positionAt(double t) { return {1.5 * std::cos(t), 1.2 * std::cos(1.7 * t), 0.3 * std::sin(t)}; }

TEST(HeldSurface, aPointTouchesTheSameWhetherItIsFollowedOrMetAnew) {
  Corner cached, uncached;
  int found = 0;
  for (double t = 0.0; t < 20.0; t += 1e-3) {
    const Vector3d x = positionAt(t), displacement = positionAt(t + 1e-3) - x;
    uncached.around.clear = 0.0;
    findContacts(cached.around, x, displacement, 0.03);
    findContacts(uncached.around, x, displacement, 0.03);
    ASSERT_EQ(cached.around.contacts.size(), uncached.around.contacts.size()) << t;
    for (std::size_t i = 0; i < cached.around.contacts.size(); ++i, ++found)
      ASSERT_EQ(cached.around.contacts[i].normal, uncached.around.contacts[i].normal) << t;
  }
  EXPECT_GT(found, 100);
}

TEST(HeldSurface, whatIsFarIsLookedAtAsItIsApproachedOnly) {
  Corner corner;
  int searches = 0;
  for (double height = 1.0; height > 0.2; height -= 1e-3) {
    const Vector3d before = corner.around.clearAt;
    findContacts(corner.around, {0.5, height, 0.0}, {0.0, -1e-3, 0.0}, 0.03);
    if (corner.around.clearAt != before) ++searches;
  }
  EXPECT_GT(searches, 0);
  EXPECT_LT(searches, 20) << "of 800";
}

// --- bounces -----------------------------------------------------------------------------------------------

/// A force gives a resting point a high approach speed within a substep. Rounding must not turn this into an
/// impact.
TEST(Bounce, whatIsPressedOnFromRestRests) {
  const double approach = 3.5, restitution = 0.5, slow = 0.02, dt = 2e-3;  // m/s, s
  for (const double gap : {-1e-17, 0.0, 1e-17})
    for (const double before : {-1e-17, 0.0, 1e-17})
      EXPECT_TRUE(bounceOf(gap, approach, before, restitution, slow, dt).rests) << gap << ", " << before;
}

TEST(Bounce, whatComesFastParts) {
  const double speed = 3.5, restitution = 0.5;
  const Bounce bounce = bounceOf(0.0, speed, speed, restitution, 0.02, 2e-3);
  EXPECT_FALSE(bounce.rests);
  EXPECT_NEAR(bounce.mean, restitution * speed, 1e-12);
}

}  // namespace
}  // namespace limber
