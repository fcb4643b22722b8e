// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace limber {

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

/// Returns the first defect that makes `mesh` unusable, with its index ("triangle 17 uses vertex 900 of
/// 812"), or an empty string. Checks: there are vertices and triangles, indices are in range, positions are
/// finite, and the optional arrays have one entry per vertex. Degenerate triangles are no error: weld() drops
/// and counts them.
std::string validate(const TriangleMesh& mesh);

}  // namespace limber
