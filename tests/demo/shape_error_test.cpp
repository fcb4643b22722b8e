// SPDX-License-Identifier: Zlib
#include "scenes/arrangement.h"
#include "scenes/end_checks.h"

#include <gtest/gtest.h>

#include <limits>

namespace limber::scenes {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points unitCube() {
  Points points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1, (i >> 1) & 1, i >> 2);
  return points;
}

Points map(Points points, const Eigen::Affine3d& motion) {
  for (Eigen::Vector3d& p : points) p = motion * p;
  return points;
}

TEST(ShapeError, rigidMotionIsNoError) {
  Random random(5);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Affine3d motion = Eigen::Translation3d(3.0, -1.0, 7.0) * random.rotation();
    const ShapeError error = shapeError(unitCube(), map(unitCube(), motion));
    EXPECT_LT(error.relativeRms, 1e-12);
    EXPECT_FALSE(error.mirrored);
  }
}

TEST(ShapeError, mirrorImageIsNoRigidMotion) {
  const Eigen::Affine3d mirror(Eigen::Scaling(-1.0, 1.0, 1.0));
  const ShapeError error = shapeError(unitCube(), map(unitCube(), mirror));
  EXPECT_TRUE(error.mirrored);
  EXPECT_GT(error.relativeRms, 0.3);
}

// a stretch by s in x moves each point of the cube by s / 2
TEST(ShapeError, stretchIsMeasured) {
  const Eigen::Affine3d stretch(Eigen::Scaling(1.2, 1.0, 1.0));
  EXPECT_NEAR(shapeError(unitCube(), map(unitCube(), stretch)).relativeRms, 0.1, 1e-12);
}

TEST(ShapeError, isRelativeToTheSize) {
  const Eigen::Affine3d large(Eigen::Scaling(100.0, 100.0, 100.0));
  const Eigen::Affine3d stretched(Eigen::Scaling(120.0, 100.0, 100.0));
  EXPECT_NEAR(shapeError(map(unitCube(), large), map(unitCube(), stretched)).relativeRms, 0.1, 1e-12);
}

TEST(ShapeError, pointThatIsNowhereIsInfinitelyOff) {
  Points broken = unitCube();
  broken[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(shapeError(unitCube(), broken).relativeRms, std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace limber::scenes
