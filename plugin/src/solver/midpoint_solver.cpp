// SPDX-License-Identifier: Zlib
// Assembles, factorises and solves the linear systems of the implicit midpoint rule.
#include "solver/midpoint_solver.h"

#include <algorithm>

namespace limber {

// --- banded matrices ---------------------------------------------------------------------------------------

void factorise(BandedMatrix& matrix) {
  Eigen::MatrixXd& a = matrix.band;
  const Eigen::Index size = matrix.size(), width = matrix.width();
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::Index below = std::min(width, size - 1 - j);
    if (!(a(0, j) > 0.0)) a(0, j) = 1.0;
    // columns j + k lose l_k d l^T; l is column j divided by its pivot d
    for (Eigen::Index k = 1; k <= below; ++k) {
      const double factor = a(k, j) / a(0, j);
      if (factor != 0.0) a.col(j + k).head(below - k + 1) -= factor * a.col(j).segment(k, below - k + 1);
    }
    a.col(j).segment(1, below) /= a(0, j);
  }
}

void solve(const BandedMatrix& factors, Eigen::Ref<Eigen::VectorXd> b) {
  const Eigen::MatrixXd& a = factors.band;
  const Eigen::Index size = factors.size(), width = factors.width();
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::Index below = std::min(width, size - 1 - j);
    b.segment(j + 1, below) -= b[j] * a.col(j).segment(1, below);
  }
  for (Eigen::Index j = size; j-- > 0;) {
    const Eigen::Index below = std::min(width, size - 1 - j);
    b[j] = b[j] / a(0, j) - a.col(j).segment(1, below).dot(b.segment(j + 1, below));
  }
}

namespace {

using Neighbours = std::vector<std::vector<std::uint32_t>>;

Neighbours neighboursOf(const SpringArrays& springs, std::size_t points) {
  Neighbours neighbours(points);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    neighbours[springs->a[s]].push_back(springs->b[s]);
    neighbours[springs->b[s]].push_back(springs->a[s]);
  }
  const auto fewer = [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(neighbours[a].size(), a) < std::pair(neighbours[b].size(), b);
  };
  Neighbours sorted = neighbours;
  for (auto& list : sorted) std::sort(list.begin(), list.end(), fewer);
  return sorted;
}

/// Appends the points that can be reached from `start`, nearest first.
void visitFrom(std::uint32_t start, const Neighbours& neighbours, std::vector<unsigned char>& seen,
               std::vector<std::uint32_t>& order) {
  std::size_t next = order.size();
  order.push_back(start);
  seen[start] = 1;
  for (; next < order.size(); ++next)
    for (const std::uint32_t i : neighbours[order[next]])
      if (!seen[i]) {
        seen[i] = 1;
        order.push_back(i);
      }
}

/// Returns a point at one end of the component, found by going to the farthest point twice.
std::uint32_t findEnd(std::uint32_t start, const Neighbours& neighbours) {
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<unsigned char> seen(neighbours.size(), 0);
    std::vector<std::uint32_t> order;
    visitFrom(start, neighbours, seen, order);
    start = order.back();
  }
  return start;
}

}  // namespace

std::vector<std::uint32_t> bandOrder(const SpringArrays& springs, std::size_t points) {
  const Neighbours neighbours = neighboursOf(springs, points);
  std::vector<unsigned char> seen(points, 0);
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < points; ++i)
    if (!seen[i]) visitFrom(findEnd(i, neighbours), neighbours, seen, order);
  std::vector<std::uint32_t> positions(points);
  for (std::uint32_t k = 0; k < points; ++k) positions[order[k]] = static_cast<std::uint32_t>(points) - 1 - k;
  return positions;
}

std::size_t bandWidth(const SpringArrays& springs, const std::vector<std::uint32_t>& positions) {
  std::size_t width = 0;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto a = positions[springs->a[s]], b = positions[springs->b[s]];
    width = std::max<std::size_t>(width, a > b ? a - b : b - a);
  }
  return width;
}

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

// --- the system of an iteration ----------------------------------------------------------------------------

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

/// Returns the first of the point's three rows of the banded matrix.
Eigen::Index rowOf(const MidpointSolver& solver, Eigen::Index point) {
  return 3 * Eigen::Index{solver.place[static_cast<std::size_t>(point)]};
}

/// Adds the block in the row of one point and the column of another to the lower triangle, transposed if it
/// is above the diagonal; nothing if either is held.
void addFree(MidpointSolver& solver, std::uint32_t rowPoint, std::uint32_t columnPoint,
             const Eigen::Matrix3d& block) {
  if (isHeld(solver.inverseMass, rowPoint) || isHeld(solver.inverseMass, columnPoint)) return;
  const Eigen::Index row = rowOf(solver, rowPoint), column = rowOf(solver, columnPoint);
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      if (row != column || i >= j)
        solver.banded.at(std::max(row + i, column + j), std::min(row + i, column + j)) += block(i, j);
}

void addMasses(MidpointSolver& solver) {
  for (Eigen::Index i = 0; i < solver.inverseMass.cols(); ++i)
    solver.banded.band.row(0)
        .segment<3>(rowOf(solver, i))
        .setConstant(isHeld(solver.inverseMass, i) ? 1.0 : massOf(solver.inverseMass, i));
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
  for (Eigen::Index i = 0; i < b.cols(); ++i) solver.ordered.segment<3>(rowOf(solver, i)) = b.col(i);
  solve(solver.banded, solver.ordered);
  for (Eigen::Index i = 0; i < b.cols(); ++i) b.col(i) = solver.ordered.segment<3>(rowOf(solver, i));
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
    const auto a = springs->a[s], b = springs->b[s];
    const Eigen::Matrix3d block = springBlock(solver, springs, s, damperDirection, position);
    addFree(solver, a, a, block);
    addFree(solver, b, b, block);
    addFree(solver, a, b, -block);
  }
  if (parts.tetrahedra) addTetrahedra(solver, *parts.tetrahedra, position);
  factorise(matrix);
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
