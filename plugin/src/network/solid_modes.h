// SPDX-License-Identifier: Zlib
// Declares the slowest free vibrations of a solid body.
#pragma once

#include "network/solid_elements.h"

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <vector>

namespace limber {

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
