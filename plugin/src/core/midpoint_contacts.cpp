// SPDX-License-Identifier: Zlib
#include "core/midpoint_contacts.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

constexpr int kMostSweeps = 50;
constexpr double kLargestLeft = 1e-12;  ///< m, of the last sweep's largest correction

/// Share of a penetration taken back per substep and the speed (m/s) it may cost, as in contact_rows.cpp.
constexpr double kRecovery = 0.2;
constexpr double kRecoverySpeed = 0.5;

/// m: how far below its surface the row's point may end, at most 0.
double allowedGap(const ContactRow& row, const Points& start, double time, double h) {
  const double gap = row.normal.dot(start.col(row.point) - row.touch - time * row.surfaceVelocity);
  return gap >= 0.0 ? 0.0 : gap + std::min(-kRecovery * gap, kRecoverySpeed * h);
}

/// Corrects the load of row r; returns by how far (m) its point was off at the midpoint.
double solveRow(MidpointContacts& c, std::size_t r, const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                double allowed, double time, double h) {
  const ContactRow& row = (*c.rows)[r];
  const auto at = static_cast<Eigen::Index>(r);
  const double mobility = row.normal.dot(c.response.block<3, 3>(3 * at, 3 * at) * row.normal);
  if (!(mobility > 0.0)) return 0.0;
  const Eigen::Vector3d before = c.load.col(at) + c.change.col(at);
  const double gap = row.normal.dot(end - row.touch - (time + h) * row.surfaceVelocity) - allowed;
  const double normal = std::max(0.0, row.normal.dot(before) - 0.5 * gap / mobility);
  const Eigen::Vector3d slip = end - start - h * row.surfaceVelocity;
  const Eigen::Vector3d sliding = slip - row.normal.dot(slip) * row.normal;
  Eigen::Vector3d tangential = before - row.normal.dot(before) * row.normal - 0.5 / mobility * sliding;
  const double most = row.friction * normal, size = tangential.norm();
  if (size > most) tangential *= most > 0.0 ? most / size : 0.0;
  const Eigen::Vector3d correction = normal * row.normal + tangential - before;
  c.change.col(at) += correction;
  return mobility * correction.norm();
}

}  // namespace

void prepare(MidpointContacts& c, std::vector<ContactRow>* rows, MidpointSolver& solver) {
  c.rows = rows;
  const auto count = static_cast<Eigen::Index>(rows ? rows->size() : 0);
  c.load.setZero(3, count);
  c.change.setZero(3, count);
  c.response.resize(3 * count, 3 * count);
  c.unit.resize(3, solver.inverseMass.cols());
  for (Eigen::Index s = 0; s < count; ++s) {
    const std::uint32_t point = (*rows)[static_cast<std::size_t>(s)].point;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      c.unit.setZero();
      if (solver.inverseMass(axis, point) > 0.0) {
        c.unit(axis, point) = 1.0;
        solve(solver, c.unit);
      }
      for (Eigen::Index r = 0; r < count; ++r)
        c.response.block<3, 1>(3 * r, 3 * s + axis) = c.unit.col((*rows)[static_cast<std::size_t>(r)].point);
    }
  }
}

void solveLoads(MidpointContacts& c, const Points& midpoint, const Points& start, double time, double h) {
  c.change.setZero();
  const std::size_t count = c.rows->size();
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double largest = 0.0;
    for (std::size_t r = 0; r < count; ++r) {
      const ContactRow& row = (*c.rows)[r];
      const Eigen::Vector3d moved = c.response.middleRows<3>(3 * static_cast<Eigen::Index>(r)) *
                                    Eigen::Map<const Eigen::VectorXd>(c.change.data(), c.change.size());
      const Eigen::Vector3d x0 = start.col(row.point);
      const Eigen::Vector3d end = 2.0 * (midpoint.col(row.point) + moved) - x0;
      const double allowed = allowedGap(row, start, time, h);
      largest = std::max(largest, solveRow(c, r, x0, end, allowed, time, h));
    }
    if (largest < kLargestLeft) return;
  }
}

void addLoads(const MidpointContacts& c, const Points& loads, Points& rightHandSide) {
  for (std::size_t r = 0; r < c.rows->size(); ++r)
    rightHandSide.col((*c.rows)[r].point) += loads.col(static_cast<Eigen::Index>(r));
}

void settle(MidpointContacts& c, PointState& state, double h) {
  for (std::size_t r = 0; r < c.rows->size(); ++r) {
    ContactRow& row = (*c.rows)[r];
    const Eigen::Vector3d load = c.load.col(static_cast<Eigen::Index>(r));
    const double normal = row.normal.dot(load);
    row.touching = normal > 0.0;
    row.impulse += 4.0 / h * load;
    if (!row.touching) continue;
    // the end velocity 2 v_m - v0 of a point that was stopped would throw it back
    const Eigen::Vector3d relative = state.velocity.col(row.point) - row.surfaceVelocity;
    const Eigen::Vector3d across = row.normal.dot(relative) * row.normal;
    const bool sticks = (load - normal * row.normal).norm() < row.friction * normal;
    const Eigen::Vector3d stopped = sticks ? relative : across;
    row.impulse -= stopped / state.inverseMass.col(row.point).maxCoeff();
    state.velocity.col(row.point) -= stopped;
  }
}

}  // namespace limber
