// SPDX-License-Identifier: Zlib

// Steps a soft body by the implicit midpoint rule, with its contacts. Its linear systems have a constant
// matrix that bodies share, or that of Newton's method.

#pragma once

#include "mesh/linear_algebra.h"
#include "solver/verlet_step.h"

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

// --- contacts in a substep ---------------------------------------------------------------------------------

/// The load of a contact row in a substep.
struct RowLoad {
  Eigen::Index pointIndex;                         ///< index of the row's point in MidpointContacts::touched
  TickImpulse impulseBefore;                       ///< the row's impulse at the start of the substep
  Eigen::Vector3d load = Eigen::Vector3d::Zero();  ///< l, kg m
  Eigen::Vector3d change = Eigen::Vector3d::Zero();  ///< of l in this iteration
};

/// Contact rows in a substep of the implicit midpoint rule. A force F at one point moves all points, by
///     x_m += W l,   l = h^2/4 F,   W = the part of A^-1 for the points with rows,
/// so the rows are solved together, by projected Gauss-Seidel on W (Jourdan, Alart, Jean 1998).
struct MidpointContacts {
  std::vector<PlaneContact>* rows = nullptr;  ///< not nullptr if there are loads
  std::vector<RowLoad> loads;                 ///< #rows
  double tolerance = 0.0;                     ///< m, sweeps end when the largest correction is smaller
  std::vector<std::uint32_t> touched;         ///< points that have rows
  Eigen::MatrixXd response;                   ///< W, 3 #touched x 3 #touched or larger, 1/kg
  std::vector<char> responds;  ///< #touched, whether the point's columns of W are computed; else they are 0
  Eigen::VectorXd changeAt;    ///< 3 #touched or more, sums of the changes at each point
  Points unit;                 ///< 3 x #points, scratch
  std::vector<PlaneContact> trial;  ///< #rows, scratch
};

/// Largest number of points with rows. With more of them, Verlet is cheaper.
constexpr std::size_t kMaxMidpointPoints = 48;

/// Starts a substep with these rows (nullptr: none) and without loads. Sweeps end when no correction exceeds
/// `tolerance` (m).
void startSubstep(MidpointContacts& contacts, std::vector<PlaneContact>* rows, Eigen::Index points,
                  double tolerance);

/// Discards W. solveLoads() computes the columns that it needs.
void forgetResponse(MidpointContacts& contacts);

/// The part of a tick that is solved: `duration` seconds from `time` on. The displacement of a point is
/// `displacementFactor` times that from its start to the position found by the iterations; 2 for the midpoint
/// rule.
struct ContactSpan {
  double time, duration, displacementFactor;
};

/// Computes the change of the loads after which no row is violated at the end of the span. The iterations
/// have found the positions `found` (3 x #points, m); those of the start are `start`. `solver` must be up to
/// date.
void solveLoads(MidpointContacts& contacts, MidpointSolver& solver, const Points& found, const Points& start,
                const ContactSpan& span);

/// Tests whether the displacements found by the iterations lead through surfaces that the rows do not follow:
/// in a long step, forces can lead elsewhere than the first velocities. If so, updates the rows to the
/// surfaces on these displacements, removes all loads and returns true.
bool followDisplacement(MidpointContacts& contacts, const Points& found, const PointView& start,
                        const ContactSpan& span);

/// Whether any row has a load. Rows of surfaces that are only near have none.
bool hasLoads(const MidpointContacts& contacts);

/// Adds the loads, or their change, to the 3 x #points right hand side.
void addLoads(const MidpointContacts& contacts, Eigen::Vector3d RowLoad::*part, Points& rightHandSide);

/// Finishes a span of h/2 (displacementFactor 1) or h: points with a load stay at the surface, and the rows
/// get their impulses.
void finishSpan(MidpointContacts& contacts, PointState& state, const ContactSpan& span);

/// Restores the rows' impulses of the start of the substep.
void undo(MidpointContacts& contacts);

// --- the step ----------------------------------------------------------------------------------------------

/// State of a body that stepImplicit keeps from substep to substep.
struct ImplicitState {
  MidpointSolver solver;
  MidpointContacts contacts;
  Points start, startVelocity;  ///< 3 x #points, m and m/s, at the start of the substep
  Points damperDirection;       ///< 3 x #springs, unit vectors or 0
  Points residual, trial;       ///< 3 x #points, scratch
  double energyFloor = 0.0;     ///< J, the lowest energy so far, plus the work and other changes since
  double energyAtEnd = 0.0;     ///< J, at the end of the last tick
  double floorAtStart = 0.0, energyAtStart = 0.0;  ///< J, both at the start of this tick, for another try
  Points meanAcceleration;                         ///< 3 x #points, m/s^2, of the last substep
  double remainder = 0.0;                          ///< m, estimated movement of further iterations
  double meanOver = 0.0;  ///< s, substep of meanAcceleration; 0: none, or the body was moved otherwise
};

/// Whether stepImplicit can step the body: points held along all axes or none, no elastic limit, not more
/// contacts than it solves, and none with restitution or a moving surface.
bool canStepImplicitly(const SolverBody& body);

/// Advances one body without links by `tick` seconds in `substeps` substeps of h of the implicit midpoint
/// rule
///
///     x1 = x0 + h v_m,   v1 = v0 + h (a + M^-1 f(x_m)),   x_m = (x0 + x1) / 2,   v_m = (v0 + v1) / 2,
///
/// solved for x_m by iterating  x_m += A^-1 (M (y - x_m) + h^2/4 f(x_m)),  y = x0 + h/2 v0 + h^2/4 a,  with
/// the matrix of either kind (MidpointSolver): local/global iterations (Liu and others 2013; Dinev and
/// others 2018 for the midpoint rule) or Newton's method. Second order; linear momentum is exact at every
/// iteration, angular momentum when converged. Energy that rounding of the iterations or the nonlinearity
/// would add is removed from the internal motion (removeKineticEnergy). Allocates if the body, its springs or
/// h are new.
///
/// Returns false if it found no motion without additional energy, as for dampers or friction so strong that
/// rounding errors prevail. The states of the body and of `implicit` then are of no use.
bool stepImplicit(SolverBody& body, ImplicitState& implicit, MidpointSolver::Kind kind, double tick,
                  int substeps, SharedFactors& factors);

}  // namespace limber
