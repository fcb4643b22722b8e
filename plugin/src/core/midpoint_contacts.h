// SPDX-License-Identifier: Zlib
#pragma once

#include "core/contact_rows.h"
#include "core/midpoint_solver.h"

#include <vector>

namespace limber {

/// Contact rows in a substep of the implicit midpoint rule. A force F at one point moves all of them, by
///     x_m += W l,   l = h^2/4 F,   W = the touched points' part of A^-1,
/// so the rows are solved together, by projected Gauss-Seidel on W (Jourdan, Alart, Jean 1998).
struct MidpointContacts {
  std::vector<ContactRow>* rows = nullptr;
  Eigen::MatrixXd response;  ///< W, 3 #rows x 3 #rows, m per kg m
  Points load;               ///< 3 x #rows, l, kg m
  Points change;             ///< 3 x #rows, of l in this iteration
  Points unit;               ///< 3 x #points, scratch
};

/// More rows than this cost more than stepping the body by Verlet.
constexpr std::size_t kMostMidpointRows = 48;

/// Computes W; `solver` must be up to date.
void prepare(MidpointContacts& contacts, std::vector<ContactRow>* rows, MidpointSolver& solver);

/// Finds the change of the loads after which no row is violated at the end of the substep, with the midpoint
/// positions at `midpoint` (3 x #points, m) and the starting ones at `start`.
void solveLoads(MidpointContacts& contacts, const Points& midpoint, const Points& start, double time,
                double h);

/// Adds the loads, or their change, to the 3 x #points right hand side.
void addLoads(const MidpointContacts& contacts, const Points& loads, Points& rightHandSide);

/// At the end of a substep: points that bear a load stay with the surface, and the rows get their impulses.
void settle(MidpointContacts& contacts, PointState& state, double h);

}  // namespace limber
