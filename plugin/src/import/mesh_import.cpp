// SPDX-License-Identifier: Zlib
#include <limber/mesh_import.h>

#include "import/identical_vertices.h"
#include "import/ply_header.h"
#include "import/scene_to_mesh.h"

#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include <exception>
#include <filesystem>
#include <system_error>

namespace limber {
namespace {

std::string checkFile(const std::string& path) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(path, failure);
  if (!std::filesystem::exists(status)) return "there is no such file";
  if (std::filesystem::is_directory(status)) return "it is a directory";
  if (!std::filesystem::is_regular_file(status)) return "it is not a regular file";
  const std::uintmax_t size = std::filesystem::file_size(path, failure);
  if (failure) return failure.message();
  if (size == 0) return "the file is empty";
  return checkPlyHeader(path);
}

/// Reads without any of assimp's repairs, so that our own checks see what the file holds. Not even its
/// splitting of polygons: it follows indices unchecked, drops small triangles and aborts the program at a
/// face without corners.
Result<TriangleMesh> readMesh(const std::string& path) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  if (scene == nullptr) return Error{importer.GetErrorString()};
  if (std::string reason = checkScene(*scene); !reason.empty()) return Error{std::move(reason)};

  TriangleMesh mesh = joinMeshes(*scene);
  if (mesh.triangles.empty()) return Error{"the file has no triangles"};
  if (std::string reason = validate(mesh); !reason.empty()) return Error{std::move(reason)};
  joinIdenticalVertices(mesh);
  return mesh;
}

/// assimp lets through what its format readers or the standard library throw on damaged files.
Result<TriangleMesh> readWithoutThrowing(const std::string& path) {
  try {
    if (std::string reason = checkFile(path); !reason.empty()) return Error{std::move(reason)};
    return readMesh(path);
  } catch (const std::exception& failure) {
    return Error{failure.what()};
  } catch (...) {
    return Error{"the reader gave up for an unknown reason"};
  }
}

}  // namespace

Result<TriangleMesh> importMesh(const std::string& path) {
  Result<TriangleMesh> mesh = readWithoutThrowing(path);
  if (!mesh) return Error{"cannot import '" + path + "': " + mesh.error()};
  return mesh;
}

}  // namespace limber
