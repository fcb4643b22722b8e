// SPDX-License-Identifier: Zlib
// Finds the pieces of a network, its stiffness matrix at rest, its rigid motions and its softest modes.

#include "network/stability.h"

#include "mesh/linear_algebra.h"
#include "mesh/random.h"
#include "mesh/surface.h"

namespace limber {

std::vector<std::vector<std::uint32_t>> findPieces(const SpringNetwork& network) {
  const std::size_t points = network.restPoints.size();
  DisjointSets sets(points);
  for (const NetworkSpring& s : network.springs) sets.join(s.a, s.b);
  std::vector<std::vector<std::uint32_t>> pieces;
  Renumbering numbers(points);
  for (std::uint32_t i = 0; i < points; ++i) {
    const std::uint32_t piece = numbers(sets.root(i));
    if (piece == pieces.size()) pieces.emplace_back();
    pieces[piece].push_back(i);
  }
  return pieces;
}

SparseMatrix rigidityMatrix(const SpringNetwork& network) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(6 * network.springs.size());
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const NetworkSpring& spring = network.springs[s];
    const Eigen::Vector3d d = network.restPoints[spring.b] - network.restPoints[spring.a];
    const Eigen::Vector3d row = std::sqrt(spring.stiffnessScale) * d.stableNormalized();
    if (row.isZero(0.0)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      entries.emplace_back(static_cast<int>(s), 3 * static_cast<int>(spring.a) + axis, -row[axis]);
      entries.emplace_back(static_cast<int>(s), 3 * static_cast<int>(spring.b) + axis, row[axis]);
    }
  }
  SparseMatrix rigidity(static_cast<Eigen::Index>(network.springs.size()),
                        3 * static_cast<Eigen::Index>(network.restPoints.size()));
  rigidity.setFromTriplets(entries.begin(), entries.end());
  return rigidity;
}

SparseMatrix stiffnessMatrix(const SparseMatrix& rigidity) {
  const SparseMatrix transposed = rigidity.transpose();
  return transposed * rigidity;
}

Spread principalSpread(const std::vector<Eigen::Vector3d>& points) {
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) centre += p / static_cast<double>(count);
  Eigen::Matrix3Xd offsets(3, count);
  for (Eigen::Index i = 0; i < count; ++i) offsets.col(i) = points[static_cast<std::size_t>(i)] - centre;
  const double size = offsets.cwiseAbs().maxCoeff();
  if (size > 0.0) offsets /= size;
  const SymmetricParts3 parts = symmetricParts3(offsets * offsets.transpose());
  return {offsets, size, parts.values, parts.vectors};
}

Eigen::MatrixXd rigidMotions(const std::vector<Eigen::Vector3d>& points) {
  // relative to the largest distance from the centre; points nearer to a line are on it, because meshes have
  // single precision
  constexpr double kOnLine = 1e-6;
  const auto count = static_cast<Eigen::Index>(points.size());
  if (points.empty()) return Eigen::MatrixXd(0, 0);
  const Spread spread = principalSpread(points);
  // About the principal axes of the points the rotations are orthogonal to each other. For points on a line,
  // the rotation about the line is the last one, and zero.
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(3 * count, 6);
  Eigen::Index columns = 3;
  for (Eigen::Index i = 0; i < count; ++i)
    motions.block<3, 3>(3 * i, 0) = Eigen::Matrix3d::Identity() / std::sqrt(static_cast<double>(count));
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d direction = spread.axes.col(axis);
    auto rotation = motions.col(columns);
    double largest = 0.0;
    for (Eigen::Index i = 0; i < count; ++i) {
      rotation.segment<3>(3 * i) = direction.cross(Eigen::Vector3d(spread.offsets.col(i)));
      largest = std::max(largest, rotation.segment<3>(3 * i).norm());
    }
    if (largest < kOnLine) continue;
    rotation.normalize();
    ++columns;
  }
  return motions.leftCols(columns);
}

double stiffestEigenvalue(const SparseMatrix& stiffness) {
  return largestEigenvalue([&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return stiffness * v; },
                           stiffness.rows());
}

namespace {

/// Up to this number of unknowns, all modes are computed at once.
constexpr Eigen::Index kMaxDense = 450;

constexpr Eigen::Index kBlock = 8;  // vectors added to the space at once
constexpr int kMaxBlocks = 400;     // more blocks mean an error in the matrix
constexpr int kBlocksBetweenChecks = 3;
constexpr double kModeTolerance = 1e-5;  // largest residual, relative to the eigenvalue of the inverse
constexpr double kConfirmed = 1e-4;      // relative change of an eigenvalue below which no mode was missed
constexpr double kDependent = 1e-13;     // norm of the rest of a unit vector that counts as round-off
constexpr double kRelativeShift = 1e-9;  // of the largest eigenvalue, added so that the inverse exists

using Block = Eigen::Matrix<double, Eigen::Dynamic, kBlock>;

/// Returns an upper bound of the eigenvalues: the largest sum of a row's magnitudes (Gershgorin).
double largestRowSum(const SparseMatrix& matrix) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(matrix.rows());
  for (Eigen::Index j = 0; j < matrix.outerSize(); ++j)
    for (SparseMatrix::InnerIterator entry(matrix, j); entry; ++entry)
      sums[entry.row()] += std::abs(entry.value());
  return sums.size() ? sums.maxCoeff() : 0.0;
}

/// Returns the modes within the space of `shapes` U (orthonormal): with  (R U)^T R U = B S B^T  they are U B.
/// The round-off of S is relative to the stiffest mode of the space, not of all modes.
Modes modesWithin(const SparseMatrix& rigidity, const Eigen::MatrixXd& shapes) {
  const Eigen::MatrixXd stretches = rigidity * shapes;
  const SymmetricParts ritz = symmetricParts(transposedProduct(stretches, stretches));
  return {ritz.values.cwiseMax(0.0), product(shapes, ritz.vectors)};
}

/// Makes the rigid motions the stiffest modes, so that they are not among the first `count`.
Eigen::MatrixXd denseModes(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid, Eigen::Index count) {
  Eigen::MatrixXd matrix = stiffness;
  matrix += (2.0 * largestRowSum(stiffness) + 1.0) * product(rigid, rigid.transpose());
  return symmetricParts(matrix).vectors.leftCols(count);
}

/// Returns the factor of  K + s,  with a small s so that it has an inverse.
SparseFactor shiftedFactor(SparseMatrix stiffness) {
  const double stiffest = largestRowSum(stiffness), shift = stiffest > 0.0 ? kRelativeShift * stiffest : 1.0;
  for (Eigen::Index i = 0; i < stiffness.rows(); ++i) stiffness.coeffRef(i, i) += shift;
  return factorise(stiffness);
}

/// The space of block Lanczos with thick restarts (Wu, Simon 2000) for the inverse, whose largest eigenvalues
/// are the softest modes. It stores all products instead of using the three-term recurrence: the spaces are
/// small, and then round-off cannot create false copies of modes.
struct SoftSpace {
  const SparseFactor& factor;
  const Eigen::MatrixXd& rigid;
  Eigen::MatrixXd basis{}, product{};  ///< orthonormal, and the inverse times it; `columns` columns are used
  Eigen::Index columns = 0;
  Eigen::VectorXd values{};   ///< eigenvalues of the inverse within the space, descending
  Eigen::MatrixXd vectors{};  ///< columns x columns, in terms of the basis
  Random random{1};
};

void project(const SoftSpace& space, Eigen::Ref<Eigen::MatrixXd> block) {
  const auto basis = space.basis.leftCols(space.columns);
  block -= product(space.rigid, transposedProduct(space.rigid, block));
  block -= product(basis, transposedProduct(basis, block));
}

void randomise(SoftSpace& space, Eigen::Ref<Eigen::MatrixXd> block) {
  for (Eigen::Index j = 0; j < block.cols(); ++j)
    for (Eigen::Index i = 0; i < block.rows(); ++i) block(i, j) = space.random.uniform() - 0.5;
  block.colwise().normalize();
}

/// Makes the block orthonormal and orthogonal to the space and to rigid motions. Columns without a remainder
/// become random. Does so twice, because one pass leaves the round-off of the subtracted part (Parlett 1998,
/// section 6.9).
Block orthonormal(SoftSpace& space, Block block) {
  block.colwise().normalize();
  for (int pass = 0; pass < 2; ++pass) {
    project(space, block);
    for (Eigen::Index j = 0; j < kBlock; ++j) {
      auto v = block.col(j);
      const auto earlier = block.leftCols(j);
      v -= earlier * (earlier.transpose() * v).eval();
      if (!(v.norm() > kDependent)) {
        randomise(space, v);
        project(space, v);
        v -= earlier * (earlier.transpose() * v).eval();
      }
      v.normalize();
    }
  }
  return block;
}

/// Adds the block to the space and returns the next block, which the inverse makes from it.
Block extend(SoftSpace& space, const Block& block) {
  Block response = solve(space.factor, Eigen::MatrixXd(block));
  response -= product(space.rigid, transposedProduct(space.rigid, response));
  space.basis.middleCols(space.columns, kBlock) = block;
  space.product.middleCols(space.columns, kBlock) = response;
  space.columns += kBlock;
  return orthonormal(space, response);
}

void solveWithin(SoftSpace& space) {
  Eigen::MatrixXd small =
      transposedProduct(space.basis.leftCols(space.columns), space.product.leftCols(space.columns));
  small = (0.5 * (small + small.transpose())).eval();
  const SymmetricParts ritz = symmetricParts(small);
  space.values = ritz.values.reverse();
  space.vectors = ritz.vectors.rowwise().reverse();
}

bool isConverged(const SoftSpace& space, Eigen::Index count) {
  const Eigen::MatrixXd residuals =
      product(space.product.leftCols(space.columns), space.vectors.leftCols(count)) -
      product(space.basis.leftCols(space.columns), space.vectors.leftCols(count)) *
          space.values.head(count).asDiagonal();
  return (residuals.colwise().norm().transpose().array() <= kModeTolerance * space.values.head(count).array())
      .all();
}

/// Reduces the space to its softest `count` modes.
void shrink(SoftSpace& space, Eigen::Index count) {
  space.basis.leftCols(count) = product(space.basis.leftCols(space.columns), space.vectors.leftCols(count));
  space.product.leftCols(count) =
      product(space.product.leftCols(space.columns), space.vectors.leftCols(count));
  space.columns = count;
}

Block randomBlock(SoftSpace& space) {
  Block block(space.rigid.rows(), kBlock);
  randomise(space, block);
  return orthonormal(space, block);
}

/// Grows the space until it holds the `count` softest modes, or for kMaxBlocks blocks.
///
/// Symmetric shapes have equal modes, and tessellated boxes many mechanisms. A Krylov space holds at most one
/// block of equal modes, so a result is accepted only when new random vectors do not change it.
void converge(SoftSpace& space, Eigen::Index count) {
  Eigen::VectorXd previousValues = Eigen::VectorXd::Zero(count);
  Block next = randomBlock(space);
  for (int round = 1, sinceFresh = 1; round <= kMaxBlocks; ++round, ++sinceFresh) {
    next = extend(space, next);
    const bool isFull = space.columns + kBlock > space.basis.cols();
    if (space.columns < count || (sinceFresh % kBlocksBetweenChecks != 0 && !isFull)) continue;
    solveWithin(space);
    if (isConverged(space, count)) {
      const Eigen::VectorXd values = space.values.head(count);
      if (((values - previousValues).array().abs() <= kConfirmed * values.array()).all()) return;
      previousValues = values;
      shrink(space, count);
      next = randomBlock(space);
      sinceFresh = 0;
    } else if (isFull) {
      shrink(space, count + 2 * kBlock);
    }
  }
  solveWithin(space);  // the space has grown since the last solution
}

Eigen::MatrixXd sparseModes(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid, Eigen::Index count) {
  const SparseFactor factor = shiftedFactor(stiffness);
  SoftSpace space{factor, rigid};
  space.basis.resize(stiffness.rows(), 2 * count + 6 * kBlock);
  space.product.resize(stiffness.rows(), space.basis.cols());
  converge(space, count);
  return product(space.basis.leftCols(space.columns), space.vectors.leftCols(std::min(count, space.columns)));
}

constexpr int kRoughPasses = 2;

/// Computes shapes by inverse iteration of a random space (subspace iteration).
Eigen::MatrixXd roughShapes(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid, Eigen::Index count) {
  const SparseFactor factor = shiftedFactor(stiffness);
  Random random(1);
  Eigen::MatrixXd shapes(stiffness.rows(), (count + kBlock - 1) / kBlock * kBlock);
  for (double& x : shapes.reshaped()) x = random.uniform() - 0.5;
  for (int pass = 0; pass < kRoughPasses; ++pass) {
    shapes -= product(rigid, transposedProduct(rigid, shapes));
    for (Eigen::Index j = 0; j < shapes.cols(); j += kBlock)
      shapes.middleCols(j, kBlock) = solve(factor, Eigen::MatrixXd(shapes.middleCols(j, kBlock)));
    shapes -= product(rigid, transposedProduct(rigid, shapes));
    shapes = orthogonalColumns(shapes, shapes.cols());
  }
  return shapes;
}

}  // namespace

Modes roughModes(const SpringNetwork& network, std::size_t count) {
  const SparseMatrix rigidity = rigidityMatrix(network), stiffness = stiffnessMatrix(rigidity);
  if (stiffness.rows() <= kMaxDense || 4 * count > static_cast<std::size_t>(stiffness.rows()))
    return softestModes(network, count);
  return modesWithin(
      rigidity, roughShapes(stiffness, rigidMotions(network.restPoints), static_cast<Eigen::Index>(count)));
}

Modes softestModes(const SpringNetwork& network, std::size_t count) {
  const SparseMatrix rigidity = rigidityMatrix(network), stiffness = stiffnessMatrix(rigidity);
  const Eigen::MatrixXd rigid = rigidMotions(network.restPoints);
  const Eigen::Index unknowns = stiffness.rows(), available = unknowns - rigid.cols();
  const auto modeCount = static_cast<Eigen::Index>(std::min(count, static_cast<std::size_t>(available)));
  if (modeCount == 0) return {Eigen::VectorXd(0), Eigen::MatrixXd(unknowns, 0)};
  const bool isDense = unknowns <= kMaxDense || 4 * modeCount > unknowns;
  return modesWithin(
      rigidity, isDense ? denseModes(stiffness, rigid, modeCount) : sparseModes(stiffness, rigid, modeCount));
}

}  // namespace limber
