// SPDX-License-Identifier: Zlib
#pragma once

// Triangle meshes: the input of networks. Thread rule: any thread; calls are independent.

#include <limber/export.h>
#include <limber/result.h>

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber {

// --- triangle meshes ---------------------------------------------------------------------------------------

/// Three indices, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

/// A triangle mesh as in files and renderers: a position can occur several times, once for each of its
/// normals or texture coordinates.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> positions;  ///< #vertices, metres
  std::vector<Eigen::Vector3f> normals;    ///< #vertices, or empty
  std::vector<Eigen::Vector2f> uvs;        ///< #vertices, or empty
  std::vector<Triangle> triangles;         ///< #triangles, vertex indices
};

/// Checks a mesh. The error is the first defect that makes it unusable, with its index ("triangle 17 uses
/// vertex 900 of 812"). Checks: there are vertices and triangles, indices are in range, positions are
/// finite and within 1e9, and the optional arrays have one entry per vertex. Degenerate triangles are no
/// error: weld() drops and counts them.
LIMBER_API Result<void> validate(const TriangleMesh& mesh);

/// Writes a mesh as text, by the ending of the name: .obj or .ply, with normals and texture coordinates if
/// the mesh has them. The file appears complete or not at all. Errors name the file: another ending, an
/// invalid mesh, a file that cannot be written.
LIMBER_API Result<void> saveMesh(const TriangleMesh& mesh, const std::string& file);

// --- welding -----------------------------------------------------------------------------------------------

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
LIMBER_API std::string describe(const MeshReport& report);

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
LIMBER_API Result<WeldedMesh> weld(const TriangleMesh& mesh, double tolerance = 0.0);

// --- simplification ----------------------------------------------------------------------------------------

/// Returns a coarser mesh of about `points` points, for the physics of a detailed mesh. It never has fewer
/// points, and has more where the topology of the mesh requires it. Edges are collapsed in the order of their
/// quadric error (Garland, Heckbert 1997) as long as the surface stays manifold and no triangle flips. Closed
/// meshes stay closed; components stay separate. Normals and texture coordinates are dropped. Errors: those
/// of weld(); `points` below 4.
LIMBER_API Result<TriangleMesh> simplify(const TriangleMesh& mesh, std::uint32_t points);

// --- wrapping ----------------------------------------------------------------------------------------------

struct WrapSettings {
  double resolution = 0.0;  ///< m, width of the cells of the grid; 0: a 64th of the longest side of the mesh
  double thickness = 0.0;   ///< m: sheets, and parts thinner than this, become this thick; 0: two cells
  double join = 0.0;        ///< m: pieces nearer to each other than this are joined; 0: two cells
  bool connect =
      false;  ///< rods of `thickness` join the pieces that are farther apart, along the shortest tree
};

/// A closed surface around a mesh, and what it changed.
struct WrappedMesh {
  TriangleMesh mesh;  ///< closed, manifold, oriented outward; no normals or texture coordinates
  double resolution = 0.0, thickness = 0.0, join = 0.0;  ///< m, as used
  double volume = 0.0;                                   ///< m^3, enclosed
  double thinFraction = 0.0;  ///< of the area of the mesh: sheets and thin parts, which were thickened
  std::size_t pieces = 0;     ///< of the wrapped surface, hollows included
  std::size_t rods = 0;       ///< that join pieces
  std::size_t crumbs = 0;     ///< pieces of less than a ten-thousandth of the volume, which were left out
};

/// Wraps any mesh by a closed surface: open, of several pieces, intersecting itself, non-manifold or oriented
/// inconsistently. Components are oriented outward by their shape. A place is inside if its generalised
/// winding number is above 1/2 (Jacobson, Kavan, Sorkine 2013: holes are closed by smooth caps, overlapping
/// pieces are joined). What has no inside, or a thin one, gets `thickness`, and narrow gaps between pieces
/// are filled. The surface lies within about half of `resolution` of the mesh, except at these places.
/// Hollows enclosed by another component are filled. Deterministic. Errors: those of weld(); settings below 0
/// or not finite; a resolution that needs more than ten million cells; a mesh without extent.
LIMBER_API Result<WrappedMesh> wrap(const TriangleMesh& mesh, const WrapSettings& settings = {});

// --- files -------------------------------------------------------------------------------------------------

/// Reads all triangle meshes of a file in any format that assimp reads, and joins them into one. Polygons are
/// triangulated and node transforms are applied. Normals and the first set of texture coordinates are kept if
/// every mesh of the file has them. Vertices that are bit-equal in all of these are stored once. Positions
/// are in the file's units. Errors name the file and the reason: missing or unreadable file, no triangles,
/// and everything that validate(TriangleMesh) rejects, with the index in the mesh as assimp gives it: it
/// numbers the vertices of OBJ files in the order in which triangles use them. In OFF files assimp replaces
/// indices that are out of range by the last vertex, without a message.
///
/// A damaged file can crash assimp, keep it busy for ever, or make it allocate all memory. The headers of PLY
/// files, where this is frequent, are checked before assimp reads them; other faults are not caught. So read
/// files of unknown origin in a child process with limits of time and memory. demo/mesh_reader.h of Limber's
/// sources does so in 200 lines. For files that may be malicious, also take the rights from the child that
/// reading does not need.
///
/// Thread rule: any thread; calls are independent. Needs the library limber_import (assimp).
LIMBER_IMPORT_API Result<TriangleMesh> importMesh(const std::string& path);

}  // namespace limber
