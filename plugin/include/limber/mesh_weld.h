// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/triangle_mesh.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber {

/// Marks a vertex that no triangle uses: it becomes no point.
constexpr std::uint32_t kNoPoint = 0xffffffffu;

/// What welding found. Nothing in it is fatal.
struct MeshReport {
  std::size_t vertices = 0;             ///< of the mesh
  std::size_t points = 0;               ///< unique positions that some triangle uses
  std::size_t triangles = 0;            ///< kept
  std::size_t degenerateTriangles = 0;  ///< dropped: two corners in one point, or no area
  std::size_t duplicateTriangles = 0;   ///< dropped: the same three points as an earlier triangle
  std::size_t isolatedVertices = 0;     ///< used by no kept triangle
  std::size_t components = 0;           ///< pieces that share no point
  std::size_t openEdges = 0;            ///< edges of one triangle
  std::size_t nonManifoldEdges = 0;     ///< edges of more than two triangles
  std::size_t inconsistentEdges = 0;    ///< edges that two triangles run through in the same direction

  /// Closed and oriented: every edge has two triangles that run through it in opposite directions.
  bool watertight() const { return openEdges == 0 && nonManifoldEdges == 0 && inconsistentEdges == 0; }
};

/// One line for people: "24 vertices -> 8 points, 12 triangles, 1 component, watertight".
std::string describe(const MeshReport& report);

/// A mesh whose equal positions have become one point each.
struct WeldedMesh {
  std::vector<Eigen::Vector3d> points;       ///< #points, metres, in order of first use by a vertex
  std::vector<std::uint32_t> vertexToPoint;  ///< #vertices; kNoPoint for isolated vertices
  std::vector<Triangle> triangles;           ///< #kept triangles, point indices
  std::vector<std::uint32_t> keptTriangles;  ///< #kept triangles, index of each in the mesh
  MeshReport report;
};

/// Merges vertices of equal position (vertices doubled at texture or normal seams would tear the body apart).
/// `tolerance` in metres: 0 merges bit-equal positions only; above 0, vertices that lie within the tolerance
/// of an earlier kept point join the nearest such point. Errors: validate(mesh); a negative or non-finite
/// tolerance; nothing left but degenerate triangles.
Result<WeldedMesh> weld(const TriangleMesh& mesh, double tolerance = 0.0);

}  // namespace limber
