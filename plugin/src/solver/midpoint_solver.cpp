// SPDX-License-Identifier: Zlib
// Assembles, factorises and solves the linear systems of the implicit midpoint rule.
#include "solver/midpoint_solver.h"

#include <algorithm>

namespace limber {

// --- the matrix that bodies share --------------------------------------------------------------------------

namespace {

/// kg: addition of the damper of spring s to the matrix of the midpoint rule, h/2 c (1 + beta).
double dampingWeight(const SpringArrays& springs, const Points& inverseMass, std::size_t s, double h) {
  const double c = springs->damping[s];
  return 0.5 * h * c * (1.0 + lookAhead(c, inverseMassesOf(springs, inverseMass, s), h));
}

using Sparse = Eigen::SparseMatrix<double>;

bool equal(const Sparse& a, const Sparse& b) {
  return a.rows() == b.rows() && a.nonZeros() == b.nonZeros() && Sparse(a - b).squaredNorm() == 0.0;
}

using Entries = std::vector<Eigen::Triplet<double>>;

/// Adds  weight (e_a - e_b)(e_a - e_b)^T  without the rows and columns of held points.
void addTerm(std::uint32_t a, std::uint32_t b, double weight, const Points& inverseMass, Entries& entries) {
  const bool heldA = isHeld(inverseMass, a), heldB = isHeld(inverseMass, b);
  if (!heldA) entries.emplace_back(a, a, weight);
  if (!heldB) entries.emplace_back(b, b, weight);
  if (heldA || heldB) return;
  entries.emplace_back(a, b, -weight);
  entries.emplace_back(b, a, -weight);
}

void addTetrahedronTerms(const TetrahedronVolumes& v, const Points& inverseMass, double h, Entries& entries) {
  for (std::size_t t = 0; t < v->tetrahedra.size(); ++t) {
    const Eigen::Array4d squares = v->restGradientSquares.col(static_cast<Eigen::Index>(t));
    const double factor = 0.25 * h * h * v->modulus / v->restVolume[t];
    for (Eigen::Index i = 0; i < 4; ++i)
      for (Eigen::Index j = 0; j < i; ++j)
        addTerm(v->tetrahedra[t][static_cast<std::size_t>(i)], v->tetrahedra[t][static_cast<std::size_t>(j)],
                0.25 * factor * (2.0 * squares.sum() - squares[i] - squares[j]), inverseMass, entries);
  }
}

/// Returns A for substeps of h seconds.
Sparse midpointMatrix(const ElasticParts& parts, const Points& inverseMass, double h) {
  Entries entries;
  const SpringArrays& springs = parts.springs;
  for (std::uint32_t i = 0; i < inverseMass.cols(); ++i)
    entries.emplace_back(i, i, isHeld(inverseMass, i) ? 1.0 : massOf(inverseMass, i));
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const double k = std::max(springs->extensionStiffness[s], springs->compressionStiffness[s]);
    const double weight = 0.25 * h * h * k + dampingWeight(springs, inverseMass, s, h);
    addTerm(springs->a[s], springs->b[s], weight, inverseMass, entries);
  }
  if (parts.tetrahedra) addTetrahedronTerms(*parts.tetrahedra, inverseMass, h, entries);
  Sparse matrix(inverseMass.cols(), inverseMass.cols());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

void SharedFactor::solve(Points& b, Points& scratch) const {
  for (Eigen::Index i = 0; i < b.cols(); ++i) scratch.col(factor.place[i]) = b.col(i);
  solveOrdered(factor, scratch.transpose());
  for (Eigen::Index i = 0; i < b.cols(); ++i) b.col(i) = scratch.col(factor.place[i]);
}

std::shared_ptr<const SharedFactor> SharedFactors::get(const Sparse& matrix) {
  const std::lock_guard<std::mutex> lock(mutex_);
  known_.erase(std::remove_if(known_.begin(), known_.end(), [](const auto& f) { return f.expired(); }),
               known_.end());
  for (const auto& known : known_)
    if (auto factor = known.lock(); factor && equal(factor->matrix, matrix)) return factor;
  auto shared = std::make_shared<SharedFactor>();
  shared->factor = factorise(matrix);
  shared->matrix = matrix;
  known_.push_back(shared);
  return shared;
}

std::vector<PointPair> joinedPoints(const ElasticParts& parts) {
  std::vector<PointPair> joined;
  for (std::size_t s = 0; s < parts.springs.size(); ++s)
    joined.push_back({parts.springs->a[s], parts.springs->b[s]});
  if (!parts.tetrahedra) return joined;
  for (const Tetrahedron& t : (*parts.tetrahedra)->tetrahedra)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) joined.push_back({t[i], t[j]});
  return joined;
}

// --- the system of an iteration ----------------------------------------------------------------------------

namespace {

void prepareNewton(MidpointSolver& solver, const ElasticParts& parts) {
  const auto points = static_cast<std::size_t>(solver.inverseMass.cols());
  if (solver.newton.points() != points) setPattern(solver.newton, joinedPoints(parts), points);
}

/// Returns h^2/4 times the stiffness of spring s plus its damping weight, 3 x 3.
Eigen::Matrix3d springBlock(const MidpointSolver& solver, const SpringArrays& springs, std::size_t s,
                            const Points& damperDirection, const Points& position) {
  const Eigen::Vector3d m = damperDirection.col(static_cast<Eigen::Index>(s));
  const Eigen::Vector3d n = springs.direction.col(static_cast<Eigen::Index>(s));
  const double length = (position.col(springs->b[s]) - position.col(springs->a[s])).norm();
  const double stretch = length - springs->restLength[s];
  const double k = stretch > 0.0 ? springs->extensionStiffness[s] : springs->compressionStiffness[s];
  const double stiffness = 0.25 * solver.substep * solver.substep * k;
  const double sideways = length > 0.0 ? stiffness * std::max(0.0, stretch / length) : 0.0;
  const Eigen::Matrix3d along = n * n.transpose();
  return stiffness * along + solver.dampingWeights[s] * m * m.transpose() +
         sideways * (Eigen::Matrix3d::Identity() - along);
}

/// Adds the block in the row of one point and the column of another; nothing if either is held.
void addFree(MidpointSolver& solver, std::uint32_t rowPoint, std::uint32_t columnPoint,
             const Eigen::Matrix3d& block) {
  if (isHeld(solver.inverseMass, rowPoint) || isHeld(solver.inverseMass, columnPoint)) return;
  solver.newton.add(rowPoint, columnPoint, block);
}

void addMasses(MidpointSolver& solver) {
  for (std::uint32_t i = 0; i < solver.inverseMass.cols(); ++i) {
    const double mass = isHeld(solver.inverseMass, i) ? 1.0 : massOf(solver.inverseMass, i);
    solver.newton.add(i, i, mass * Eigen::Matrix3d::Identity());
  }
}

void addTetrahedra(MidpointSolver& solver, const TetrahedronVolumes& tetrahedra, const Points& position) {
  for (std::size_t t = 0; t < tetrahedra->tetrahedra.size(); ++t) {
    const TetrahedronSlope slope = tetrahedronSlope(tetrahedra, t, position);
    const double stiffness = 0.25 * solver.substep * solver.substep * slope.stiffness;
    if (stiffness == 0.0) continue;
    const Tetrahedron& corner = tetrahedra->tetrahedra[t];
    for (Eigen::Index i = 0; i < 4; ++i)
      for (Eigen::Index j = 0; j <= i; ++j)
        addFree(solver, corner[static_cast<std::size_t>(i)], corner[static_cast<std::size_t>(j)],
                stiffness * slope.gradient.col(i) * slope.gradient.col(j).transpose());
  }
}

/// Solves A x = b in place without the volume term.
void solveWithoutVolumes(MidpointSolver& solver, Points& b) {
  if (solver.kind == MidpointSolver::Kind::Shared) return solver.shared->solve(b, solver.scratch);
  solve(solver.newton, b, solver.scratch);
}

}  // namespace

void prepare(MidpointSolver& solver, const ElasticParts& parts, const Points& inverseMass, double h,
             SharedFactors& factors) {
  const SpringArrays& springs = parts.springs;
  const bool same = solver.substep == h && solver.revision == springs.revision &&
                    solver.inverseMass.cols() == inverseMass.cols() && solver.inverseMass == inverseMass;
  const bool shared = solver.kind == MidpointSolver::Kind::Shared;
  if (same && (shared ? solver.shared != nullptr : solver.newton.points() > 0)) return;
  solver.substep = h;
  solver.revision = springs.revision;
  solver.inverseMass = inverseMass;
  solver.scratch.resize(3, inverseMass.cols());
  solver.dampingWeights.resize(springs.size());
  for (std::size_t s = 0; s < springs.size(); ++s)
    solver.dampingWeights[s] = dampingWeight(springs, solver.inverseMass, s, h);
  solver.shared.reset();
  if (shared)
    solver.shared = factors.get(midpointMatrix(parts, inverseMass, h));
  else
    prepareNewton(solver, parts);
}

void update(MidpointSolver& solver, const ElasticParts& parts, const Points& damperDirection,
            const Points& position) {
  if (solver.kind == MidpointSolver::Kind::Shared) return;
  const SpringArrays& springs = parts.springs;
  setZero(solver.newton);
  addMasses(solver);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto a = springs->a[s], b = springs->b[s];
    const Eigen::Matrix3d block = springBlock(solver, springs, s, damperDirection, position);
    addFree(solver, a, a, block);
    addFree(solver, b, b, block);
    addFree(solver, a, b, -block);
  }
  if (parts.tetrahedra) addTetrahedra(solver, *parts.tetrahedra, position);
  factorise(solver.newton);
}

void updateVolumes(MidpointSolver& solver, const VolumeArrays& volumes, const PointState& state) {
  VolumeUpdate& u = solver.volumes;
  const std::size_t count = volumes->restVolume.size();
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
    solveWithoutVolumes(solver, u.response[c]);
  }
  for (std::size_t c = 0; c < count; ++c)
    for (std::size_t e = 0; e < count; ++e)
      u.inner(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(e)) +=
          dot(u.gradient[c], u.response[e]);
}

void solve(MidpointSolver& solver, Points& b) {
  solveWithoutVolumes(solver, b);
  const VolumeUpdate& u = solver.volumes;
  if (u.gradient.empty()) return;
  SmallVector y(u.inner.rows());
  for (std::size_t c = 0; c < u.gradient.size(); ++c) y[static_cast<Eigen::Index>(c)] = dot(u.gradient[c], b);
  solveSmall(u.inner, y);
  for (std::size_t c = 0; c < u.gradient.size(); ++c) b -= y[static_cast<Eigen::Index>(c)] * u.response[c];
}

}  // namespace limber
