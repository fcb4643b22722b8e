// SPDX-License-Identifier: Zlib
// Surfaces of collision shapes: closed, facing outward, of the right volume.
#include <limber/view/shape_mesh.h>

#include "support/constants.h"

#include <limber/render/shape_desc.h>

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>

#include <cmath>
#include <string>
#include <vector>

namespace limber::view {
namespace {

using test::kPi;

Eigen::Vector3d corner(const render::Scenery& mesh, std::size_t i) {
  const std::uint32_t vertex = mesh.shape.triangles[i];
  const std::uint32_t point = mesh.shape.vertexToPoint.empty() ? vertex : mesh.shape.vertexToPoint[vertex];
  return Eigen::Map<const Eigen::Vector3f>(mesh.points.data() + std::size_t{3} * point).cast<double>();
}

/// Returns the volume by the divergence theorem; positive if triangles are counter-clockwise from outside.
double volumeOf(const render::Scenery& mesh) {
  double sixfold = 0.0;
  for (std::size_t i = 0; i < mesh.shape.triangles.size(); i += 3)
    sixfold += corner(mesh, i).dot(corner(mesh, i + 1).cross(corner(mesh, i + 2)));
  return sixfold / 6.0;
}

double areaOf(const render::Scenery& mesh) {
  double twofold = 0.0;
  for (std::size_t i = 0; i < mesh.shape.triangles.size(); i += 3) {
    const Eigen::Vector3d a = corner(mesh, i);
    twofold += (corner(mesh, i + 1) - a).cross(corner(mesh, i + 2) - a).norm();
  }
  return twofold / 2.0;
}

render::Scenery validMesh(const btCollisionShape& shape) {
  render::Scenery mesh = meshOf(shape);
  EXPECT_EQ(render::validate(mesh.shape), "") << shape.getName();
  EXPECT_EQ(mesh.points.size(), std::size_t{3} * mesh.shape.pointCount);
  return mesh;
}

TEST(ShapeMesh, BoxesAreExact) {
  EXPECT_NEAR(volumeOf(validMesh(btBoxShape(btVector3(0.5, 1.0, 1.5)))), 6.0, 1e-5);
}

TEST(ShapeMesh, RoundShapesComeClose) {
  // inscribed polyhedra are smaller by a few per cent
  const auto expectNear = [](const btCollisionShape& shape, double volume) {
    const double ratio = volumeOf(validMesh(shape)) / volume;
    EXPECT_GT(ratio, 0.93) << shape.getName();
    EXPECT_LT(ratio, 1.05) << shape.getName();
  };
  expectNear(btSphereShape(btScalar(0.7)), 4.0 / 3.0 * kPi * 0.343);
  const double capsule = kPi * 0.09 * 1.2 + 4.0 / 3.0 * kPi * 0.027;
  expectNear(btCapsuleShape(btScalar(0.3), btScalar(1.2)), capsule);
  expectNear(btCapsuleShapeX(btScalar(0.3), btScalar(1.2)), capsule);
  expectNear(btCapsuleShapeZ(btScalar(0.3), btScalar(1.2)), capsule);
  expectNear(btCylinderShape(btVector3(0.5, 1.0, 0.5)), kPi * 0.25 * 2.0);
  btConeShape cone(0.5, 1.5);
  cone.setMargin(0);  // it would be added around the cone
  expectNear(cone, kPi * 0.25 * 0.5);
}

TEST(ShapeMesh, CapsulesLieAlongTheirAxis) {
  for (int axis = 0; axis < 3; ++axis) {
    const btCapsuleShape y(btScalar(0.2), btScalar(2.0));
    const btCapsuleShapeX x(btScalar(0.2), btScalar(2.0));
    const btCapsuleShapeZ z(btScalar(0.2), btScalar(2.0));
    const btCollisionShape* shapes[] = {&x, &y, &z};
    const render::Scenery mesh = validMesh(*shapes[axis]);
    for (std::size_t c = 0; c < 3; ++c) {
      float largest = 0.0f;
      for (std::size_t i = c; i < mesh.points.size(); i += 3) largest = std::max(largest, mesh.points[i]);
      EXPECT_NEAR(largest, c == static_cast<std::size_t>(axis) ? 1.2 : 0.2, 0.01);
    }
  }
}

TEST(ShapeMesh, HullsHaveTheirOwnCorners) {
  btConvexHullShape hull;
  for (const btVector3& p : {btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 1, 0), btVector3(0, 0, 1)})
    hull.addPoint(p);
  hull.setMargin(0);
  EXPECT_NEAR(volumeOf(validMesh(hull)), 1.0 / 6.0, 1e-3);
}

TEST(ShapeMesh, ConcaveShapesGiveTheirTriangles) {
  btTriangleMesh triangles;
  triangles.addTriangle(btVector3(0, 0, 0), btVector3(2, 0, 0), btVector3(0, 0, 2));
  triangles.addTriangle(btVector3(2, 0, 0), btVector3(2, 0, 2), btVector3(0, 0, 2));
  btBvhTriangleMeshShape mesh(&triangles, true);
  EXPECT_NEAR(areaOf(validMesh(mesh)), 4.0, 1e-5);
  EXPECT_TRUE(meshOf(mesh).shape.twoSided);
  mesh.setLocalScaling(btVector3(2, 1, 1));
  EXPECT_NEAR(areaOf(validMesh(mesh)), 8.0, 1e-5);
  // PHY_FLOAT means btScalar
  const std::vector<btScalar> heights(16, btScalar(0.5));
  const btHeightfieldTerrainShape field(4, 4, heights.data(), btScalar(1), 0, 1, 1, PHY_FLOAT, false);
  EXPECT_NEAR(areaOf(validMesh(field)), 9.0, 1e-4);
}

TEST(ShapeMesh, PlanesAreAPieceOfThemFacingTheirNormal) {
  const btVector3 normal = btVector3(1, 2, 2).normalized();
  const render::Scenery mesh = validMesh(btStaticPlaneShape(normal, 3));
  const Eigen::Vector3d up(double(normal.x()), double(normal.y()), double(normal.z()));
  for (std::size_t i = 0; i < mesh.shape.triangles.size(); ++i)
    EXPECT_NEAR(corner(mesh, i).dot(up), 3.0, 1e-4);
  EXPECT_GT((corner(mesh, 1) - corner(mesh, 0)).cross(corner(mesh, 2) - corner(mesh, 0)).dot(up), 0.0);
}

TEST(ShapeMesh, CompoundsPutTheirChildrenInPlace) {
  btBoxShape box(btVector3(0.5, 0.5, 0.5));
  btCompoundShape inner, outer;
  inner.addChildShape(btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(0.7)), btVector3(1, 0, 0)), &box);
  outer.addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(0, 5, 0)), &inner);
  outer.addChildShape(btTransform::getIdentity(), &box);
  const render::Scenery mesh = validMesh(outer);
  EXPECT_NEAR(volumeOf(mesh), 2.0, 1e-5);
  float highest = 0.0f;
  for (std::size_t i = 1; i < mesh.points.size(); i += 3) highest = std::max(highest, mesh.points[i]);
  EXPECT_GT(highest, 5.5f);
}

TEST(ShapeMesh, EmptyShapesHaveNoTriangles) { EXPECT_TRUE(meshOf(btEmptyShape()).shape.triangles.empty()); }

}  // namespace
}  // namespace limber::view
