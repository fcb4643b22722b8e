// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/banded_matrix.h"
#include "solver/linear_algebra.h"
#include "solver/shared_factor.h"
#include "solver/volumes.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace limber {

/// More closed surfaces in a body than this are stepped by Verlet.
constexpr int kMostSolvedVolumes = 8;
static_assert(kMostSolvedVolumes <= kMostSmall);

/// What the volume term adds to a matrix A: sum d g g^T over the components, g the gradient of the volume and
/// d = h^2/4 K / V0. By Sherman, Morrison and Woodbury
///     (A + G D G^T)^-1 b = x - Z (D^-1 + G^T Z)^-1 G^T x,   x = A^-1 b,   Z = A^-1 G.
struct VolumeUpdate {
  std::vector<Points> gradient, response;  ///< #components: g and A^-1 g
  SmallMatrix inner;                       ///< D^-1 + G^T Z
};

/// The linear system of one iteration of the implicit midpoint rule, solved in one of two ways.
struct MidpointSolver {
  enum class Kind : std::uint8_t {
    Shared,  ///< one constant matrix, see shared_factor.h: cheap iterations that converge slowly
    Newton   ///< the matrix at the present positions, banded: dear ones that converge fast
  } kind = Kind::Shared;

  double substep = 0.0;   ///< s, the h it is prepared for
  unsigned revision = 0;  ///< of the springs it is prepared for
  Points inverseMass;     ///< the one it is prepared for

  std::shared_ptr<const SharedFactor> shared;
  std::vector<double> dampingWeights;  ///< #springs, kg
  std::vector<std::uint32_t> place;    ///< #points, in the banded matrix
  BandedMatrix banded;                 ///< factors, 3 #points rows
  Eigen::VectorXd ordered;             ///< 3 #points, scratch
  Points scratch;                      ///< 3 x #points
  VolumeUpdate volumes;
};

/// Makes the solver ready for bodies with these springs and masses and substeps of h seconds. Allocates and
/// factorises only if something has changed.
void prepare(MidpointSolver& solver, const ElasticParts& parts, const Points& inverseMass, double h,
             SharedFactors& factors);

/// For Newton: assembles and factorises the matrix at `position` with the springs' present directions n
/// and the dampers' m (3 x #springs),
///     M + sum (h^2/4 k (n n^T + max(0, 1 - L/l) (1 - n n^T)) + h/2 c (1 + beta) m m^T),
/// whose clamp keeps it positive definite under compression (Choi, Ko 2002, section 4); and of each
/// tetrahedron  h^2/4 s g g^T  with the stiffness s and gradient g of its volume.
void update(MidpointSolver& solver, const ElasticParts& parts, const Points& damperDirection,
            const Points& position);

/// Adds the volume term at the present positions to the matrix; after update().
void updateVolumes(MidpointSolver& solver, const VolumeArrays& volumes, const PointState& state);

/// Solves A x = b in place; b is 3 x #points.
void solve(MidpointSolver& solver, Points& b);

}  // namespace limber
