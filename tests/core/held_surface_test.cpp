// SPDX-License-Identifier: Zlib
// What a point that moves may touch of what is held around it.
#include "solver/held_surface.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Two triangles of a sheet, at right angles, and a point of 0.1 m around which they are.
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
    around = {&all, 0, 2, 0.1};
  }
  Corner(const Corner&) = delete;
  Corner& operator=(const Corner&) = delete;

  HeldSurroundings all;
  HeldNeighbourhood around;
};

/// m, a way that swings through the corner and comes back.
Vector3d placeAt(double t) { return {1.5 * std::cos(t), 1.2 * std::cos(1.7 * t), 0.3 * std::sin(t)}; }

TEST(HeldSurface, aPointTouchesTheSameWhetherItIsFollowedOrMetAnew) {
  Corner followed, alwaysLookedAt;
  int found = 0;
  for (double t = 0.0; t < 20.0; t += 1e-3) {
    const Vector3d x = placeAt(t), way = placeAt(t + 1e-3) - x;
    alwaysLookedAt.around.clear = 0.0;
    findContacts(followed.around, x, way, 0.03);
    findContacts(alwaysLookedAt.around, x, way, 0.03);
    ASSERT_EQ(followed.all.contacts.size(), alwaysLookedAt.all.contacts.size()) << t;
    for (std::size_t i = 0; i < followed.all.contacts.size(); ++i, ++found)
      ASSERT_EQ(followed.all.contacts[i].normal, alwaysLookedAt.all.contacts[i].normal) << t;
  }
  EXPECT_GT(found, 100);
}

TEST(HeldSurface, whatIsFarIsLookedAtAsItIsApproachedOnly) {
  Corner corner;
  int looks = 0;
  for (double height = 1.0; height > 0.2; height -= 1e-3) {
    const Vector3d before = corner.around.clearAt;
    findContacts(corner.around, {0.5, height, 0.0}, {0.0, -1e-3, 0.0}, 0.03);
    if (corner.around.clearAt != before) ++looks;
  }
  EXPECT_LT(looks, 20) << "of 800";
}

}  // namespace
}  // namespace limber
