// SPDX-License-Identifier: Zlib
// Declares finite elements of a homogeneous isotropic solid: linear and quadratic tetrahedra.
#pragma once

#include "network/tetrahedra.h"

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

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

}  // namespace limber
