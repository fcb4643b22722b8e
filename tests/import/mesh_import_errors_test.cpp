// SPDX-License-Identifier: Zlib
#include <limber/mesh.h>

#include "import/temporary_folder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

using limber::importMesh;

namespace {

std::string plyHeader(const std::string& format, int vertices, int faces) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

template <class T>
void append(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string binaryPly(const std::vector<float>& coordinates, const std::vector<int>& polygon) {
  std::string bytes = plyHeader("binary_little_endian", static_cast<int>(coordinates.size() / 3), 1);
  for (const float coordinate : coordinates) append(bytes, coordinate);
  append(bytes, static_cast<unsigned char>(polygon.size()));
  for (const int index : polygon) append(bytes, index);
  return bytes;
}

/// Imports `content` as a file named `name` and expects an error that contains the path and `reason`.
void expectError(const std::string& name, const std::string& content, const std::string& reason) {
  const TemporaryFolder folder;
  const std::string path = folder.write(name, content);
  const std::string error = importMesh(path).error();
  EXPECT_NE(error.find("cannot import '" + path + "': "), std::string::npos) << error;
  EXPECT_NE(error.find(reason), std::string::npos) << name << ": " << error;
}

const std::string kObjPoints = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
const std::string kPlyPoints = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

TEST(MeshImportErrors, missingFile) {
  EXPECT_EQ(importMesh("/nowhere/a.obj").error(), "cannot import '/nowhere/a.obj': there is no such file");
  EXPECT_EQ(importMesh("").error(), "cannot import '': there is no such file");
}

TEST(MeshImportErrors, directory) {
  const TemporaryFolder folder;
  EXPECT_EQ(importMesh(folder.path()).error(), "cannot import '" + folder.path() + "': it is a directory");
}

TEST(MeshImportErrors, device) {
  EXPECT_EQ(importMesh("/dev/null").error(), "cannot import '/dev/null': it is not a regular file");
}

TEST(MeshImportErrors, emptyFile) {
  for (const char* name : {"a.obj", "a.stl", "a.ply", "a.dae", "a"})
    expectError(name, "", "the file is empty");
}

TEST(MeshImportErrors, unknownFormat) { expectError("a.foo", "hello world\n", "No suitable reader"); }

TEST(MeshImportErrors, garbage) {
  std::string bytes;
  for (int i = 0; i < 4096; ++i) bytes.push_back(static_cast<char>(i * 7 + i / 256));
  for (const char* name :
       {"a.obj", "a.stl", "a.ply", "a.off", "a.dae", "a.gltf", "a.glb", "a.fbx", "a.3ds"}) {
    expectError(name, bytes, "");
  }
}

TEST(MeshImportErrors, truncatedFile) {
  expectError("a.ply", plyHeader("ascii", 100, 100) + "0 0 0\n1 0 0\n",
              "announces 100 elements 'vertex', for which the file is too short");
  expectError("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", "the PLY header has no end");
  expectError("a.stl", std::string(80, '\0') + std::string("\x64\0\0\0", 4), "");
}

TEST(MeshImportErrors, headerThatPromisesTooMuch) {
  expectError("a.ply", plyHeader("ascii", 2000000000, 1) + "0 0 0\n",
              "announces 2000000000 elements 'vertex'");
  expectError("a.ply", "ply\nformat ascii 1.0\nelement vertex\nend_header\n",
              "the line 'element vertex' of the PLY header has no count");
}

// assimp 5.2 reads for ever after these headers
TEST(MeshImportErrors, plyHeaderThatDoesNotEnd) {
  const std::string header = plyHeader("ascii", 3, 1);
  expectError("a.ply", header.substr(0, header.size() - 1), "the PLY header has no end");
  expectError("a.ply", header.substr(0, header.size() - 1) + "\v" + kPlyPoints + "3 0 1 2\n",
              "the line 'end_header?0 0 0' of the PLY header has control characters");
  expectError("a.ply", "pLyx\nformat ascii 1.0\nelement vertex", "the PLY header has no end");
}

// assimp 5.2 crashes: it writes the texture coordinates of corners that do not exist
TEST(MeshImportErrors, plyFacesWithoutVertexIndices) {
  std::string file = plyHeader("ascii", 4, 1) + kPlyPoints + "3 0 1 2 6 0 0 0 1 1 1\n";
  file.replace(file.find("end_header"), 0, "property list uchar float texcoord\n");
  const TemporaryFolder folder;
  EXPECT_TRUE(importMesh(folder.write("a.ply", file)));
  file.replace(file.find("vertex_indices"), 14, "vertes_indices");
  expectError("a.ply", file, "the PLY header has faces without a list vertex_indices");
}

TEST(MeshImportErrors, plyHeaderWithInvalidLines) {
  const std::string contents = kPlyPoints + "3 0 1 2\n";
  const auto expectAfter = [&](const std::string& from, const std::string& to, const std::string& reason) {
    std::string header = plyHeader("ascii", 4, 1);
    header.replace(header.find(from), from.size(), to);
    expectError("a.ply", header + contents, reason);
  };
  expectAfter("float y", "flaot y", "the line 'property flaot y' of the PLY header has an unknown type");
  expectAfter("list uchar", "list float", "has an unknown type");
  expectAfter("float x", "float x y z", "is not a property with a type and a name");
  expectAfter("element vertex 4\n", "", "'property float x' of the PLY header belongs to no element");
  expectAfter("ascii", "utf8", "'format utf8 1.0' of the PLY header names an unknown format");
  expectAfter("vertex 4", "vertex 9", "announces 9 elements 'vertex', for which the file is too short");
}

TEST(MeshImportErrors, plyHeaderWithCommentsIsValid) {
  std::string file = plyHeader("ascii", 4, 1) + kPlyPoints + "3 0 1 2\n";
  file.replace(file.find("element"), 0, "comment by hand \x01\nobj_info 3\nMade by an old program\n\n");
  const TemporaryFolder folder;
  const limber::Result<limber::TriangleMesh> mesh = importMesh(folder.write("a.ply", file));
  EXPECT_TRUE(mesh) << mesh.error();
}

TEST(MeshImportErrors, noTriangles) {
  expectError("a.obj", kObjPoints, "the file has no triangles");
  expectError("a.obj", kObjPoints + "p 1 2 3\n", "the file has no triangles");
  expectError("a.obj", kObjPoints + "l 1 2 3\n", "the file has no triangles");
  expectError("a.ply", plyHeader("ascii", 4, 0) + kPlyPoints, "no triangles");
  expectError("a.stl", "solid a\nendsolid a\n", "the file has no triangles");
}

TEST(MeshImportErrors, facesWithoutCornersAreNoTriangles) {
  expectError("a.ply", plyHeader("ascii", 4, 2) + kPlyPoints + "0\n2 0 1\n", "the file has no triangles");
  expectError("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n0\n", "");
}

TEST(MeshImportErrors, nanPosition) {
  const std::string reason = "the position of vertex 1 is not finite";
  expectError("a.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", reason);
  expectError("a.ply", plyHeader("ascii", 3, 1) + "0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n", reason);
  expectError("a.ply", binaryPly({0, 0, 0, kNan, 0, 0, 0, 1, 0}, {0, 1, 2}), reason);
  expectError("a.off", "OFF\n3 1 0\n0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n", reason);
  expectError("a.stl",
              "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex nan 0 0\nvertex 0 1 0\nendloop\n"
              "endfacet\nendsolid a\n",
              reason);
}

TEST(MeshImportErrors, nanPositionInAPolygon) {
  expectError("a.ply", binaryPly({0, 0, 0, 1, 0, 0, 1, 1, kNan, 0, 1, 0}, {0, 1, 2, 3}),
              "vertex 2 is not finite");
}

TEST(MeshImportErrors, infinitePosition) {
  const std::string reason = "the position of vertex 1 is not finite";
  expectError("a.obj", "v 0 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n", reason);
  expectError("a.obj", "v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n",
              reason);  // too large for assimp's floats
  expectError("a.ply", plyHeader("ascii", 3, 1) + "0 0 0\n-inf 0 0\n0 1 0\n3 0 1 2\n", reason);
}

TEST(MeshImportErrors, outOfRangeIndex) {
  const std::string points = plyHeader("ascii", 4, 1) + kPlyPoints;
  expectError("a.ply", points + "3 0 1 900\n", "face 0 of mesh 0 uses vertex 900 of 4");
  expectError("a.ply", points + "3 0 1 4\n", "face 0 of mesh 0 uses vertex 4 of 4");
  expectError("a.ply", points + "3 0 1 -1\n", "face 0 of mesh 0 uses vertex 4294967295 of 4");
  expectError("a.ply", binaryPly({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 900}),
              "face 0 of mesh 0 uses vertex 900 of 3");
  expectError("a.obj", kObjPoints + "f 1 2 900\n", "vertex index out of range");
  expectError("a.obj", kObjPoints + "f -1 -2 -9\n", "vertex index out of range");
  expectError("a.obj", kObjPoints + "f 0 1 2\n", "Invalid face index");
}

TEST(MeshImportErrors, outOfRangeIndexInAPolygon) {
  expectError("a.ply", plyHeader("ascii", 4, 1) + kPlyPoints + "4 0 1 3 2000000000\n",
              "face 0 of mesh 0 uses vertex 2000000000 of 4");
  expectError("a.obj", kObjPoints + "f 1 2 4 900\n", "vertex index out of range");
}
