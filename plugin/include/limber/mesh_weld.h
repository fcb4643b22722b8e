// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/triangle_mesh.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber {

/// Marks a vertex that no triangle uses, so that it has no point.
constexpr std::uint32_t kNoPoint = 0xffffffffu;

/// Counts from welding. None of them is an error.
struct MeshReport {
  std::size_t vertices = 0;             ///< in the mesh
  std::size_t points = 0;               ///< unique positions that some triangle uses
  std::size_t triangles = 0;            ///< kept
  std::size_t degenerateTriangles = 0;  ///< dropped: two corners at the same point, or zero area
  std::size_t duplicateTriangles = 0;   ///< dropped: the same three points as an earlier triangle
  std::size_t isolatedVertices = 0;     ///< used by no kept triangle
  std::size_t components = 0;           ///< connected parts, which share no point
  std::size_t openEdges = 0;            ///< edges of one triangle only
  std::size_t nonManifoldEdges = 0;     ///< edges of more than two triangles
  std::size_t inconsistentEdges = 0;    ///< edges whose two triangles traverse them in the same direction

  /// Returns whether the mesh is closed and oriented: each edge has two triangles that traverse it in
  /// opposite directions.
  bool watertight() const { return openEdges == 0 && nonManifoldEdges == 0 && inconsistentEdges == 0; }
};

/// Returns a summary in one line: "24 vertices -> 8 points, 12 triangles, 1 component, watertight".
std::string describe(const MeshReport& report);

/// A mesh in which vertices of equal position are merged into one point.
struct WeldedMesh {
  std::vector<Eigen::Vector3d> points;       ///< #points, metres, in order of first use by a vertex
  std::vector<std::uint32_t> vertexToPoint;  ///< #vertices; kNoPoint for isolated vertices
  std::vector<Triangle> triangles;           ///< #kept triangles, point indices
  std::vector<std::uint32_t> keptTriangles;  ///< #kept triangles, index of each in the mesh
  MeshReport report;
};

/// Merges vertices of equal position. (Vertices are often duplicated at texture or normal seams; without
/// welding the body would tear there.) `tolerance` is in metres. With 0, bit-equal positions are merged.
/// Above 0, a vertex within the tolerance of earlier kept points is merged into the nearest of them. Errors:
/// those of validate(mesh); a negative or non-finite tolerance; a mesh of degenerate triangles only.
Result<WeldedMesh> weld(const TriangleMesh& mesh, double tolerance = 0.0);

}  // namespace limber
