// SPDX-License-Identifier: Zlib
// Declares finite elements of a homogeneous isotropic solid, linear and quadratic tetrahedra, and its slowest
// free vibrations.
#pragma once

#include "network/tetrahedra.h"

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

// --- elements ----------------------------------------------------------------------------------------------

/// Shear modulus of a solid of Young's modulus 1 and Poisson's ratio 1/4. Its other constant of Lame is the
/// same.
constexpr double kShearModulus = 0.4;

/// Stiffness and mass, the lower triangles, 3 #points x 3 #points.
struct SolidMatrices {
  Eigen::SparseMatrix<double> stiffness;  ///< m, for a Young's modulus of 1 Pa and a Poisson ratio of 1/4
  Eigen::SparseMatrix<double> mass;       ///< m^3, for a density of 1 kg/m^3; consistent, not lumped
};

/// Linear elements. They are exact for uniform strains. They are too stiff in bending and torsion.
SolidMatrices linearElements(const TetrahedralMesh& mesh);

/// Tetrahedra with a node at each corner and in the middle of each edge. The order of a tetrahedron's nodes:
/// corners 0 1 2 3, edges 01 02 03 12 13 23.
struct QuadraticMesh {
  std::vector<Eigen::Vector3d> nodes;  ///< m; the points of the mesh, then the middles of the edges
  std::vector<std::array<std::uint32_t, 10>> tetrahedra;
};
QuadraticMesh withMiddles(const TetrahedralMesh& mesh);

/// Quadratic elements (10 nodes, straight edges; O. C. Zienkiewicz, R. L. Taylor, "The Finite Element
/// Method"). They are exact for displacements of second degree, such as pure bending.
SolidMatrices quadraticElements(const QuadraticMesh& mesh);

/// Returns the values of the ten shape functions at a position with these barycentric coordinates.
std::array<double, 10> quadraticShapes(const Eigen::Vector4d& barycentric);

/// Returns the barycentric coordinates of a position in a tetrahedron.
Eigen::Vector4d barycentricCoordinates(const std::array<Eigen::Vector3d, 4>& corners,
                                       const Eigen::Vector3d& position);

// --- vibrations --------------------------------------------------------------------------------------------

/// Makes forces on the nodes of a tetrahedral mesh self-equilibrated, for each piece of the body.
class ForceBalance {
 public:
  /// `pieces`: the nodes of each piece. `mass`: the lower triangle, couples nodes of one piece only.
  ForceBalance(const std::vector<Eigen::Vector3d>& nodes, std::vector<std::vector<Eigen::Index>> pieces,
               const Eigen::SparseMatrix<double>& mass);

  /// Subtracts the inertial forces of the rigid acceleration that the forces (3 #nodes x #loads) cause.
  void balance(Eigen::MatrixXd& forces) const;

 private:
  struct Piece {
    std::vector<Eigen::Index> nodes;
    Eigen::MatrixXd motions, momenta;  ///< 3 #nodes x 6: rigid motions, and the mass times these
  };
  std::vector<Piece> pieces_;
};

/// Returns the balance of forces on the points of a mesh of linear elements.
ForceBalance balanceOf(const TetrahedralMesh& mesh, const Eigen::SparseMatrix<double>& mass);

/// Vibrations of a free homogeneous solid with a Young's modulus of 1 Pa, a Poisson ratio of 1/4 and a
/// density of 1 kg/m^3, without the rigid motions. The slowest come first.
struct SolidModes {
  QuadraticMesh mesh;
  Eigen::VectorXd squaredFrequencies;  ///< #modes, 1/s^2, of the angular frequencies
  Eigen::MatrixXd displacements;       ///< 3 #nodes x #modes, of modal mass 1
};

/// Computes about `count` modes with quadratic elements by subspace iteration (K.-J. Bathe, "Finite Element
/// Procedures", 11.6) from displacements of first to third degree. A small mesh has fewer modes. Takes 1 s
/// for 400 points.
SolidModes slowestModes(const TetrahedralMesh& mesh, Eigen::Index count);

/// Returns the displacements of the modes, 3 #positions x #modes, at positions in the body or near it.
Eigen::MatrixXd displacementsAt(const SolidModes& modes, const std::vector<Eigen::Vector3d>& positions);

}  // namespace limber
