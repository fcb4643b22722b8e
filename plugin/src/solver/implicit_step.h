// SPDX-License-Identifier: Zlib
#pragma once

// Steps a soft body by the implicit midpoint rule, with its contacts.

#include "solver/midpoint_solver.h"
#include "solver/verlet_step.h"

#include <vector>

namespace limber {

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
/// the matrix of either kind (midpoint_solver.h): local/global iterations (Liu and others 2013; Dinev and
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
