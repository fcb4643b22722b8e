// SPDX-License-Identifier: Zlib
#pragma once

// The linear systems of the implicit midpoint rule: a constant matrix that bodies share, or that of Newton's
// method.

#include "mesh/linear_algebra.h"
#include "solver/springs.h"
#include "solver/volumes.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace limber {

// --- a matrix of blocks ------------------------------------------------------------------------------------

using PointPair = std::array<std::uint32_t, 2>;

/// A symmetric positive definite matrix A with a block for each pair of joined points, or its factors
///     P A P^T = L D L^T,   D of 3 x 3 blocks, L with unit blocks on its diagonal.
/// The permutation P keeps L sparse. Blocks are in the order of P, and those that the factorisation fills are
/// there from the start.
struct BlockMatrix {
  std::vector<std::uint32_t> place;    ///< #points, the row and column of each point
  std::vector<std::uint32_t> start;    ///< #points + 1, the first block of each column in `row` and `below`
  std::vector<std::uint32_t> row;      ///< #blocks below the diagonal, ascending in a column
  std::vector<Eigen::Matrix3d> below;  ///< the same, of A or L
  std::vector<Eigen::Matrix3d> diagonal;  ///< #points, of A, or the inverse blocks of D
  std::vector<Eigen::Matrix3d> column;    ///< scratch

  std::size_t points() const { return diagonal.size(); }
  /// Adds to A the block in the row of point i and the column of point j, which are joined or equal.
  void add(std::uint32_t i, std::uint32_t j, const Eigen::Matrix3d& block);
};

/// Returns the number of blocks below the diagonal in each column of the factors.
std::vector<std::uint32_t> fillOf(const std::vector<PointPair>& joined, std::size_t points);

/// Sets the pattern. Pairs may be repeated.
void setPattern(BlockMatrix& matrix, const std::vector<PointPair>& joined, std::size_t points);

void setZero(BlockMatrix& matrix);

/// Replaces A by its factors; allocates nothing. A pivot of 0 or less, which rounding can cause, becomes 1.
void factorise(BlockMatrix& matrix);

/// Solves A x = b in place with the factors. `x`: 3 x #points, in the order of the points.
void solve(const BlockMatrix& factors, Eigen::Matrix3Xd& x, Eigen::Matrix3Xd& scratch);

// --- the matrix that bodies share --------------------------------------------------------------------------

/// The matrix of the local/global iterations of the implicit midpoint rule and its factor
/// (Liu, Bargteil, O'Brien, Kavan 2013, equation 14, for substeps h of the midpoint rule):
///
///     A = M + sum over springs (h^2/4 k + h/2 c (1 + beta)) (e_a - e_b)(e_a - e_b)^T,  #points x #points,
///
/// and a sum over the tetrahedra. For any corner j, the square of a volume change
/// sum g_i . u_i = sum g_i . (u_i - u_j)  is at most  sum_(i not j) |g_i|^2  times  sum_i |u_i - u_j|^2.
/// Each tetrahedron adds the mean over its four corners j of
///
///     h^2/4 K/V0 sum_(i not j) |g_i|^2  sum_i (e_i - e_j)(e_i - e_j)^T,   g at rest.
///
/// A is an upper bound of the stiffness and damping in all directions, so that iterating with it converges.
/// It is the same for x, y and z and for any deformation: all bodies of a network with equal springs and
/// masses share it. Rows and columns of held points are those of the unit matrix.
struct SharedFactor {
  Eigen::SparseMatrix<double> matrix;  ///< A
  SparseFactor factor;

  /// Solves A x = b in place for all three coordinates; `scratch` is 3 x #points.
  void solve(Points& b, Points& scratch) const;
};

/// The parts of a body that resist deformation.
struct ElasticParts {
  const SpringArrays& springs;
  const TetrahedronVolumes* tetrahedra = nullptr;  ///< may be nullptr
};

/// Returns the pairs of points that springs or tetrahedra join, some of them more than once.
std::vector<PointPair> joinedPoints(const ElasticParts& parts);

using SharedFactors = SharedObjects<SharedFactor>;

// --- the system of an iteration ----------------------------------------------------------------------------

/// Returns beta, 0 to 1: how far a damper extrapolates velocity towards the end of a substep. The implicit
/// midpoint rule would use the mean velocity v_m. Then overdamped motion would oscillate: with z = c (wa +
/// wb) h the closing speed is multiplied by (1 - z/2) / (1 + z/2), close to -1. With v_m + beta (v_m - v0)
/// the factor is
///     (1 - z (1 - beta) / 2) / (1 + z (1 + beta) / 2),
/// and beta = z / (2 + z) keeps second order for small z and lets the speed decay for large z.
inline double lookAhead(double damping, double inverseMasses, double h) {
  const double z = damping * inverseMasses * h;
  return z / (2.0 + z);
}

/// Bodies with more closed surfaces are stepped by Verlet.
constexpr int kMaxSolvedVolumes = 8;
static_assert(kMaxSolvedVolumes <= kMaxSmall);

/// The volume term's addition to a matrix A: sum d g g^T over the components, with the gradient g of the
/// volume and d = h^2/4 K / V0. By Sherman, Morrison and Woodbury
///     (A + G D G^T)^-1 b = x - Z (D^-1 + G^T Z)^-1 G^T x,   x = A^-1 b,   Z = A^-1 G.
struct VolumeUpdate {
  std::vector<Points> gradient, response;  ///< #components: g and A^-1 g
  SmallMatrix inner;                       ///< D^-1 + G^T Z
};

/// The linear system of one iteration of the implicit midpoint rule, solved in one of two ways.
struct MidpointSolver {
  enum class Kind : std::uint8_t {
    Shared,  ///< one constant matrix, see SharedFactor: cheap iterations that converge slowly
    Newton   ///< the matrix at the present positions: expensive iterations that converge fast
  } kind = Kind::Shared;

  double substep = 0.0;   ///< s, the h at preparation
  unsigned revision = 0;  ///< of the springs at preparation
  Points inverseMass;     ///< 1/kg at preparation

  std::shared_ptr<const SharedFactor> shared;
  std::vector<double> dampingWeights;  ///< #springs, kg
  BlockMatrix newton;                  ///< factors
  Points scratch;                      ///< 3 x #points
  VolumeUpdate volumes;
};

/// Prepares the solver for bodies with these springs and masses and substeps of h seconds. Allocates and
/// factorises only after a change.
void prepare(MidpointSolver& solver, const ElasticParts& parts, const Points& inverseMass, double h,
             SharedFactors& factors);

/// For Newton: assembles and factorises the matrix at `position` with the present directions n of the springs
/// and m of the dampers (3 x #springs),
///     M + sum (h^2/4 k (n n^T + max(0, 1 - L/l) (1 - n n^T)) + h/2 c (1 + beta) m m^T).
/// Its clamp keeps it positive definite under compression (Choi, Ko 2002, section 4). Each tetrahedron adds
/// h^2/4 s g g^T  with the stiffness s and gradient g of its volume.
void update(MidpointSolver& solver, const ElasticParts& parts, const Points& damperDirection,
            const Points& position);

/// Adds the volume term at the present positions to the matrix. Call it after update().
void updateVolumes(MidpointSolver& solver, const VolumeArrays& volumes, const PointState& state);

/// Solves A x = b in place; b is 3 x #points.
void solve(MidpointSolver& solver, Points& b);

}  // namespace limber
