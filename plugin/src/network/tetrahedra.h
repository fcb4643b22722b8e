// SPDX-License-Identifier: Zlib
// Declares the filling of surfaces with tetrahedra, and the geometry and neighbours of tetrahedra.
#pragma once

#include "mesh/triangle_bvh.h"

#include <limber/spring_network.h>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace limber {

/// Marks a face of the surface, with no tetrahedron behind it.
constexpr std::uint32_t kOutside = 0xffffffffu;

/// For each corner of each tetrahedron the neighbour behind the opposite face, or kOutside.
using FaceNeighbours = std::vector<std::array<std::uint32_t, 4>>;
FaceNeighbours findFaceNeighbours(const std::vector<Tetrahedron>& tetrahedra);

/// Returns the faces that belong to only one tetrahedron, oriented outward, in the order of the tetrahedra.
std::vector<Triangle> surfaceOf(const std::vector<Tetrahedron>& tetrahedra, const FaceNeighbours& neighbours);

/// Returns the edges, sorted, each once.
std::vector<Edge> uniqueEdges(const std::vector<Tetrahedron>& tetrahedra);

/// Returns the volume (m^3), positive for positive orientation; the sum of those of several.
double volumeOf(const std::vector<Eigen::Vector3d>& points, const Tetrahedron& tetrahedron);
double volumeOf(const std::vector<Eigen::Vector3d>& points, const std::vector<Tetrahedron>& tetrahedra);

/// The smallest and the largest angle between two faces, radians.
struct DihedralAngles {
  double smallest = 0.0, largest = 0.0;
};
DihedralAngles dihedralAngles(const std::vector<Eigen::Vector3d>& points, const Tetrahedron& tetrahedron);

/// The inside of a surface, filled with tetrahedra.
struct TetrahedralMesh {
  std::vector<Eigen::Vector3d> points;  ///< #points, m
  std::vector<Tetrahedron> tetrahedra;  ///< positive volumes
  std::vector<Triangle> surface;        ///< closed, manifold, oriented outward
};

/// Fills the inside of a closed mesh with well-shaped tetrahedra. The mesh may be concave or have several
/// pieces. The method is isosurface stuffing (Labelle, Shewchuk 2007) on a body-centred cubic lattice of
/// about this spacing (m): sites near the surface move onto it, and tetrahedra that it cuts are clipped. Then
/// the surface's points move to sharp edges and corners as far as the angles allow. Dihedral angles are
/// bounded: from 17 to 153 degrees on a dozen shapes of 100 to 5 000 points. Surfaces oriented inward as a
/// whole are flipped. Deterministic. Errors: a mesh with open or inconsistent edges, with their number, or
/// without volume; a spacing that is too small for the lattice to be stored, or so large that a piece of the
/// mesh is missed or falls apart. With `fit`, a thinner closed mesh within this one, the surface's points
/// move towards that instead.
Result<TetrahedralMesh> fillWithTetrahedra(const WeldedMesh& mesh, double spacing,
                                           const WeldedMesh* fit = nullptr);

/// Does the same, with the spacing chosen for about `points` points (8 or more). `goOn` is called with the
/// progress, 0 to 1. After it has returned false, the best of the spacings tried so far is used; if there is
/// none, the result is an error.
Result<TetrahedralMesh> fillWithPoints(const WeldedMesh& mesh, std::size_t points,
                                       const std::function<bool(double)>& goOn = {});

/// A body-centred cubic lattice: the corners and the centres of cubes (or, stretched, of boxes). The
/// coordinates of a site are integers, in half spacings, all even (corners) or all odd (centres). The number
/// of a site is 2 (x + cells_x (y + cells_y z)), + 1 for centres, where x, y, z is the cell of which it is
/// the lower corner or the centre.
struct BccLattice {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();   ///< m, of site 0
  Eigen::Vector3d spacing = Eigen::Vector3d::Zero();  ///< m, along each axis
  Eigen::Vector3i cells = Eigen::Vector3i::Zero();    ///< along each axis

  std::uint32_t size() const { return 2 * static_cast<std::uint32_t>(cells.prod()); }
};

/// Fills the part of the lattice inside a closed surface with tetrahedra, by isosurface stuffing (F. Labelle,
/// J. R. Shewchuk, "Isosurface stuffing: fast tetrahedral meshes with good dihedral angles", SIGGRAPH 2007).
/// Points are numbered in the order of their first use; the surface is left empty.
TetrahedralMesh fillLattice(const BccLattice& lattice, const TriangleBvh& surface);

/// Makes the surface a manifold. Where parts of the body are joined only by an edge, removes all tetrahedra
/// at this edge except those of the largest part. Where they are joined only by a point, gives each part its
/// own point. Removes pieces that no face joins to a larger one and that have less than `minVolume` (m^3).
/// Drops points that no tetrahedron uses any more, and sets the surface.
void makeManifold(TetrahedralMesh& mesh, double minVolume);

/// Moves points at the same place, as those where parts of a solid touch, a little into their own tetrahedra.
void separatePoints(TetrahedralMesh& mesh);

/// Returns for each tetrahedron the number of its piece. Tetrahedra that share a face are of one piece. The
/// pieces are numbered in the order of their first tetrahedra.
std::vector<std::uint32_t> findPieces(const std::vector<Tetrahedron>& tetrahedra);

}  // namespace limber
