// SPDX-License-Identifier: Zlib
#include <limber/mesh.h>

#include "import/temporary_folder.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

using Eigen::Vector3d;
using limber::Result;
using limber::Triangle;
using limber::TriangleMesh;

namespace {

std::string floats(const std::string& id, const std::string& axes, const std::string& values, int count) {
  std::string params;
  for (const char axis : axes) params += std::string("<param name=\"") + axis + "\" type=\"float\"/>";
  const std::string stride = std::to_string(axes.size());
  return "<source id=\"" + id + "\"><float_array id=\"" + id + "-a\" count=\"" +
         std::to_string(static_cast<std::size_t>(count) * axes.size()) + "\">" + values +
         "</float_array><technique_common><accessor source=\"#" + id + "-a\" count=\"" +
         std::to_string(count) + "\" stride=\"" + stride + "\">" + params +
         "</accessor></technique_common></source>";
}

/// Returns a right-angled triangle in the plane z = 0 with normals (1, 0, 1) / sqrt(2), with or without uvs.
std::string geometry(const std::string& id, bool withUvs) {
  const std::string uvs = withUvs ? floats(id + "-t", "ST", "0 0 1 0 0 1", 3) : "";
  const std::string uvInput =
      withUvs ? "<input semantic=\"TEXCOORD\" source=\"#" + id + "-t\" offset=\"0\" set=\"0\"/>" : "";
  return "<geometry id=\"" + id + "\"><mesh>" + floats(id + "-p", "XYZ", "0 0 0 1 0 0 0 2 0", 3) +
         floats(id + "-n", "XYZ", "0.70710678 0 0.70710678 0.70710678 0 0.70710678 0.70710678 0 0.70710678",
                3) +
         uvs + "<vertices id=\"" + id + "-v\"><input semantic=\"POSITION\" source=\"#" + id +
         "-p\"/></vertices><triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#" + id +
         "-v\" offset=\"0\"/><input semantic=\"NORMAL\" source=\"#" + id + "-n\" offset=\"0\"/>" + uvInput +
         "<p>0 1 2</p></triangles></mesh></geometry>";
}

/// Returns a COLLADA file with the geometries "plain" and "textured" and the given nodes.
std::string collada(const std::string& nodes) {
  return "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
         "version=\"1.4.1\">"
         "<asset><unit meter=\"1\" name=\"meter\"/><up_axis>Y_UP</up_axis></asset><library_geometries>" +
         geometry("plain", false) + geometry("textured", true) +
         "</library_geometries><library_visual_scenes><visual_scene id=\"s\">" + nodes +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene "
         "url=\"#s\"/></scene></COLLADA>";
}

std::string node(const std::string& transform, const std::string& content) {
  return "<node>" + transform + content + "</node>";
}

const std::string kPlain = "<instance_geometry url=\"#plain\"/>";
const std::string kTextured = "<instance_geometry url=\"#textured\"/>";

TriangleMesh importNodes(const std::string& nodes) {
  const TemporaryFolder folder;
  Result<TriangleMesh> mesh = limber::importMesh(folder.write("a.dae", collada(nodes)));
  EXPECT_TRUE(mesh) << mesh.error();
  return mesh ? *mesh : TriangleMesh{};
}

Vector3d areaVector(const TriangleMesh& mesh, std::size_t triangle) {
  const Triangle& t = mesh.triangles[triangle];
  const Vector3d& a = mesh.positions[t[0]];
  return (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a) / 2.0;
}

void expectCorners(const TriangleMesh& mesh, std::size_t triangle, const std::vector<Vector3d>& expected) {
  ASSERT_LT(triangle, mesh.triangles.size());
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d& corner = mesh.positions[mesh.triangles[triangle][i]];
    EXPECT_LT((corner - expected[i]).norm(), 1e-6) << "corner " << i << ": " << corner.transpose();
  }
}

}  // namespace

TEST(MeshImportNodes, nodeTransformsMultiplyFromTheRoot) {
  const std::string inner = node("<translate>1 0 0</translate>", kPlain);
  const TriangleMesh mesh = importNodes(node("<rotate>0 0 1 90</rotate><scale>2 2 2</scale>", inner));
  expectCorners(mesh, 0, {{0, 2, 0}, {0, 4, 0}, {-4, 2, 0}});
}

TEST(MeshImportNodes, aMeshAtTwoNodesAppearsTwice) {
  const TriangleMesh mesh = importNodes(node("", kPlain) + node("<translate>0 0 3</translate>", kPlain));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  expectCorners(mesh, 0, {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}});
  expectCorners(mesh, 1, {{0, 0, 3}, {1, 0, 3}, {0, 2, 3}});
  EXPECT_EQ(limber::weld(mesh)->report.components, 2u);
}

TEST(MeshImportNodes, mirroredNodesKeepTheOutsideOut) {
  const TriangleMesh mesh = importNodes(node("", kPlain) + node("<scale>-1 1 1</scale>", kPlain));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_LT((areaVector(mesh, 0) - Vector3d(0, 0, 1)).norm(), 1e-6);
  EXPECT_LT((areaVector(mesh, 1) - Vector3d(0, 0, 1)).norm(), 1e-6) << "a mirror in x leaves +z the outside";
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  const std::size_t mirrored = mesh.triangles[1][0];
  EXPECT_LT((mesh.normals[mirrored] - Eigen::Vector3f(-1, 0, 1).normalized()).norm(), 1e-6f);
}

TEST(MeshImportNodes, mirroringTwiceIsARotation) {
  const TriangleMesh mesh = importNodes(node("<scale>-1 1 1</scale>", node("<scale>1 -1 1</scale>", kPlain)));
  expectCorners(mesh, 0, {{0, 0, 0}, {-1, 0, 0}, {0, -2, 0}});
  EXPECT_LT((areaVector(mesh, 0) - Vector3d(0, 0, 1)).norm(), 1e-6);
}

// The normal of the plane x + z = 0 scaled by (2, 1, 1) is that of x / 2 + z = 0.
TEST(MeshImportNodes, normalsOfAStretchedMeshStayNormal) {
  const TriangleMesh mesh = importNodes(node("<scale>2 1 1</scale>", kPlain));
  ASSERT_EQ(mesh.normals.size(), 3u);
  EXPECT_LT((mesh.normals[0] - Eigen::Vector3f(0.5f, 0, 1).normalized()).norm(), 1e-6f);
}

TEST(MeshImportNodes, uvsOnlyWhenEveryMeshHasThem) {
  EXPECT_EQ(importNodes(node("", kTextured)).uvs.size(), 3u);
  const TriangleMesh mixed = importNodes(node("", kTextured) + node("<translate>0 0 3</translate>", kPlain));
  EXPECT_EQ(mixed.triangles.size(), 2u);
  EXPECT_TRUE(mixed.uvs.empty());
  EXPECT_EQ(mixed.normals.size(), mixed.positions.size());
}

TEST(MeshImportNodes, uvsAsInTheFile) {
  const TriangleMesh mesh = importNodes(node("", kTextured));
  ASSERT_EQ(mesh.uvs.size(), 3u);
  EXPECT_EQ(mesh.uvs[mesh.triangles[0][1]], Eigen::Vector2f(1, 0));
  EXPECT_EQ(mesh.uvs[mesh.triangles[0][2]], Eigen::Vector2f(0, 1));
}

TEST(MeshImportNodes, aNodeScaledToNothingIsLeftToWeld) {
  const TriangleMesh mesh = importNodes(node("", kPlain) + node("<scale>0 0 0</scale>", kPlain));
  EXPECT_EQ(limber::weld(mesh)->report.degenerateTriangles, 1u);
  for (const Eigen::Vector3f& normal : mesh.normals) EXPECT_TRUE(normal.allFinite());
}

// assimp's reader of this format leaves null children for groups without triangles
TEST(MeshImportNodes, missingChildrenAreNoChildren) {
  const TemporaryFolder folder;
  const std::string groups = "one\n0 0 0 1 0 0 0 1 0\ntwo\n0 0 1 1 0 1 0 1 1\n";
  const Result<TriangleMesh> mesh = limber::importMesh(folder.write("groups.raw", groups));
  ASSERT_TRUE(mesh) << mesh.error();
  // assimp's reader may lose a group before this code
  EXPECT_GE(mesh->triangles.size(), 1u);
}
