// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh_weld.h>
#include <limber/spring_network.h>

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace limber {

/// The inside of a surface in tetrahedra.
struct TetrahedralMesh {
  std::vector<Eigen::Vector3d> points;  ///< #points, m
  std::vector<Tetrahedron> tetrahedra;  ///< positive volumes
  std::vector<Triangle> surface;        ///< closed, manifold, oriented outward
};

/// Fills the inside of a closed mesh, concave or in several pieces, with well-shaped tetrahedra by isosurface
/// stuffing (Labelle, Shewchuk 2007) on a body-centred cubic lattice of about this spacing (m): sites near
/// the surface move onto it, and tetrahedra that it cuts are clipped. Then the surface's points are drawn
/// into sharp edges and corners as far as the angles allow. Dihedral angles are bounded: from 17 to 153
/// degrees on a dozen shapes of 100 to 5 000 points. Surfaces oriented inward as a whole are turned around.
/// Deterministic. Errors: a mesh with open or inconsistent edges, with their number, or without volume; a
/// spacing too small for the lattice to be stored, or so large that a piece of the mesh is missed or falls
/// apart.
Result<TetrahedralMesh> fillWithTetrahedra(const WeldedMesh& mesh, double spacing);

/// The same with the spacing chosen so that there are about `points` points (8 or more). Once `goOn`, asked
/// with the share done, 0 to 1, says no, the best of the spacings tried so far is taken, or none, an error.
Result<TetrahedralMesh> fillWithPoints(const WeldedMesh& mesh, std::size_t points,
                                       const std::function<bool(double)>& goOn = {});

}  // namespace limber
