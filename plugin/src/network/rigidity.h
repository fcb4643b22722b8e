// SPDX-License-Identifier: Zlib
// Declares the pieces of a network that springs hold together, and what is known of their small deformations:
// stiffness, mechanisms, soft modes and global rigidity.
#pragma once

#include <limber/spring_network.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <cstdint>
#include <functional>
#include <vector>

namespace limber {

/// The points of each piece that springs hold together, ascending; pieces in the order of their first points.
std::vector<std::vector<Eigen::Index>> findPieces(const SpringNetwork& network);

/// These points and what joins no others, with shares of the mass that sum to 1. Its report says how whole
/// the surface is that comes along; it has no render surface.
SpringNetwork pieceOf(const SpringNetwork& network, const std::vector<Eigen::Index>& points);

using SparseMatrix = Eigen::SparseMatrix<double>;

/// #springs x 3 #points: row s holds  sqrt(k) n  at the end b of spring s and  -sqrt(k) n  at a, n the unit
/// vector from a to b, k the spring's stiffnessScale. A motion u of the points stretches spring s by
/// (R u)_s / sqrt(k); springs without length or stiffness have empty rows.
SparseMatrix rigidityMatrix(const SpringNetwork& network);

/// 3 #points x 3 #points, N/m: the Hessian  R^T R  of the springs' energy at rest.
SparseMatrix stiffnessMatrix(const SparseMatrix& rigidity);

/// Orthonormal basis of the rigid motions of these points, 3 #points x 6; 5 columns for points on a line, 3
/// for a single one.
Eigen::MatrixXd rigidMotions(const std::vector<Eigen::Vector3d>& points);

/// Small deformations of a network about its rest shape, with unit masses and each spring's constant its
/// stiffnessScale; the volume term is not in them.
struct SmallDeformations {
  std::size_t rank = 0, mechanisms = 0, selfStresses = 0;
  double softest = 0.0,
         stiffest = 0.0;  ///< eigenvalues of the stiffness matrix, mechanisms and rigid motions apart
};

SmallDeformations smallDeformations(const SpringNetwork& network);

/// Of a stiffness matrix.
double stiffestEigenvalue(const SparseMatrix& stiffness);

/// The softest oscillations, mechanisms first, rigid motions left out.
struct Modes {
  Eigen::VectorXd eigenvalues;  ///< #modes, ascending
  Eigen::MatrixXd shapes;       ///< 3 #points x #modes, orthonormal
};

/// The `count` softest modes (fewer if there are fewer). Sparse: seconds for 5 000 points.
Modes softestModes(const SpringNetwork& network, std::size_t count);

/// Shapes that are soft, though none of them a mode: the softest come close, the last are rough. Each
/// eigenvalue is what its shape has (Rayleigh), never too small. A fraction of the time of softestModes().
Modes roughModes(const SpringNetwork& network, std::size_t count);

/// More points than this take longer than seconds.
constexpr std::size_t kMaxForGlobalRigidity = 1000;

/// Whether the graph of the springs is generically globally rigid in space: of all places of the points with
/// these spring lengths there is but one up to rigid motions and reflections, unless the points are in
/// special position. Then, and only then, is the rank of a random equilibrium stress matrix of a random
/// placement #points - 4 (Gortler, Healy, Thurston 2010, theorem 1.14 and section 5; graphs of at most 4
/// points: when all are joined). Computed in a finite field, where ranks are exact: a yes is certain, a no
/// wrong with a probability of less than 1e-5. Up to kMaxForGlobalRigidity points.
/// Once `goOn`, asked with the share done, 0 to 1, says no, the answer means nothing.
bool isGloballyRigid(const SpringNetwork& network, std::uint64_t seed = 1,
                     const std::function<bool(double)>& goOn = {});

}  // namespace limber
