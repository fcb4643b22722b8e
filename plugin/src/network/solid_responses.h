// SPDX-License-Identifier: Zlib
// Declares finite elements of a homogeneous isotropic solid, its slowest free vibrations, its response to
// several loads, and the fit of spring constants to that.
#pragma once

#include "network/tetrahedra.h"

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <array>
#include <cstdint>
#include <functional>
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

// --- vibrations --------------------------------------------------------------------------------------------

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

// --- responses to loads ------------------------------------------------------------------------------------

/// Self-equilibrated loads on the points of a mesh, and the compliance of the solid under them. A network
/// whose stiffness matrix is K should have  loads^T K^-1 loads = compliance.  The solid has a Young's modulus
/// of 1 Pa and a Poisson ratio of 1/4. The loads are scaled so that the compliances are near the unit matrix.
struct SolidResponses {
  Eigen::MatrixXd loads;       ///< 3 #points x #loads
  Eigen::MatrixXd compliance;  ///< #loads x #loads
  Eigen::MatrixXd weights;     ///< #loads x #loads: importance of an entry of the compliance; 0: not known
};

/// Returns the responses of the inside of the mesh to three groups of loads:
/// - the 6 uniform stresses;
/// - the 15 stresses that vary linearly and are in equilibrium without forces inside, such as those of
///   bending. Their displacements are of second degree. For these two groups the compliance of a solid of any
///   shape is known exactly: the integral of  s : C^-1 : s.
/// - the inertial forces of the slowest free vibrations, such as bending and torsion of the body and of its
///   limbs. Quadratic elements give their compliance. Above about 600 points, they are those of a coarser
///   filling; the compliance is that of linear elements on this mesh, plus what linear elements miss on the
///   coarser mesh times the squared ratio of the spacings (L. F. Richardson 1911). A body that cannot be
///   filled more coarsely goes without this group.
SolidResponses solidResponses(const TetrahedralMesh& mesh);

/// Smallest and largest constant (N/m) of each spring; above 0.
struct SpringLimits {
  std::vector<double> smallest, largest;
};

/// Changes the stiffnessScale of each spring, which is its constant (N/m) here, so that the network responds
/// to the loads like the solid. Minimises
///     sum over entries of the compliance |weight (measured - wanted)|^2
///     + kChangeWeight sum over springs share log(k / k0)^2
/// with the present constants k0 and the springs' shares of the sum of k L^2. Uses the method of Levenberg
/// and Marquardt for log k within the limits; each step is solved by conjugate gradients. The derivative of
/// the compliance of loads i, j is  -e_i e_j  for the constant of a spring with the extensions e. `goOn` is
/// called with the progress, 0 to 1; after it has returned false, no further steps are made. Returns the
/// largest stiffness that is left, relative to the wanted one, of all loads.
double fitResponses(SpringNetwork& network, const SolidResponses& wanted, const SpringLimits& limits,
                    const std::function<bool(double)>& goOn = {});

}  // namespace limber
