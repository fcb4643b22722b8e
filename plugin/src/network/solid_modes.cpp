// SPDX-License-Identifier: Zlib
// Computes the slowest free vibrations of a solid body from quadratic finite elements.

#include "network/solid_modes.h"

#include "mesh/linear_algebra.h"
#include "network/modes.h"
#include "network/sparse_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Returns the rows of these nodes, 3 #nodes x #columns.
MatrixXd rowsOf(const MatrixXd& matrix, const std::vector<Index>& nodes) {
  MatrixXd rows(3 * static_cast<Index>(nodes.size()), matrix.cols());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    rows.middleRows<3>(3 * static_cast<Index>(i)) = matrix.middleRows<3>(3 * nodes[i]);
  return rows;
}

void subtractFromRows(MatrixXd& matrix, const std::vector<Index>& nodes, const MatrixXd& rows) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    matrix.middleRows<3>(3 * nodes[i]) -= rows.middleRows<3>(3 * static_cast<Index>(i));
}

/// Returns the nodes of each piece, ascending. `elements` are the nodes of each tetrahedron.
template <class Elements>
std::vector<std::vector<Index>> nodesOfPieces(const std::vector<Tetrahedron>& tetrahedra,
                                              const Elements& elements) {
  const std::vector<std::uint32_t> piece = findPieces(tetrahedra);
  std::vector<std::vector<Index>> nodes;
  for (std::size_t t = 0; t < elements.size(); ++t) {
    if (piece[t] == nodes.size()) nodes.emplace_back();
    nodes[piece[t]].insert(nodes[piece[t]].end(), elements[t].begin(), elements[t].end());
  }
  for (std::vector<Index>& all : nodes) {
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
  }
  return nodes;
}

}  // namespace

ForceBalance::ForceBalance(const std::vector<Vector3d>& nodes, std::vector<std::vector<Index>> pieces,
                           const Eigen::SparseMatrix<double>& mass) {
  MatrixXd motions = MatrixXd::Zero(3 * static_cast<Index>(nodes.size()), 6);
  for (std::vector<Index>& piece : pieces) {
    std::vector<Vector3d> positions;
    positions.reserve(piece.size());
    for (const Index node : piece) positions.push_back(nodes[static_cast<std::size_t>(node)]);
    const MatrixXd rigid = rigidMotions(positions);
    for (std::size_t i = 0; i < piece.size(); ++i)
      motions.block(3 * piece[i], 0, 3, rigid.cols()) = rigid.middleRows<3>(3 * static_cast<Index>(i));
    pieces_.push_back({std::move(piece), rigid, {}});
  }
  const MatrixXd momenta = symmetricProduct(mass, motions);
  for (Piece& piece : pieces_) piece.momenta = rowsOf(momenta, piece.nodes).leftCols(piece.motions.cols());
}

void ForceBalance::balance(MatrixXd& forces) const {
  for (const Piece& piece : pieces_) {
    const MatrixXd inertia = transposedProduct(piece.motions, piece.momenta);
    MatrixXd acceleration = transposedProduct(piece.motions, rowsOf(forces, piece.nodes));
    solveSmall(inertia, acceleration);
    subtractFromRows(forces, piece.nodes, product(piece.momenta, acceleration));
  }
}

ForceBalance balanceOf(const TetrahedralMesh& mesh, const Eigen::SparseMatrix<double>& mass) {
  return {mesh.points, nodesOfPieces(mesh.tetrahedra, mesh.tetrahedra), mass};
}

namespace {

/// Vectors of the subspace beyond the modes that are wanted, which make those converge faster.
constexpr Index kExtraVectors = 12;

constexpr int kSubspaceIterations = 6;

/// Combinations of displacements with less than this fraction of the largest modal mass are dropped.
constexpr double kMinModalMass = 1e-10;

/// Returns displacements of first to third degree, 3 #nodes x 54, without the rotations.
MatrixXd smoothDisplacements(const std::vector<Vector3d>& nodes) {
  const Eigen::Matrix3Xd offsets = principalSpread(nodes).offsets;
  MatrixXd displacements = MatrixXd::Zero(3 * offsets.cols(), 54);
  Index column = 0;
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b, ++column)
      for (Index i = 0; i < offsets.cols(); ++i) {
        displacements(3 * i + a, column) += offsets(b, i);
        displacements(3 * i + b, column) += offsets(a, i);
      }
  for (int degree = 2; degree <= 3; ++degree)
    for (int x = 0; x <= degree; ++x)
      for (int y = 0; x + y <= degree; ++y)
        for (int axis = 0; axis < 3; ++axis, ++column)
          for (Index i = 0; i < offsets.cols(); ++i)
            displacements(3 * i + axis, column) = std::pow(offsets(0, i), x) * std::pow(offsets(1, i), y) *
                                                  std::pow(offsets(2, i), degree - x - y);
  return displacements;
}

/// Replaces the vectors by the modes within their span (Rayleigh, Ritz): M-orthonormal, slowest first.
/// Returns the eigenvalues of the stiffness.
Eigen::VectorXd takeModes(MatrixXd& vectors, const Eigen::SparseMatrix<double>& stiffness,
                          const Eigen::SparseMatrix<double>& mass) {
  vectors.colwise().normalize();
  const SymmetricParts masses = symmetricParts(transposedProduct(vectors, symmetricProduct(mass, vectors)));
  const double smallest = kMinModalMass * masses.values[masses.values.size() - 1];
  const Index kept = (masses.values.array() > smallest).count();
  const MatrixXd whitening =
      masses.vectors.rightCols(kept) * masses.values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  vectors = product(vectors, whitening);
  SymmetricParts modes = symmetricParts(transposedProduct(vectors, symmetricProduct(stiffness, vectors)));
  vectors = product(vectors, modes.vectors);
  return modes.values;
}

/// Returns a small stiffness per mass, which makes the matrix regular: rigid motions have none.
double shiftOf(const SolidMatrices& solid) {
  return 1e-6 * solid.stiffness.diagonal().sum() / solid.mass.diagonal().sum();
}

}  // namespace

SolidModes slowestModes(const TetrahedralMesh& mesh, Index count) {
  SolidModes modes{withMiddles(mesh), {}, {}};
  const SolidMatrices solid = quadraticElements(modes.mesh);
  const ForceBalance balance(modes.mesh.nodes, nodesOfPieces(mesh.tetrahedra, modes.mesh.tetrahedra),
                             solid.mass);
  const SparseFactor factor = factorise(solid.stiffness + shiftOf(solid) * solid.mass);
  MatrixXd vectors = smoothDisplacements(modes.mesh.nodes);
  for (int i = 0; i < kSubspaceIterations; ++i) {
    MatrixXd forces = symmetricProduct(solid.mass, vectors);
    balance.balance(forces);
    vectors = solve(factor, forces);
    modes.squaredFrequencies = takeModes(vectors, solid.stiffness, solid.mass);
    vectors = vectors.leftCols(std::min(vectors.cols(), count + kExtraVectors)).eval();
  }
  const Index found = std::min(vectors.cols(), count);
  modes.squaredFrequencies = modes.squaredFrequencies.head(found).eval();
  modes.displacements = vectors.leftCols(found);
  return modes;
}

namespace {

std::array<Vector3d, 4> elementCorners(const QuadraticMesh& mesh, std::size_t element) {
  const auto& nodes = mesh.tetrahedra[element];
  return {mesh.nodes[nodes[0]], mesh.nodes[nodes[1]], mesh.nodes[nodes[2]], mesh.nodes[nodes[3]]};
}

/// Returns the element that contains the position, or the one with the largest smallest coordinate.
std::size_t elementAt(const QuadraticMesh& mesh, const Vector3d& position) {
  std::size_t best = 0;
  double largest = -HUGE_VAL;
  for (std::size_t t = 0; t < mesh.tetrahedra.size() && largest < 0.0; ++t) {
    const double smallest = barycentricCoordinates(elementCorners(mesh, t), position).minCoeff();
    if (smallest > largest) largest = smallest, best = t;
  }
  return best;
}

}  // namespace

MatrixXd displacementsAt(const SolidModes& modes, const std::vector<Vector3d>& positions) {
  MatrixXd result = MatrixXd::Zero(3 * static_cast<Index>(positions.size()), modes.displacements.cols());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::size_t t = elementAt(modes.mesh, positions[i]);
    const std::array<double, 10> shapes =
        quadraticShapes(barycentricCoordinates(elementCorners(modes.mesh, t), positions[i]));
    for (std::size_t node = 0; node < 10; ++node)
      result.middleRows<3>(3 * static_cast<Index>(i)) +=
          shapes[node] * modes.displacements.middleRows<3>(3 * Index(modes.mesh.tetrahedra[t][node]));
  }
  return result;
}

}  // namespace limber
