// SPDX-License-Identifier: Zlib
#include <limber/mesh.h>

#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <limits>

using limber::TriangleMesh;
using limber::validate;

TEST(TriangleMesh, soundMesh) { EXPECT_EQ(validate(small_meshes::tetrahedron()).error(), ""); }

TEST(TriangleMesh, emptyMesh) { EXPECT_EQ(validate(TriangleMesh{}).error(), "the mesh has no vertices"); }

TEST(TriangleMesh, noTriangles) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.triangles.clear();
  EXPECT_EQ(validate(mesh).error(), "the mesh has no triangles");
}

TEST(TriangleMesh, outOfRangeIndex) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.triangles[2][1] = 4;
  EXPECT_EQ(validate(mesh).error(), "triangle 2 uses vertex 4 of 4");
}

TEST(TriangleMesh, nanPosition) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.positions[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(validate(mesh).error(), "the position of vertex 3 is not finite");
}

TEST(TriangleMesh, infinitePosition) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.positions[1].z() = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(validate(mesh).error(), "the position of vertex 1 is not finite");
}

TEST(TriangleMesh, positionBeyondTheBound) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.positions[1].z() = -1e62;
  EXPECT_EQ(validate(mesh).error(), "the position of vertex 1 has a coordinate beyond 1e9");
}

TEST(TriangleMesh, optionalArraysHaveOneEntryPerVertex) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.normals.resize(4);
  mesh.uvs.resize(4);
  EXPECT_EQ(validate(mesh).error(), "");
  mesh.uvs.resize(5);
  EXPECT_EQ(validate(mesh).error(), "5 texture coordinates for 4 vertices");
  mesh.normals.resize(3);
  EXPECT_EQ(validate(mesh).error(), "3 normals for 4 vertices");
}

TEST(TriangleMesh, degenerateTrianglesAreNoError) {
  EXPECT_EQ(validate(small_meshes::collinearTriangle()).error(), "");
  TriangleMesh mesh = small_meshes::singleTriangle();
  mesh.triangles[0] = {1, 1, 1};
  EXPECT_EQ(validate(mesh).error(), "");
}
