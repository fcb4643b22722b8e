// SPDX-License-Identifier: Zlib
// Depths of overlaps, compared with known values.
#include "scenes/overlap.h"
#include "scenes/networks.h"
#include "scenes/scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber::scenes {
namespace {

using Eigen::Vector3d;

/// Returns a cube with edges of 1 m.
const SpringNetwork& cube() {
  static const SharedNetwork network = *cubeNetwork();
  return *network;
}

PosedSurface cubeAt(const Vector3d& centre,
                    const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity()) {
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(cube().restPoints.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = centre + rotation * cube().restPoints[static_cast<std::size_t>(i)];
  return posed(points, cube().surface);
}

TEST(SignedDistance, OfACubeIsThatOfABox) {
  const PosedSurface surface = cubeAt({0, 0, 0});
  // nearest to a face, an edge and a corner; inside always to a face
  EXPECT_NEAR(signedDistance(surface, {0.1, 0.2, 0.9}), 0.4, 1e-12);
  EXPECT_NEAR(signedDistance(surface, {0.8, 0.9, 0.1}), 0.5, 1e-12);
  EXPECT_NEAR(signedDistance(surface, {0.6, 0.7, 0.7}), 0.3, 1e-12);
  EXPECT_NEAR(signedDistance(surface, {0.4, 0.1, -0.2}), -0.1, 1e-12);
  EXPECT_NEAR(signedDistance(surface, {0, 0, 0}), -0.5, 1e-12);
}

TEST(SignedDistance, HasNoInsideWhereNothingIsEnclosed) {
  PosedSurface surface = cubeAt({0, 0, 0});
  surface.encloses = false;
  EXPECT_NEAR(signedDistance(surface, {0.4, 0.1, -0.2}), 0.1, 1e-12);
}

TEST(SignedDistance, MovesWithTheSurface) {
  const Vector3d centre(3, -2, 1);
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
  EXPECT_NEAR(signedDistance(cubeAt(centre, rotation), centre + rotation * Vector3d(0.45, 0.1, 0.0)), -0.05,
              1e-12);
}

TEST(DeepestOverlap, IsThatOfAFace) {
  const Overlap overlap = deepestOverlap({cubeAt({0, 0, 0}), cubeAt({0.1, 5, 0}), cubeAt({0.1, 0.93, 0.2})});
  EXPECT_NEAR(overlap.depth, 0.07, 1e-12);
  EXPECT_EQ(overlap.inner + overlap.outer, 2u);
}

TEST(DeepestOverlap, SeesEdgesThatCross) {
  // two cubes on their edges, which cross at right angles: no corner of either is inside the other
  const double halfDiagonal = std::sqrt(0.5), height = 0.06;
  const Eigen::Quaterniond x(Eigen::AngleAxisd(std::atan(1.0), Vector3d::UnitX())),
      z(Eigen::AngleAxisd(std::atan(1.0), Vector3d::UnitZ()));
  const Overlap overlap =
      deepestOverlap({cubeAt({0, 0, 0}, x), cubeAt({0, 2 * halfDiagonal - height, 0}, z)});
  EXPECT_NEAR(overlap.depth, height * halfDiagonal,
              1e-12);  // from the edge of one cube to the faces of the other, at 45 degrees
}

TEST(DeepestOverlap, IsNothingApart) {
  EXPECT_EQ(deepestOverlap({cubeAt({0, 0, 0}), cubeAt({0, 1.01, 0})}).depth, 0.0);
  EXPECT_EQ(deepestOverlap({cubeAt({0, 0, 0})}).depth, 0.0);
}

TEST(RigidOverlap, OfABallAndABox) {
  SceneWorld world;
  btRigidBody& ball =
      addMovable(world, std::make_unique<btSphereShape>(btScalar(0.1)), 1.0, {0, 0.57, 0}, 0.5);
  btRigidBody& box = addMovable(world, std::make_unique<btBoxShape>(btVector3(1, btScalar(0.2), 1)), 1.0,
                                {0, -0.66, 0}, 0.5);
  const PosedSurface surface = cubeAt({0, 0, 0});
  EXPECT_NEAR(depthIn(surface, ball), 0.03, 1e-6);  // Bullet's numbers may be floats
  EXPECT_NEAR(depthIn(ball, {0, 0.5, 0}), 0.03, 1e-6);
  EXPECT_NEAR(depthIn(box, {0.3, -0.5, 0.2}), 0.04, 1e-6);
  EXPECT_EQ(depthIn(box, {0.3, -0.4, 0.2}), 0.0);
  const RigidOverlap deepest = deepestOverlap({surface}, world.movables);
  EXPECT_NEAR(deepest.depth, 0.04, 1e-6);
  EXPECT_EQ(deepest.rigid, 1u);
}

TEST(RigidOverlap, OfABoxsCornerInAFace) {
  SceneWorld world;
  addMovable(world, std::make_unique<btBoxShape>(btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.1))), 1.0,
             {0, 0.58, 0}, 0.5);
  EXPECT_NEAR(deepestOverlap({cubeAt({0, 0, 0})}, world.movables).depth, 0.02, 1e-6);
}

}  // namespace
}  // namespace limber::scenes
