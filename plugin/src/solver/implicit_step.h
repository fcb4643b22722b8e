// SPDX-License-Identifier: Zlib
#pragma once

// Steps a soft body by the implicit midpoint rule, with its contacts.

#include "solver/midpoint_solver.h"
#include "solver/plane_contacts.h"
#include "solver/verlet_step.h"

#include <vector>

namespace limber {

// --- contacts in a substep ---------------------------------------------------------------------------------

/// Contact rows in a substep of the implicit midpoint rule. A force F at one point moves all of them, by
///     x_m += W l,   l = h^2/4 F,   W = the touched points' part of A^-1,
/// so the rows are solved together, by projected Gauss-Seidel on W (Jourdan, Alart, Jean 1998).
struct MidpointContacts {
  std::vector<PlaneContact>* rows = nullptr;
  double enough = 0.0;                 ///< m, of the last sweep's largest correction
  Eigen::Index count = 0;              ///< #rows; the arrays have room for more and grow only
  std::vector<std::uint32_t> touched;  ///< points that have rows
  std::vector<Eigen::Index> place;     ///< #rows, of the row's point among them
  Eigen::MatrixXd response;            ///< W, 3 #touched x 3 #touched, 1/kg
  std::vector<char> responds;  ///< #touched, whether the point's columns of W are there; else they are 0
  Points load;                 ///< 3 x #rows, l, kg m
  Points change;               ///< 3 x #rows, of l in this iteration
  Eigen::VectorXd changeAt;    ///< 3 #touched, the sums of `change`
  std::vector<TickImpulse> impulseBefore;  ///< #rows, the rows' impulses at the start
  Points unit;                             ///< 3 x #points, scratch
  std::vector<PlaneContact> trial;         ///< #rows, scratch
};

/// More points with rows than this cost more than stepping the body by Verlet.
constexpr std::size_t kMaxMidpointPoints = 48;

/// Starts a substep with these rows (nullptr: none) and no loads. Sweeps that correct no place by more than
/// `enough` (m) end.
void startSubstep(MidpointContacts& contacts, std::vector<PlaneContact>* rows, Eigen::Index points,
                  double enough);

/// Forgets W, of which solveLoads() computes what it needs.
void forgetResponse(MidpointContacts& contacts);

/// The part of a tick that is solved for: from `time` on, `duration` seconds long, in which a point goes
/// `reach` times as far as from its start to the position that the iterations find; 2 for the midpoint rule.
struct ContactSpan {
  double time, duration, reach;
};

/// Finds the change of the loads after which no row is violated at the end of the span, with the positions
/// that the iterations have found at `found` (3 x #points, m) and those of the start at `start`. `solver`
/// must be up to date.
void solveLoads(MidpointContacts& contacts, MidpointSolver& solver, const Points& found, const Points& start,
                const ContactSpan& span);

/// Looks along the ways that the iterations have found for surfaces that the rows do not follow, because the
/// forces of so long a step lead elsewhere than its first velocities. If a way leads through one, gives the
/// rows what is on their ways, and no loads, and returns true.
bool followDisplacement(MidpointContacts& contacts, const Points& found, const PointView& start,
                        const ContactSpan& span);

/// Whether any row bears a load. Rows of what is only near change nothing.
bool bears(const MidpointContacts& contacts);

/// Adds the loads, or their change, to the 3 x #points right hand side.
void addLoads(const MidpointContacts& contacts, const Points& loads, Points& rightHandSide);

/// At the end of a span of h/2 (reach 1) or h: points that bear a load stay with the surface, and the rows
/// get their impulses.
void settle(MidpointContacts& contacts, PointState& state, const ContactSpan& span);

/// Gives the rows the impulses they had at the start.
void undo(MidpointContacts& contacts);

// --- the step ----------------------------------------------------------------------------------------------

/// What stepImplicit keeps of a body from substep to substep.
struct ImplicitState {
  MidpointSolver solver;
  MidpointContacts contacts;
  Points start, startVelocity;  ///< 3 x #points, m and m/s, at the start of the substep
  Points damperDirection;       ///< 3 x #springs, unit vectors or 0
  Points residual, trial;       ///< 3 x #points, scratch
  double energyFloor = 0.0;     ///< J, the least energy it has had, work done on it and other changes added
  double energyAtEnd = 0.0;     ///< J, at the end of the last tick
  Points meanAcceleration;      ///< 3 x #points, m/s^2, of the last substep
  double remainder = 0.0;       ///< m, what further iterations would move
  double meanOver = 0.0;        ///< s, how long that was; 0: none, or the body has moved otherwise since
};

/// Whether stepImplicit can step the body: points are held along all axes or none, no elastic limit, not more
/// contacts than it solves, and none with a moving surface.
bool canStepImplicitly(const SolverBody& body);

/// Advances one body without links by `tick` seconds in `substeps` substeps of h of the implicit midpoint
/// rule
///
///     x1 = x0 + h v_m,   v1 = v0 + h (a + M^-1 f(x_m)),   x_m = (x0 + x1) / 2,   v_m = (v0 + v1) / 2,
///
/// solved for x_m by iterating  x_m += A^-1 (M (y - x_m) + h^2/4 f(x_m)),  y = x0 + h/2 v0 + h^2/4 a,  with
/// the matrix of either kind (midpoint_solver.h): local/global iterations (Liu and others 2013; Dinev and
/// others 2018 for the midpoint rule) or Newton's method. Second order; linear momentum is exact at every
/// iteration, angular momentum when converged. Where rounding of the iterations or the nonlinearity would add
/// energy, it is taken out of the internal motion (removeKineticEnergy). Allocates when the body, its springs
/// or h are new.
void stepImplicit(SolverBody& body, ImplicitState& implicit, MidpointSolver::Kind kind, double tick,
                  int substeps, SharedFactors& factors);

}  // namespace limber
