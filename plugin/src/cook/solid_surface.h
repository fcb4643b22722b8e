// SPDX-License-Identifier: Zlib
#pragma once

#include "mesh/triangle_bvh.h"

#include <limber/mesh_weld.h>

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace limber {

/// A closed surface, turned so that its inside is inside.
struct SolidSurface {
  std::vector<Triangle> triangles;
  std::vector<Eigen::Vector3d> centroids, normals;  ///< #triangles, m and unit vectors pointing outward
  std::vector<std::uint32_t> pieceOfTriangle;       ///< #triangles; pieces share no point
  std::size_t pieces = 0;
  TriangleBvh bvh;
  Eigen::AlignedBox3d box;
  double volume = 0.0;  ///< m^3
};

/// Why the mesh has no inside, or an empty string.
std::string whyNotSolid(const MeshReport& report);

SolidSurface makeSolidSurface(const WeldedMesh& mesh);

}  // namespace limber
