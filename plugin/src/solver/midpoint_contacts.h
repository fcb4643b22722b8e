// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/contact_rows.h"
#include "solver/midpoint_solver.h"

#include <vector>

namespace limber {

/// Contact rows in a substep of the implicit midpoint rule. A force F at one point moves all of them, by
///     x_m += W l,   l = h^2/4 F,   W = the touched points' part of A^-1,
/// so the rows are solved together, by projected Gauss-Seidel on W (Jourdan, Alart, Jean 1998).
struct MidpointContacts {
  std::vector<ContactRow>* rows = nullptr;
  double enough = 0.0;                 ///< m, of the last sweep's largest correction
  Eigen::Index count = 0;              ///< #rows; the arrays have room for more and grow only
  std::vector<std::uint32_t> touched;  ///< points that have rows
  std::vector<Eigen::Index> place;     ///< #rows, of the row's point among them
  Eigen::MatrixXd response;            ///< W, 3 #touched x 3 #touched, 1/kg
  std::vector<char> responds;          ///< #touched, whether the point's columns of W are there; else they are 0
  Points load;                         ///< 3 x #rows, l, kg m
  Points change;                       ///< 3 x #rows, of l in this iteration
  Eigen::VectorXd changeAt;            ///< 3 #touched, the sums of `change`
  std::vector<TickImpulse> impulseBefore;  ///< #rows, the rows' impulses at the start
  Points unit;               ///< 3 x #points, scratch
  std::vector<ContactRow> trial;  ///< #rows, scratch
};

/// More points with rows than this cost more than stepping the body by Verlet.
constexpr std::size_t kMostMidpointPoints = 48;

/// Starts a substep with these rows (nullptr: none) and no loads. Sweeps that correct no place by more than `enough`
/// (m) end.
void startSubstep(MidpointContacts& contacts, std::vector<ContactRow>* rows, Eigen::Index points, double enough);

/// Forgets W, of which solveLoads() computes what it needs.
void forgetResponse(MidpointContacts& contacts);

/// The part of a tick that is solved for: from `time` on, `duration` seconds long, in which a point goes
/// `reach` times as far as from its start to the position that the iterations find; 2 for the midpoint rule.
struct ContactSpan {
  double time, duration, reach;
};

/// Finds the change of the loads after which no row is violated at the end of the span, with the positions
/// that the iterations have found at `found` (3 x #points, m) and those of the start at `start`. `solver` must be
/// up to date.
void solveLoads(MidpointContacts& contacts, MidpointSolver& solver, const Points& found, const Points& start,
                const ContactSpan& span);

/// Looks along the ways that the iterations have found for surfaces that the rows do not follow, because the
/// forces of so long a step lead elsewhere than its first velocities. If a way leads through one, gives the
/// rows what is on their ways, and no loads, and returns true.
bool followWay(MidpointContacts& contacts, const Points& found, const PointView& start, const ContactSpan& span);

/// Whether any row bears a load. Rows of what is only near change nothing.
bool bears(const MidpointContacts& contacts);

/// Adds the loads, or their change, to the 3 x #points right hand side.
void addLoads(const MidpointContacts& contacts, const Points& loads, Points& rightHandSide);

/// At the end of a span of h/2 (reach 1) or h: points that bear a load stay with the surface, and the rows
/// get their impulses.
void settle(MidpointContacts& contacts, PointState& state, const ContactSpan& span);

/// Gives the rows the impulses they had at the start.
void undo(MidpointContacts& contacts);

}  // namespace limber
