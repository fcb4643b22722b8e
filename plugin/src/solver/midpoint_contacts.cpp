// SPDX-License-Identifier: Zlib
// Solves contacts in a substep of the implicit midpoint rule.
#include "solver/implicit_step.h"

namespace limber {
namespace {

constexpr int kMaxLoadSweeps = 50;

/// Share of the radius: points that penetrate an unfollowed surface by more repeat the substep.
constexpr double kMinPenetration = 0.01;

/// m: the gap that the row's point may have at the end, at most 0.
double allowedGap(const PlaneContact& row, const Eigen::Vector3d& start, const ContactSpan& span) {
  const double gap = row.normal.dot(start - row.touch - span.time * row.surfaceVelocity);
  return gap + span.duration * minSpeed(gap, row.recoverySpeed, span.duration);
}

/// Computes the columns of W of a touched point. Each needs a solution for the whole body.
void computeResponse(MidpointContacts& c, MidpointSolver& solver, Eigen::Index index) {
  char& responds = c.responds[static_cast<std::size_t>(index)];
  if (responds) return;
  responds = 1;
  const auto count = static_cast<Eigen::Index>(c.touched.size());
  const std::uint32_t point = c.touched[static_cast<std::size_t>(index)];
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (!(solver.inverseMass(axis, point) > 0.0)) continue;
    c.unit.setZero();
    c.unit(axis, point) = 1.0;
    solve(solver, c.unit);
    for (Eigen::Index r = 0; r < count; ++r)
      c.response.block<3, 1>(3 * r, 3 * index + axis) = c.unit.col(c.touched[static_cast<std::size_t>(r)]);
  }
}

/// Returns the largest eigenvalue of the symmetric matrix in the plane across `normal`. A body that is nearly
/// rigid may give way along the plane far more easily than along the normal: loads corrected with the
/// normal's mobility would grow in each sweep.
double largestAcross(const Eigen::Vector3d& normal, const Eigen::Matrix3d& matrix) {
  const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u), mu = matrix * u;
  const double a = u.dot(mu), b = v.dot(mu), c = v.dot(matrix * v);
  return 0.5 * (a + c) + std::hypot(0.5 * (a - c), b);
}

/// Corrects the load of a row whose point moves from `start` to `end`; returns its error (m).
double solveRow(MidpointContacts& c, MidpointSolver& solver, const PlaneContact& row, RowLoad& load,
                const Eigen::Vector3d& start, const Eigen::Vector3d& end, const ContactSpan& span) {
  const Eigen::Index first = 3 * load.pointIndex;
  const Eigen::Vector3d before = load.load + load.change;
  const Eigen::Vector3d surface = row.touch + (span.time + span.duration) * row.surfaceVelocity;
  const double gap = row.normal.dot(end - surface) - allowedGap(row, start, span);
  if (gap >= 0.0 && before.isZero(0.0)) return 0.0;
  computeResponse(c, solver, load.pointIndex);
  const Eigen::Matrix3d response = span.displacementFactor * c.response.block<3, 3>(first, first);
  const double mobility = row.normal.dot(response * row.normal);
  if (!(mobility > 0.0)) return 0.0;
  const double normal = std::max(0.0, row.normal.dot(before) - gap / mobility);
  const Eigen::Vector3d slip = end - start - span.duration * row.surfaceVelocity;
  const Eigen::Vector3d sliding = slip - row.normal.dot(slip) * row.normal;
  Eigen::Vector3d tangential =
      before - row.normal.dot(before) * row.normal - sliding / largestAcross(row.normal, response);
  tangential *= coneFactor(tangential.squaredNorm(), row.friction * normal);
  const Eigen::Vector3d correction = normal * row.normal + tangential - before;
  load.change += correction;
  c.changeAt.segment<3>(first) += correction;
  return mobility * correction.norm();
}

/// Loads this close to the friction cone slide: rounding must not make them stick.
constexpr double kConeMargin = 1e-9;

bool leadsThrough(const PlaneContact& row, const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                  const ContactSpan& span) {
  if (!row.around || row.away) return false;
  const double gap = row.normal.dot(end - row.touch);
  return gap < allowedGap(row, start, span) - kMinPenetration * row.around->radius;
}

}  // namespace

void startSubstep(MidpointContacts& c, std::vector<PlaneContact>* rows, Eigen::Index points,
                  double tolerance) {
  constexpr Eigen::Index kStep = 8;
  c.tolerance = tolerance;
  c.rows = rows;
  c.touched.clear();
  c.loads.clear();
  for (std::size_t r = 0; rows && r < rows->size(); ++r) {
    const PlaneContact& row = (*rows)[r];
    if (c.touched.empty() || c.touched.back() != row.point) c.touched.push_back(row.point);
    c.loads.push_back({static_cast<Eigen::Index>(c.touched.size()) - 1, row.impulse});
  }
  const auto touched = static_cast<Eigen::Index>(c.touched.size());
  if (3 * touched <= c.changeAt.size()) return;
  const Eigen::Index capacity = (touched + kStep - 1) / kStep * kStep;
  c.changeAt.resize(3 * capacity);
  c.response.resize(3 * capacity, 3 * capacity);
  c.responds.reserve(static_cast<std::size_t>(capacity));
  c.unit.resize(3, points);
}

void forgetResponse(MidpointContacts& c) {
  const auto size = 3 * static_cast<Eigen::Index>(c.touched.size());
  c.response.topLeftCorner(size, size).setZero();
  c.responds.assign(c.touched.size(), 0);
}

void solveLoads(MidpointContacts& c, MidpointSolver& solver, const Points& found, const Points& start,
                const ContactSpan& span) {
  const auto size = 3 * static_cast<Eigen::Index>(c.touched.size());
  for (RowLoad& load : c.loads) load.change.setZero();
  c.changeAt.setZero();
  for (int sweep = 0; sweep < kMaxLoadSweeps; ++sweep) {
    double largest = 0.0;
    for (std::size_t r = 0; r < c.loads.size(); ++r) {
      const PlaneContact& row = (*c.rows)[r];
      if (row.away) continue;
      const Eigen::Vector3d moved =
          c.response.block(3 * c.loads[r].pointIndex, 0, 3, size) * c.changeAt.head(size);
      const Eigen::Vector3d x0 = start.col(row.point);
      const Eigen::Vector3d end = x0 + span.displacementFactor * (found.col(row.point) + moved - x0);
      largest = std::max(largest, solveRow(c, solver, row, c.loads[r], x0, end, span));
    }
    if (largest <= c.tolerance) return;
  }
}

bool followDisplacement(MidpointContacts& c, const Points& found, const PointView& start,
                        const ContactSpan& span) {
  std::vector<PlaneContact>& rows = *c.rows;
  c.trial = rows;
  bool through = false;
  for (std::size_t begin = 0, end = 0; begin < rows.size(); begin = end) {
    const std::uint32_t point = rows[begin].point;
    bool follows = false;
    for (; end < rows.size() && rows[end].point == point; ++end) follows = follows || rows[end].around;
    if (!follows) continue;
    const Eigen::Vector3d x = start.positionOf(point),
                          displacement = span.displacementFactor * (found.col(point) - x);
    followSurface(&c.trial[begin], end - begin, start, displacement, 0.0);
    for (std::size_t r = begin; r < end; ++r)
      through = through || leadsThrough(c.trial[r], x, x + displacement, span);
  }
  if (!through) return false;
  std::copy(c.trial.begin(), c.trial.end(), rows.begin());
  for (RowLoad& load : c.loads) load.load.setZero();
  return true;
}

bool hasLoads(const MidpointContacts& c) {
  return std::any_of(c.loads.begin(), c.loads.end(), [](const RowLoad& l) { return !l.load.isZero(0.0); });
}

void addLoads(const MidpointContacts& c, Eigen::Vector3d RowLoad::*part, Points& rightHandSide) {
  for (std::size_t r = 0; r < c.loads.size(); ++r) rightHandSide.col((*c.rows)[r].point) += c.loads[r].*part;
}

void finishSpan(MidpointContacts& c, PointState& state, const ContactSpan& span) {
  // the force F = 4 / h^2 l acts during the span, which is displacementFactor h/2 long
  const double impulsePerLoad = span.displacementFactor * span.displacementFactor / span.duration;
  for (std::size_t r = 0; r < c.loads.size(); ++r) {
    PlaneContact& row = (*c.rows)[r];
    const Eigen::Vector3d& load = c.loads[r].load;
    const double normal = row.normal.dot(load);
    row.touching = normal > 0.0;
    row.impulse.add(impulsePerLoad * load, row.normal, impulsePerLoad * normal);
    if (!row.touching) continue;
    // the midpoint rule's end velocity 2 v_m - v0 would throw back a point that was stopped
    const Eigen::Vector3d relative = state.velocity.col(row.point) - row.surfaceVelocity;
    const double mobility = state.inverseMass.col(row.point).maxCoeff(), speed = row.normal.dot(relative);
    // at most the impulse of the surface, which does not pull
    const double removedSpeed = std::min(speed, mobility * impulsePerLoad * normal);
    const bool sticks = (load - normal * row.normal).norm() < (1.0 - kConeMargin) * row.friction * normal;
    const Eigen::Vector3d alongNormal = removedSpeed * row.normal;
    const Eigen::Vector3d removed =
        sticks ? Eigen::Vector3d(relative - speed * row.normal + alongNormal) : alongNormal;
    row.impulse.add(-removed / mobility, row.normal, -removedSpeed / mobility);
    state.velocity.col(row.point) -= removed;
  }
}

void undo(MidpointContacts& c) {
  for (std::size_t r = 0; r < c.loads.size(); ++r) (*c.rows)[r].impulse = c.loads[r].impulseBefore;
}

}  // namespace limber
