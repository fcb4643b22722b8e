// SPDX-License-Identifier: Zlib
#include <limber/mesh.h>

#include "import/temporary_folder.h"

#include <gtest/gtest.h>

using limber::importMesh;
using limber::Result;
using limber::Triangle;
using limber::TriangleMesh;

namespace {

TriangleMesh import(const std::string& path) {
  Result<TriangleMesh> mesh = importMesh(path);
  EXPECT_TRUE(mesh) << mesh.error();
  return mesh ? *mesh : TriangleMesh{};
}

TriangleMesh importText(const std::string& name, const std::string& text) {
  const TemporaryFolder folder;
  return import(folder.write(name, text));
}

const std::vector<Eigen::Vector3d> kCorners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

}  // namespace

TEST(MeshImport, obj) {
  const TriangleMesh mesh = importText("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(mesh.positions, kCorners);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
  EXPECT_TRUE(mesh.normals.empty());
  EXPECT_TRUE(mesh.uvs.empty());
}

TEST(MeshImport, ply) {
  const TriangleMesh mesh =
      importText("a.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                 "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                 "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_EQ(mesh.positions, kCorners);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(MeshImport, stlWithItsNormals) {
  const TriangleMesh mesh = importText("a.stl",
                                       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                                       "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n");
  EXPECT_EQ(mesh.positions, kCorners);
  EXPECT_EQ(mesh.normals, std::vector<Eigen::Vector3f>(3, {0, 0, 1}));
}

TEST(MeshImport, off) {
  EXPECT_EQ(importText("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").positions, kCorners);
}

TEST(MeshImport, sharedCornersAreStoredOnce) {
  const TriangleMesh mesh = importText("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(MeshImport, seamsStayApart) {
  const TriangleMesh mesh = importText("a.obj",
                                       "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 0.25 1\n"
                                       "f 1/1 2/1 3/1\nf 1/1 3/2 4/2\n");
  ASSERT_EQ(mesh.positions.size(), 5u);
  EXPECT_EQ(mesh.positions[3], mesh.positions[2]);
  EXPECT_EQ(mesh.uvs[2], Eigen::Vector2f(0, 0));
  EXPECT_EQ(mesh.uvs[3], Eigen::Vector2f(0.25f, 1));
}

TEST(MeshImport, nearVerticesAreNotWelded) {
  const TriangleMesh mesh = importText("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1e-7 0 0\nf 1 2 3\nf 4 3 2\n");
  EXPECT_EQ(mesh.positions.size(), 4u);
}

TEST(MeshImport, degenerateTrianglesAreLeftToWeld) {
  const TriangleMesh mesh =
      importText("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\nf 1 2 4\n");
  EXPECT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(limber::weld(mesh)->report.degenerateTriangles, 2u);
}

TEST(MeshImport, duplicateTrianglesAreLeftToWeld) {
  const TriangleMesh mesh = importText("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\nf 1 2 3\n");
  EXPECT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(limber::weld(mesh)->report.duplicateTriangles, 2u);
}

TEST(MeshImport, fullyDegenerateMeshIsRefusedByWeld) {
  const TriangleMesh mesh = importText("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n");
  EXPECT_EQ(limber::weld(mesh).error(), "none of the 2 triangles has an area");
}

TEST(MeshImport, pointsAndLinesAreLeftOut) {
  const TriangleMesh mesh = importText("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nl 1 4\np 4\nf 1 2 3\n");
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(limber::weld(mesh)->points, kCorners);
}

TEST(MeshImport, missingMaterialFileDoesNotMatter) {
  EXPECT_EQ(
      importText("a.obj", "mtllib none.mtl\nusemtl x\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").triangles.size(),
      1u);
}

TEST(MeshImport, printsNothing) {
  const TemporaryFolder folder;
  const std::string good = folder.write("a.obj", "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string bad = folder.write("b.obj", "v 0 0 0\nf 1 2 3\n");
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  const bool goodRead = bool(importMesh(good)), badRead = bool(importMesh(bad));
  EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "");
  EXPECT_TRUE(goodRead);
  EXPECT_FALSE(badRead);
}
