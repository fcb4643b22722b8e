// SPDX-License-Identifier: Zlib
// Analyses the rigidity of a network: its mechanisms and its softest mode from the stiffness matrix at rest,
// and its generic global rigidity with matrices over a finite field, in which ranks are exact.

#include "analysis/analysis.h"

#include "mesh/linear_algebra.h"
#include "mesh/random.h"
#include "mesh/surface.h"
#include "network/stability.h"

#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace limber {
namespace {

/// Returns the triangles or tetrahedra that have all corners in the piece, with the new numbers of the
/// points.
template <class Corners>
std::vector<Corners> selectInPiece(const std::vector<Corners>& all, Renumbering& numbers) {
  std::vector<Corners> result;
  for (const Corners& corners : all)
    if (std::all_of(corners.begin(), corners.end(), [&](std::uint32_t i) { return numbers.has(i); }))
      result.push_back(numbers(corners));
  return result;
}

}  // namespace

SpringNetwork pieceOf(const SpringNetwork& network, const std::vector<std::uint32_t>& points) {
  SpringNetwork piece;
  piece.kind = network.kind;
  piece.stiffnessPerModulus = network.stiffnessPerModulus;
  Renumbering numbers(network.restPoints.size());
  for (const std::uint32_t point : points) numbers(point);
  piece.restPoints = chosen(network.restPoints, points);
  piece.massFractions = chosen(network.massFractions, points);
  const double mass = std::accumulate(piece.massFractions.begin(), piece.massFractions.end(), 0.0);
  for (double& share : piece.massFractions) share /= mass;
  for (const NetworkSpring& s : network.springs)
    if (numbers.has(s.a) && numbers.has(s.b))
      piece.springs.push_back({numbers(s.a), numbers(s.b), s.kind, s.stiffnessScale});
  piece.surface = selectInPiece(network.surface, numbers);
  piece.tetrahedra = selectInPiece(network.tetrahedra, numbers);
  setEdgeDefects(piece.report, piece.surface);
  return piece;
}

namespace {

/// A mode with a smaller eigenvalue, relative to the stiffest one, is a mechanism. The points of a mesh have
/// single precision. This rotates its springs by about 1e-6, and so changes the singular values of the
/// rigidity matrix by 1e-6 of the largest (Weyl) and the eigenvalues, their squares, by 1e-12. The round-off
/// of double precision is four powers of ten smaller.
constexpr double kMechanism = 1e-12;

/// Up to this number of unknowns, all eigenvalues are computed at once.
constexpr Eigen::Index kMaxDense = 450;

/// The number of eigenvalues of the stiffness matrix below the bound of mechanisms, and the smallest above.
struct SoftEnd {
  Eigen::Index below = 0;
  double softest = 0.0;
};

SoftEnd denseSoftEnd(const SparseMatrix& stiffness, double bound) {
  const Eigen::VectorXd values = symmetricValues(stiffness);
  const Eigen::Index below = std::lower_bound(values.begin(), values.end(), bound) - values.begin();
  return {below, below < values.size() ? values[below] : 0.0};
}

/// Largest residual of a solution with a factor, relative to the matrix, for which its inertia is trusted.
constexpr double kMaxFactorResidual = 1e-10;

bool isSound(const SparseFactor& factor, const SparseMatrix& matrix, double size) {
  if (!factor.isComplete) return false;
  Random random(1);
  Eigen::VectorXd b(matrix.rows());
  for (double& x : b) x = random.uniform() - 0.5;
  const Eigen::VectorXd x = solve(factor, b);
  return (matrix * x - b).norm() <= kMaxFactorResidual * (size * x.norm() + b.norm());
}

/// Counts eigenvalues by Sylvester's law: K - s has as many negative pivots as K has eigenvalues below s. The
/// largest eigenvalue of its inverse belongs to the first eigenvalue above. Without pivoting, a factor can be
/// inaccurate if s is near an eigenvalue of a leading block; then a somewhat larger s is used.
SoftEnd sparseSoftEnd(const SparseMatrix& stiffness, double bound, double stiffest) {
  SparseFactor factor;
  double shift = 0.0;
  for (int attempt = 0; attempt < 6; ++attempt) {
    shift = bound * std::pow(1.7, attempt);
    SparseMatrix shifted = stiffness;
    for (Eigen::Index i = 0; i < shifted.rows(); ++i) shifted.coeffRef(i, i) -= shift;
    factor = factorise(shifted);
    if (isSound(factor, shifted, stiffest)) break;
  }
  if (!factor.isComplete) return denseSoftEnd(stiffness, bound);
  const Eigen::Index below = (factor.diagonal.array() < 0.0).count();
  if (below == stiffness.rows()) return {below, 0.0};
  const double inverse = largestEigenvalue(
      [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return solve(factor, v); }, stiffness.rows());
  return {below, inverse > 0.0 ? shift + 1.0 / inverse : 0.0};
}

}  // namespace

SmallDeformations smallDeformations(const SpringNetwork& network) {
  const SparseMatrix stiffness = stiffnessMatrix(rigidityMatrix(network));
  const Eigen::Index unknowns = stiffness.rows(), rigid = rigidMotions(network.restPoints).cols();
  SmallDeformations result;
  result.stiffest = stiffestEigenvalue(stiffness);
  SoftEnd end{unknowns, 0.0};
  if (result.stiffest > 0.0) {
    const double bound = kMechanism * result.stiffest;
    end = unknowns <= kMaxDense ? denseSoftEnd(stiffness, bound)
                                : sparseSoftEnd(stiffness, bound, result.stiffest);
  }
  result.softest = end.softest;
  result.rank = static_cast<std::size_t>(unknowns - end.below);
  result.mechanisms = static_cast<std::size_t>(std::max<Eigen::Index>(end.below - rigid, 0));
  result.selfStresses = network.springs.size() - std::min(result.rank, network.springs.size());
  return result;
}

namespace {

/// Arithmetic modulo the prime 2^31 - 1, in which ranks are exact. A matrix of random numbers has a smaller
/// rank than over the reals only where a polynomial in them vanishes by chance (Schwartz 1980).
namespace prime_field {

using Element = std::uint32_t;
constexpr std::uint64_t kPrime = 0x7fffffffu;

Element sum(Element a, Element b) { return static_cast<Element>((std::uint64_t(a) + b) % kPrime); }
Element difference(Element a, Element b) {
  return static_cast<Element>((std::uint64_t(a) + kPrime - b) % kPrime);
}
Element product(Element a, Element b) { return static_cast<Element>(std::uint64_t(a) * b % kPrime); }
Element random(Random& source) { return static_cast<Element>(source.next() % kPrime); }

/// Returns the inverse of a, which must not be 0.
Element inverse(Element a) {
  // a^(p - 2), Fermat
  Element result = 1, power = a;
  for (std::uint64_t exponent = kPrime - 2; exponent > 0; exponent >>= 1) {
    if (exponent & 1) result = product(result, power);
    power = product(power, power);
  }
  return result;
}

struct Matrix {
  std::size_t rows, columns;
  std::vector<Element> entries;  ///< row by row

  Matrix(std::size_t r, std::size_t c) : rows(r), columns(c), entries(r * c, 0) {}
  Element& operator()(std::size_t r, std::size_t c) { return entries[r * columns + c]; }
  Element operator()(std::size_t r, std::size_t c) const { return entries[r * columns + c]; }
};

/// Is called with the progress, 0 to 1. After it has returned false, the result is invalid.
using GoOn = std::function<bool(double)>;

/// Returns the columns from `from` on in which the row is not zero.
std::vector<std::size_t> nonzeros(const Matrix& m, std::size_t row, std::size_t from) {
  std::vector<std::size_t> columns;
  for (std::size_t c = from; c < m.columns; ++c)
    if (m(row, c) != 0) columns.push_back(c);
  return columns;
}

/// Computes row -= factor * other, in the columns listed from `first` to `last`.
void subtract(Matrix& m, std::size_t row, Element factor, std::size_t other, const std::size_t* first,
              const std::size_t* last) {
  const std::uint64_t minus = kPrime - factor;
  Element* to = &m.entries[row * m.columns];
  const Element* from = &m.entries[other * m.columns];
  for (; first != last; ++first)
    to[*first] = static_cast<Element>((to[*first] + minus * from[*first]) % kPrime);
}

bool mayContinue(const GoOn& goOn, std::size_t row, std::size_t rows) {
  return !goOn || goOn(static_cast<double>(row) / static_cast<double>(rows));
}

std::size_t rank(Matrix m, const GoOn& goOn) {
  std::size_t rankSoFar = 0;
  for (std::size_t c = 0; c < m.columns && rankSoFar < m.rows && mayContinue(goOn, c, m.columns); ++c) {
    std::size_t pivot = rankSoFar;
    while (pivot < m.rows && m(pivot, c) == 0) ++pivot;
    if (pivot == m.rows) continue;
    if (pivot != rankSoFar)
      std::swap_ranges(&m.entries[pivot * m.columns], &m.entries[pivot * m.columns] + m.columns,
                       &m.entries[rankSoFar * m.columns]);
    const std::vector<std::size_t> columns = nonzeros(m, rankSoFar, c);
    const Element scale = inverse(m(rankSoFar, c));
    for (std::size_t r = rankSoFar + 1; r < m.rows; ++r)
      if (m(r, c) != 0)
        subtract(m, r, product(scale, m(r, c)), rankSoFar, columns.data(), columns.data() + columns.size());
    ++rankSoFar;
  }
  return rankSoFar;
}

/// Solves A x = b in place, with free unknowns at 0, and returns the rank of A. A must be symmetric, the rank
/// of each of its leading blocks must be that of the block's rows, and b must be in its range. Skips zero
/// entries.
std::size_t solveSymmetric(Matrix a, std::vector<Element>& b, const GoOn& goOn) {
  std::vector<std::size_t> pivots;
  for (std::size_t p = 0; p < a.rows && mayContinue(goOn, p, a.rows); ++p) {
    if (a(p, p) == 0) continue;
    pivots.push_back(p);
    const std::vector<std::size_t> columns = nonzeros(a, p, p + 1);
    const Element scale = inverse(a(p, p));
    const std::size_t* const end = columns.data() + columns.size();
    for (const std::size_t* at = columns.data(); at != end; ++at) {
      const std::size_t r = *at;
      const Element factor = product(scale, a(p, r));
      subtract(a, r, factor, p, at, end);  // later only the entries right of a row's diagonal are read
      b[r] = difference(b[r], product(factor, b[p]));
    }
  }
  std::vector<Element> x(b.size(), 0);
  for (std::size_t i = pivots.size(); i-- > 0;) {
    const std::size_t p = pivots[i];
    Element rest = b[p];
    for (std::size_t c = p + 1; c < a.columns; ++c)
      if (a(p, c) != 0) rest = difference(rest, product(a(p, c), x[c]));
    x[p] = product(rest, inverse(a(p, p)));
  }
  b = x;
  return pivots.size();
}

}  // namespace prime_field

using prime_field::Element;

/// Rows of the rigidity matrix without division by lengths: b - a at b, a - b at a. Its stress is in
/// equilibrium when  sum_s stress_s row_s = 0.
struct Framework {
  std::size_t points = 0;
  std::vector<std::array<std::uint32_t, 2>> ends;   ///< #springs
  std::vector<std::array<Element, 3>> differences;  ///< #springs, b - a
};

/// Returns new indices of the points that keep the elimination of a matrix with an entry for each spring
/// sparse.
std::vector<std::uint32_t> eliminationOrder(const SpringNetwork& network) {
  const auto count = static_cast<int>(network.restPoints.size());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(network.restPoints.size() + 2 * network.springs.size());
  for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 1.0);
  for (const NetworkSpring& s : network.springs)
    entries.emplace_back(static_cast<int>(std::max(s.a, s.b)), static_cast<int>(std::min(s.a, s.b)), 1.0);
  Eigen::SparseMatrix<double> graph(count, count);
  graph.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXi newIndex = sparseOrder(graph);
  return {newIndex.begin(), newIndex.end()};
}

Framework randomPlacement(const SpringNetwork& network, Random& random) {
  std::vector<std::array<Element, 3>> positions(network.restPoints.size());
  for (auto& position : positions)
    for (Element& x : position) x = prime_field::random(random);
  const std::vector<std::uint32_t> order = eliminationOrder(network);
  Framework framework;
  framework.points = network.restPoints.size();
  for (const NetworkSpring& s : network.springs) {
    framework.ends.push_back({order[s.a], order[s.b]});
    std::array<Element, 3> d{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      d[axis] = prime_field::difference(positions[s.b][axis], positions[s.a][axis]);
    framework.differences.push_back(d);
  }
  return framework;
}

std::vector<Element> randomVector(std::size_t size, Random& random) {
  std::vector<Element> v(size);
  for (Element& x : v) x = prime_field::random(random);
  return v;
}

/// Returns K = R^T D R with the spring constants D. For random constants, the rank of each leading block
/// equals that of the corresponding columns of R.
prime_field::Matrix stiffness(const Framework& f, const std::vector<Element>& constants) {
  using namespace prime_field;
  Matrix k(3 * f.points, 3 * f.points);
  for (std::size_t s = 0; s < f.ends.size(); ++s) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const Element entry = product(constants[s], product(f.differences[s][i], f.differences[s][j]));
        for (std::size_t row = 0; row < 2; ++row)
          for (std::size_t column = 0; column < 2; ++column) {
            Element& at = k(3 * f.ends[s][row] + i, 3 * f.ends[s][column] + j);
            at = row == column ? sum(at, entry) : difference(at, entry);
          }
      }
    }
  }
  return k;
}

/// Returns R^T w.
std::vector<Element> forces(const Framework& f, const std::vector<Element>& w) {
  using namespace prime_field;
  std::vector<Element> result(3 * f.points, 0);
  for (std::size_t s = 0; s < f.ends.size(); ++s) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Element force = product(w[s], f.differences[s][i]);
      Element &a = result[3 * f.ends[s][0] + i], &b = result[3 * f.ends[s][1] + i];
      a = difference(a, force);
      b = sum(b, force);
    }
  }
  return result;
}

/// Returns the remainder of random tensions g after the points have moved into equilibrium:
/// g - D R x,  with K x = R^T g.
std::vector<Element> equilibriumStress(const Framework& f, const std::vector<Element>& constants,
                                       std::vector<Element> g, const std::vector<Element>& x) {
  using namespace prime_field;
  for (std::size_t s = 0; s < f.ends.size(); ++s) {
    Element stretch = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Element apart = difference(x[3 * f.ends[s][1] + i], x[3 * f.ends[s][0] + i]);
      stretch = sum(stretch, product(f.differences[s][i], apart));
    }
    g[s] = difference(g[s], product(constants[s], stretch));
  }
  return g;
}

prime_field::Matrix stressMatrix(const Framework& f, const std::vector<Element>& stress) {
  using namespace prime_field;
  Matrix matrix(f.points, f.points);
  for (std::size_t s = 0; s < f.ends.size(); ++s) {
    const auto [a, b] = f.ends[s];
    matrix(a, a) = sum(matrix(a, a), stress[s]);
    matrix(b, b) = sum(matrix(b, b), stress[s]);
    matrix(a, b) = matrix(b, a) = difference(0, stress[s]);
  }
  return matrix;
}

}  // namespace

bool isGloballyRigid(const SpringNetwork& network, std::uint64_t seed,
                     const std::function<bool(double)>& goOn) {
  const std::size_t points = network.restPoints.size(), springs = network.springs.size();
  if (points <= 4) return springs == points * (points - 1) / 2;
  if (springs <= 3 * points - 6) return false;  // no stress
  Random random(seed);
  const Framework framework = randomPlacement(network, random);
  const std::vector<Element> constants = randomVector(springs, random),
                             tensions = randomVector(springs, random);
  std::vector<Element> x = forces(framework, tensions);
  if (prime_field::solveSymmetric(stiffness(framework, constants), x, goOn) != 3 * points - 6) return false;
  const auto afterSolving = [&](double) { return !goOn || goOn(1.0); };  // the rest takes a tenth as long
  return prime_field::rank(stressMatrix(framework, equilibriumStress(framework, constants, tensions, x)),
                           afterSolving) == points - 4;
}

}  // namespace limber
