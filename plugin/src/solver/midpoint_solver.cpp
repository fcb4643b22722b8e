// SPDX-License-Identifier: Zlib

// This file assembles, factorises and solves the linear systems of the implicit midpoint rule, and solves the
// contacts in a substep.

#include "solver/implicit_step.h"

#include "mesh/surface.h"

namespace limber {

// --- a matrix of blocks ------------------------------------------------------------------------------------

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The rows below the diagonal of each column of L.
using Columns = std::vector<std::vector<std::uint32_t>>;

/// Returns the place of each point in an order that keeps L sparse.
std::vector<std::uint32_t> sparseOrder(const std::vector<PointPair>& joined, std::size_t points) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::uint32_t i = 0; i < points; ++i) entries.emplace_back(i, i, 1.0);
  for (const PointPair& pair : joined)
    entries.emplace_back(std::max(pair[0], pair[1]), std::min(pair[0], pair[1]), 1.0);
  const auto size = static_cast<Eigen::Index>(points);
  Eigen::SparseMatrix<double> graph(size, size);
  graph.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXi place = limber::sparseOrder(graph);
  return {place.begin(), place.end()};
}

void addUnique(std::vector<std::uint32_t>& to, std::vector<std::uint32_t>& added) {
  to.insert(to.end(), added.begin(), added.end());
  sortUnique(to);
}

/// The elimination of a column joins its rows with each other: it suffices to add them to the column of the
/// first one.
Columns columnsOf(const std::vector<PointPair>& joined, const std::vector<std::uint32_t>& place) {
  Columns columns(place.size());
  for (const PointPair& pair : joined) {
    const auto [low, high] = std::minmax(place[pair[0]], place[pair[1]]);
    if (low != high) columns[low].push_back(high);
  }
  std::vector<std::uint32_t> rest;
  for (std::vector<std::uint32_t>& rows : columns) {
    rest.clear();
    addUnique(rows, rest);
    if (rows.empty()) continue;
    rest.assign(rows.begin() + 1, rows.end());
    addUnique(columns[rows[0]], rest);
  }
  return columns;
}

double pivot(double value) { return value > 0.0 ? value : 1.0; }

/// Returns the inverse of a symmetric block, with l d l^T as its factors.
Matrix3d inverseOf(const Matrix3d& a) {
  const double d0 = pivot(a(0, 0)), l10 = a(1, 0) / d0, l20 = a(2, 0) / d0;
  const double d1 = pivot(a(1, 1) - l10 * a(1, 0)), l21 = (a(2, 1) - l20 * a(1, 0)) / d1;
  const double d2 = pivot(a(2, 2) - l20 * a(2, 0) - l21 * l21 * d1);
  Matrix3d inverse = Matrix3d::Identity();
  inverse(1, 0) = -l10, inverse(2, 1) = -l21, inverse(2, 0) = l10 * l21 - l20;
  return inverse.transpose() * Vector3d(1.0 / d0, 1.0 / d1, 1.0 / d2).asDiagonal() * inverse;
}

}  // namespace

void BlockMatrix::add(std::uint32_t i, std::uint32_t j, const Matrix3d& block) {
  const std::uint32_t at = place[i], of = place[j];
  if (at == of) {
    diagonal[at] += block;
    return;
  }
  const auto [low, high] = std::minmax(at, of);
  const auto first = row.begin() + start[low], last = row.begin() + start[low + 1];
  Matrix3d& entry = below[static_cast<std::size_t>(std::lower_bound(first, last, high) - row.begin())];
  if (at == high)
    entry += block;
  else
    entry += block.transpose();
}

std::vector<std::uint32_t> fillOf(const std::vector<PointPair>& joined, std::size_t points) {
  std::vector<std::uint32_t> fill;
  for (const auto& rows : columnsOf(joined, sparseOrder(joined, points)))
    fill.push_back(static_cast<std::uint32_t>(rows.size()));
  return fill;
}

void setPattern(BlockMatrix& matrix, const std::vector<PointPair>& joined, std::size_t points) {
  matrix.place = sparseOrder(joined, points);
  matrix.start.assign(1, 0);
  matrix.row.clear();
  std::size_t most = 0;
  for (const auto& rows : columnsOf(joined, matrix.place)) {
    matrix.row.insert(matrix.row.end(), rows.begin(), rows.end());
    matrix.start.push_back(static_cast<std::uint32_t>(matrix.row.size()));
    most = std::max(most, rows.size());
  }
  matrix.below.resize(matrix.row.size());
  matrix.diagonal.resize(points);
  matrix.column.resize(most);
}

void setZero(BlockMatrix& matrix) {
  std::fill(matrix.below.begin(), matrix.below.end(), Matrix3d::Zero());
  std::fill(matrix.diagonal.begin(), matrix.diagonal.end(), Matrix3d::Zero());
}

/// Column j of A with the block d of D becomes column j of L = A d^-1. Each column k of its rows loses
/// L_k A_k^T, and below it L_i A_k^T.
void factorise(BlockMatrix& matrix) {
  for (std::size_t j = 0; j < matrix.points(); ++j) {
    const Matrix3d inverse = inverseOf(matrix.diagonal[j]);
    const std::size_t first = matrix.start[j], count = matrix.start[j + 1] - first;
    for (std::size_t a = 0; a < count; ++a) matrix.column[a].noalias() = matrix.below[first + a] * inverse;
    for (std::size_t b = 0; b < count; ++b) {
      const std::uint32_t k = matrix.row[first + b];
      const Matrix3d transposed = matrix.below[first + b].transpose();
      matrix.diagonal[k].noalias() -= matrix.column[b] * transposed;
      std::size_t to = matrix.start[k];
      for (std::size_t a = b + 1; a < count; ++a, ++to) {
        while (matrix.row[to] != matrix.row[first + a]) ++to;
        matrix.below[to].noalias() -= matrix.column[a] * transposed;
      }
    }
    std::copy_n(matrix.column.begin(), count, matrix.below.begin() + static_cast<std::ptrdiff_t>(first));
    matrix.diagonal[j] = inverse;
  }
}

void solve(const BlockMatrix& factors, Eigen::Matrix3Xd& x, Eigen::Matrix3Xd& scratch) {
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    scratch.col(factors.place[static_cast<std::size_t>(i)]) = x.col(i);
  const std::size_t points = factors.points();
  for (std::size_t j = 0; j < points; ++j) {
    const Vector3d solved = scratch.col(static_cast<Eigen::Index>(j));
    for (std::size_t k = factors.start[j]; k < factors.start[j + 1]; ++k)
      scratch.col(factors.row[k]).noalias() -= factors.below[k] * solved;
  }
  for (std::size_t j = points; j-- > 0;) {
    Vector3d sum = factors.diagonal[j] * scratch.col(static_cast<Eigen::Index>(j));
    for (std::size_t k = factors.start[j]; k < factors.start[j + 1]; ++k)
      sum.noalias() -= factors.below[k].transpose() * scratch.col(factors.row[k]);
    scratch.col(static_cast<Eigen::Index>(j)) = sum;
  }
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    x.col(i) = scratch.col(factors.place[static_cast<std::size_t>(i)]);
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

std::shared_ptr<const SharedFactor> sharedFactor(const Sparse& matrix, SharedFactors& factors) {
  return factors.get([&](const SharedFactor& known) { return equal(known.matrix, matrix); },
                     [&] {
                       return SharedFactor{matrix, factorise(matrix)};
                     });
}

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
    solver.shared = sharedFactor(midpointMatrix(parts, inverseMass, h), factors);
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

// --- contacts ----------------------------------------------------------------------------------------------

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
