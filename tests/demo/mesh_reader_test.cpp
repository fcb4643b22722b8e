// SPDX-License-Identifier: Zlib
#include "mesh_reader.h"

#include "import/temporary_folder.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <iterator>
#include <random>
#include <stdexcept>
#include <utility>

namespace limber::demo {
namespace {

const std::string kCube = LIMBER_MESH_DIR "/cube.obj";

TEST(MeshReader, readsWhatImportMeshReads) {
  for (const char* name : {"/cube.obj", "/figure.obj"}) {
    const std::string path = std::string(LIMBER_MESH_DIR) + name;
    const Result<TriangleMesh> read = readMesh(path), imported = importMesh(path);
    ASSERT_TRUE(read) << read.error();
    EXPECT_EQ(read->positions, imported->positions);
    EXPECT_EQ(read->normals, imported->normals);
    EXPECT_EQ(read->uvs, imported->uvs);
    EXPECT_EQ(read->triangles, imported->triangles);
  }
}

TEST(MeshReader, errorsAreThoseOfTheReader) {
  EXPECT_EQ(readMesh("no_such.obj").error(), importMesh("no_such.obj").error());
  EXPECT_EQ(readMesh("a", {}, [](const std::string& path) { return Error{path + " is bad"}; }).error(),
            "a is bad");
}

std::string errorFrom(const MeshReader& reader, const ReadLimits& limits = {}) {
  return readMesh("x.ply", limits, reader).error();
}

TEST(MeshReader, aCrashIsAnError) {
  EXPECT_EQ(errorFrom([](const std::string&) -> Result<TriangleMesh> { std::abort(); }),
            "cannot import 'x.ply': the reader crashed (signal 6): the file is damaged");
  EXPECT_EQ(errorFrom([](const std::string&) -> Result<TriangleMesh> { throw std::runtime_error("no"); }),
            "cannot import 'x.ply': the reader failed (exit code 2): the file is damaged");
}

TEST(MeshReader, anEndlessLoopIsAnError) {
  ReadLimits limits;
  limits.seconds = 1;
  volatile bool endless = true;
  const auto loop = [&](const std::string&) -> Result<TriangleMesh> {
    while (endless) continue;
    return Error{"came to an end"};
  };
  EXPECT_EQ(errorFrom(loop, limits),
            "cannot import 'x.ply': the reader took more than 1 s: the file is damaged or too large");
}

TEST(MeshReader, aDeadlockIsAnError) {
  ReadLimits limits;
  limits.clockSeconds = 1;
  const auto wait = [](const std::string&) -> Result<TriangleMesh> {
    while (true) pause();
  };
  EXPECT_EQ(errorFrom(wait, limits),
            "cannot import 'x.ply': the reader took more than 1 s: the file is damaged or too large");
}

TEST(MeshReader, aShortAnswerIsAnError) {
  EXPECT_EQ(errorFrom([](const std::string&) -> Result<TriangleMesh> { _exit(0); }),
            "cannot import 'x.ply': the reader gave a damaged mesh: the file is damaged");
}

TEST(MeshReader, aDamagedMeshIsAnError) {
  TriangleMesh mesh = *importMesh(kCube);
  mesh.triangles.back()[1] = 1000000;
  EXPECT_EQ(errorFrom([&](const std::string&) { return mesh; }),
            "cannot import 'x.ply': the reader gave a damaged mesh: the file is damaged");
}

// the reader moves a mesh that exists already, so that it needs no memory of its own
TEST(MeshReader, aMeshOverTheLimitIsAnError) {
  ReadLimits limits;
  limits.bytes = 1 << 20;
  TriangleMesh mesh = *importMesh(kCube);
  mesh.triangles.resize(200000);
  EXPECT_EQ(errorFrom([&](const std::string&) { return std::move(mesh); }, limits),
            "cannot import 'x.ply': the mesh is larger than 1 MiB");
}

// assimp 5.2 crashes, hangs and asks for gigabytes; another version may refuse these files by itself
TEST(MeshReader, damagedFilesAreErrorsThatNameTheFile) {
  const std::string camera = "CameraObject {\n    Param (attrib = \"fov\") { float { 0.97 } }\n";
  const std::string manyCorners =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
      "400000000 0 1 2\n";
  ReadLimits limits;
  limits.seconds = 1;
  limits.bytes = 1 << 30;
  const TemporaryFolder folder;
  for (const std::string& path :
       {folder.write("crash.ogex", camera + "}\n"), folder.write("hang.ogex", camera + "    Param (at"),
        folder.write("memory.ply", manyCorners)}) {
    const std::string error = readMesh(path, limits).error();
    EXPECT_EQ(error.find("cannot import '" + path + "': "), 0u) << error;
  }
}

/// Changes one to four places of a file: other characters, missing and repeated parts, numbers out of range.
std::string damaged(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t count) { return random() % count; };
  const char* words[] = {"-1", "0", "4294967295", "1e30", "nan", "\n", "x", "list", "float", " "};
  for (std::size_t changes = 1 + below(4); changes > 0 && !bytes.empty(); --changes) {
    const std::size_t at = below(bytes.size()), length = 1 + below(20);
    const std::size_t kind = below(5);
    if (kind == 0) bytes[at] = static_cast<char>(below(256));
    if (kind == 1) bytes.erase(at, length);
    if (kind == 2) bytes.insert(at, bytes.substr(below(bytes.size()), length));
    if (kind == 3) bytes.replace(at, below(3), words[below(std::size(words))]);
    if (kind == 4 && below(4) == 0) bytes.resize(at);
  }
  return bytes;
}

TEST(MeshReader, randomlyDamagedFilesAreReadOrRefused) {
  const std::string corners = "0 0 0\n1 0 0\n0 1 0\n";
  const std::pair<const char*, std::string> files[] = {
      {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n"},
      {"a.off", "OFF\n3 1 0\n" + corners + "3 0 1 2\n"},
      {"a.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
       "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n"
       "end_header\n" +
           corners + "3 0 1 2 6 0 0 0 1 1 1\n"}};
  ReadLimits limits;
  limits.seconds = 1;
  std::mt19937 random(1);
  const TemporaryFolder folder;
  int read = 0;
  for (const auto& [name, content] : files)
    for (int i = 0; i < 100; ++i) {
      const std::string path = folder.write(name, damaged(content, random));
      const Result<TriangleMesh> mesh = readMesh(path, limits);
      EXPECT_EQ(mesh.error().find(path) == std::string::npos, bool(mesh)) << mesh.error();
      read += static_cast<bool>(mesh);
    }
  EXPECT_GT(read, 30) << "most of the damage must not be in the first line";
}

}  // namespace
}  // namespace limber::demo
