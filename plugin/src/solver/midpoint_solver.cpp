// SPDX-License-Identifier: Zlib
#include "solver/midpoint_solver.h"

#include "solver/midpoint_damping.h"
#include "solver/point_order.h"

#include <algorithm>

namespace limber {
namespace {

void prepareBanded(MidpointSolver& solver, const SpringArrays& springs) {
  const auto points = static_cast<std::size_t>(solver.inverseMass.cols());
  if (solver.place.size() != points) {
    solver.place = bandOrder(springs, points);
    const auto width = 3 * static_cast<Eigen::Index>(bandWidth(springs, solver.place)) + 2;
    solver.banded.resize(static_cast<Eigen::Index>(3 * points), width);
    solver.ordered.resize(static_cast<Eigen::Index>(3 * points));
  }
}

/// h^2/4 times the stiffness of spring s plus its damping weight, 3 x 3.
Eigen::Matrix3d springBlock(const MidpointSolver& solver, const SpringArrays& springs, std::size_t s,
                            const Points& damperDirection, const Points& position) {
  const Eigen::Vector3d m = damperDirection.col(static_cast<Eigen::Index>(s));
  const Eigen::Vector3d n = springs.direction.col(static_cast<Eigen::Index>(s));
  const double length = (position.col(springs.b[s]) - position.col(springs.a[s])).norm();
  const double stretch = length - springs.restLength[s];
  const double k = stretch > 0.0 ? springs.extensionStiffness[s] : springs.compressionStiffness[s];
  const double stiffness = 0.25 * solver.substep * solver.substep * k;
  const double sideways = length > 0.0 ? stiffness * std::max(0.0, stretch / length) : 0.0;
  const Eigen::Matrix3d along = n * n.transpose();
  return stiffness * along + solver.dampingWeights[s] * m * m.transpose() +
         sideways * (Eigen::Matrix3d::Identity() - along);
}

void addBlock(BandedMatrix& matrix, std::uint32_t rowPlace, std::uint32_t columnPlace,
              const Eigen::Matrix3d& block) {
  const Eigen::Index row = 3 * Eigen::Index{rowPlace}, column = 3 * Eigen::Index{columnPlace};
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      if (row + i >= column + j) matrix.at(row + i, column + j) += block(i, j);
}

/// Adds the block of a row of one point and the columns of another, above or below the diagonal; nothing if
/// either is held.
void addFree(MidpointSolver& solver, std::uint32_t rowPoint, std::uint32_t columnPoint,
             const Eigen::Matrix3d& block) {
  if (isHeld(solver.inverseMass, rowPoint) || isHeld(solver.inverseMass, columnPoint)) return;
  const std::uint32_t row = solver.place[rowPoint], column = solver.place[columnPoint];
  if (row >= column)
    addBlock(solver.banded, row, column, block);
  else
    addBlock(solver.banded, column, row, block.transpose());
}

void addMasses(MidpointSolver& solver) {
  for (Eigen::Index i = 0; i < solver.inverseMass.cols(); ++i)
    for (Eigen::Index c = 0; c < 3; ++c) {
      const Eigen::Index row = 3 * Eigen::Index{solver.place[static_cast<std::size_t>(i)]} + c;
      solver.banded.at(row, row) = isHeld(solver.inverseMass, i) ? 1.0 : massOf(solver.inverseMass, i);
    }
}

void addTetrahedra(MidpointSolver& solver, const TetrahedronVolumes& tetrahedra, const Points& position) {
  for (std::size_t t = 0; t < tetrahedra.tetrahedra.size(); ++t) {
    const TetrahedronSlope slope = tetrahedronSlope(tetrahedra, t, position);
    const double stiffness = 0.25 * solver.substep * solver.substep * slope.stiffness;
    if (stiffness == 0.0) continue;
    const Tetrahedron& corner = tetrahedra.tetrahedra[t];
    for (Eigen::Index i = 0; i < 4; ++i)
      for (Eigen::Index j = 0; j <= i; ++j)
        addFree(solver, corner[static_cast<std::size_t>(i)], corner[static_cast<std::size_t>(j)],
                stiffness * slope.gradient.col(i) * slope.gradient.col(j).transpose());
  }
}

}  // namespace

void prepare(MidpointSolver& solver, const ElasticParts& parts, const Points& inverseMass, double h,
             SharedFactors& factors) {
  const SpringArrays& springs = parts.springs;
  const bool same = solver.substep == h && solver.revision == springs.revision &&
                    solver.inverseMass.cols() == inverseMass.cols() && solver.inverseMass == inverseMass;
  const bool shared = solver.kind == MidpointSolver::Kind::Shared;
  if (same && (shared ? solver.shared != nullptr : !solver.place.empty())) return;
  solver.substep = h;
  solver.revision = springs.revision;
  solver.inverseMass = inverseMass;
  solver.scratch.resize(3, inverseMass.cols());
  solver.dampingWeights.resize(springs.size());
  for (std::size_t s = 0; s < springs.size(); ++s)
    solver.dampingWeights[s] = dampingWeight(springs, solver.inverseMass, s, h);
  if (shared)
    solver.shared = factors.get(midpointMatrix(parts, inverseMass, h));
  else
    prepareBanded(solver, springs);
}

void update(MidpointSolver& solver, const ElasticParts& parts, const Points& damperDirection,
            const Points& position) {
  if (solver.kind == MidpointSolver::Kind::Shared) return;
  const SpringArrays& springs = parts.springs;
  BandedMatrix& matrix = solver.banded;
  matrix.band.setZero();
  addMasses(solver);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto a = springs.a[s], b = springs.b[s];
    const Eigen::Matrix3d block = springBlock(solver, springs, s, damperDirection, position);
    addFree(solver, a, a, block);
    addFree(solver, b, b, block);
    addFree(solver, a, b, -block);
  }
  if (parts.tetrahedra) addTetrahedra(solver, *parts.tetrahedra, position);
  factorise(matrix);
}

namespace {

/// Without the volume term.
void solvePlain(MidpointSolver& solver, Points& b) {
  if (solver.kind == MidpointSolver::Kind::Shared) return solver.shared->solve(b, solver.scratch);
  for (Eigen::Index i = 0; i < b.cols(); ++i)
    solver.ordered.segment<3>(3 * Eigen::Index{solver.place[static_cast<std::size_t>(i)]}) = b.col(i);
  solve(solver.banded, solver.ordered);
  for (Eigen::Index i = 0; i < b.cols(); ++i)
    b.col(i) = solver.ordered.segment<3>(3 * Eigen::Index{solver.place[static_cast<std::size_t>(i)]});
}

}  // namespace

void updateVolumes(MidpointSolver& solver, const VolumeArrays& volumes, const PointState& state) {
  VolumeUpdate& u = solver.volumes;
  const std::size_t count = volumes.restVolume.size();
  u.gradient.resize(count);
  u.response.resize(count);
  u.inner.resize(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(count));
  u.inner.setZero();
  for (std::size_t c = 0; c < count; ++c) {
    const VolumeSlope slope = volumeSlope(volumes, c, state, u.gradient[c]);
    const double d = 0.25 * solver.substep * solver.substep * slope.stiffness;
    if (d == 0.0) u.gradient[c].setZero();
    u.inner(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(c)) = d == 0.0 ? 1.0 : 1.0 / d;
    u.response[c] = u.gradient[c];
    solvePlain(solver, u.response[c]);
  }
  for (std::size_t c = 0; c < count; ++c)
    for (std::size_t e = 0; e < count; ++e)
      u.inner(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(e)) +=
          dot(u.gradient[c], u.response[e]);
}

void solve(MidpointSolver& solver, Points& b) {
  solvePlain(solver, b);
  const VolumeUpdate& u = solver.volumes;
  if (u.gradient.empty()) return;
  SmallVector y(u.inner.rows());
  for (std::size_t c = 0; c < u.gradient.size(); ++c) y[static_cast<Eigen::Index>(c)] = dot(u.gradient[c], b);
  solveSmall(u.inner, y);
  for (std::size_t c = 0; c < u.gradient.size(); ++c) b -= y[static_cast<Eigen::Index>(c)] * u.response[c];
}

}  // namespace limber
