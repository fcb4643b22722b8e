// SPDX-License-Identifier: Zlib
#include <limber/triangle_mesh.h>

namespace limber {
namespace {

std::string checkPositions(const TriangleMesh& mesh) {
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
    if (!mesh.positions[vertex].allFinite()) {
      return "the position of vertex " + std::to_string(vertex) + " is not finite";
    }
  }
  return {};
}

std::string checkIndices(const TriangleMesh& mesh) {
  for (std::size_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
    for (const std::uint32_t vertex : mesh.triangles[triangle]) {
      if (vertex >= mesh.positions.size()) {
        return "triangle " + std::to_string(triangle) + " uses vertex " + std::to_string(vertex) + " of " +
               std::to_string(mesh.positions.size());
      }
    }
  }
  return {};
}

std::string checkCount(const char* name, std::size_t count, std::size_t vertices) {
  if (count == 0 || count == vertices) return {};
  return std::to_string(count) + " " + name + " for " + std::to_string(vertices) + " vertices";
}

}  // namespace

std::string validate(const TriangleMesh& mesh) {
  if (mesh.positions.empty()) return "the mesh has no vertices";
  if (mesh.triangles.empty()) return "the mesh has no triangles";
  std::string reason = checkCount("normals", mesh.normals.size(), mesh.positions.size());
  if (reason.empty()) reason = checkCount("texture coordinates", mesh.uvs.size(), mesh.positions.size());
  if (reason.empty()) reason = checkPositions(mesh);
  if (reason.empty()) reason = checkIndices(mesh);
  return reason;
}

}  // namespace limber
