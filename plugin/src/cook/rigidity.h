// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/stiffness_matrix.h"

#include <limber/spring_network.h>

#include <Eigen/Core>

namespace limber {

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

}  // namespace limber
