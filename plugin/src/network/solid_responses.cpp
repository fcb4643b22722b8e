// SPDX-License-Identifier: Zlib
// Integrates stiffness and mass of linear and quadratic tetrahedra, computes the slowest free vibrations of a
// solid body from quadratic ones, and its response to uniform and linear stresses and to these vibrations.

#include "network/material.h"

#include "network/masses.h"
#include "network/stability.h"

namespace limber {

// --- elements ----------------------------------------------------------------------------------------------

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Corners of the edges of a tetrahedron.
constexpr std::array<std::array<std::size_t, 2>, 6> kEdgeCorners{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Volume of a tetrahedron and the gradients (1/m) of its barycentric coordinates.
struct TetrahedronFrame {
  std::array<Vector3d, 4> gradients;
  double volume = 0.0;
};

TetrahedronFrame frameOf(const std::array<Vector3d, 4>& corners) {
  const Vector3d b = corners[1] - corners[0], c = corners[2] - corners[0], d = corners[3] - corners[0];
  const double determinant = b.dot(c.cross(d));
  TetrahedronFrame frame{
      {Vector3d::Zero(), c.cross(d) / determinant, d.cross(b) / determinant, b.cross(c) / determinant},
      determinant / 6.0};
  frame.gradients[0] = -(frame.gradients[1] + frame.gradients[2] + frame.gradients[3]);
  return frame;
}

template <class Nodes>
std::array<Vector3d, 4> fourCorners(const std::vector<Vector3d>& points, const Nodes& nodes) {
  return {points[nodes[0]], points[nodes[1]], points[nodes[2]], points[nodes[3]]};
}

/// Returns the stiffness between two shape functions with these gradients, for each volume:
/// mu (b a^T + a . b I) + lambda a b^T.
Matrix3d stiffnessBlock(const Vector3d& a, const Vector3d& b) {
  return kShearModulus * (a * b.transpose() + b * a.transpose() + Matrix3d(a.dot(b) * Matrix3d::Identity()));
}

/// Adds the blocks of all pairs of an element's nodes. block(i, j) returns the one of its nodes i and j.
template <class Nodes, class Block>
void addPairs(Triplets& triplets, const Nodes& nodes, const Block& block) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = 0; j < nodes.size(); ++j)
      if (nodes[i] >= nodes[j]) addBlock(triplets, nodes[i], nodes[j], block(i, j));
}

/// Returns the integral of the product of two quadratic shape functions, for a volume of 420.
double quadraticMass(std::size_t i, std::size_t j) {
  if (i > j) std::swap(i, j);
  if (j < 4) return i == j ? 6.0 : 1.0;
  const auto& [c, d] = kEdgeCorners[j - 4];
  if (i < 4) return i == c || i == d ? -4.0 : -6.0;
  const auto& [a, b] = kEdgeCorners[i - 4];
  const int shared = int(a == c) + int(a == d) + int(b == c) + int(b == d);
  return shared == 2 ? 32.0 : shared == 1 ? 16.0 : 8.0;
}

std::array<Vector3d, 10> quadraticGradients(const TetrahedronFrame& frame, const Eigen::Vector4d& position) {
  std::array<Vector3d, 10> gradients;
  for (std::size_t i = 0; i < 4; ++i) gradients[i] = (4.0 * position[Index(i)] - 1.0) * frame.gradients[i];
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [a, b] = kEdgeCorners[e];
    gradients[4 + e] =
        4.0 * (position[Index(a)] * frame.gradients[b] + position[Index(b)] * frame.gradients[a]);
  }
  return gradients;
}

/// Adds the stiffness of an element. Its integrand is of second degree, for which four points are exact.
void addQuadraticStiffness(Triplets& triplets, const std::array<std::uint32_t, 10>& nodes,
                           const TetrahedronFrame& frame) {
  const double near = 0.25 + 0.75 / std::sqrt(5.0), far = (1.0 - near) / 3.0;
  for (Index point = 0; point < 4; ++point) {
    Eigen::Vector4d position = Eigen::Vector4d::Constant(far);
    position[point] = near;
    const std::array<Vector3d, 10> g = quadraticGradients(frame, position);
    addPairs(triplets, nodes, [&](std::size_t i, std::size_t j) -> Matrix3d {
      return 0.25 * frame.volume * stiffnessBlock(g[i], g[j]);
    });
  }
}

}  // namespace

SolidMatrices linearElements(const TetrahedralMesh& mesh) {
  Triplets stiffness, mass;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    const TetrahedronFrame frame = frameOf(fourCorners(mesh.points, t));
    addPairs(stiffness, t, [&](std::size_t i, std::size_t j) -> Matrix3d {
      return frame.volume * stiffnessBlock(frame.gradients[i], frame.gradients[j]);
    });
    addPairs(mass, t, [&](std::size_t i, std::size_t j) -> Matrix3d {
      return frame.volume * (i == j ? 0.1 : 0.05) * Matrix3d::Identity();
    });
  }
  const auto points = static_cast<Index>(mesh.points.size());
  return {sumOf(stiffness, points), sumOf(mass, points)};
}

QuadraticMesh withMiddles(const TetrahedralMesh& mesh) {
  const std::vector<Edge> edges = uniqueEdges(mesh.tetrahedra);
  QuadraticMesh quadratic{mesh.points, {}};
  for (const Edge& e : edges) quadratic.nodes.push_back((mesh.points[e[0]] + mesh.points[e[1]]) / 2.0);
  for (const Tetrahedron& t : mesh.tetrahedra) {
    std::array<std::uint32_t, 10> nodes{t[0], t[1], t[2], t[3]};
    for (std::size_t e = 0; e < 6; ++e) {
      const Edge edge = edgeBetween(t[kEdgeCorners[e][0]], t[kEdgeCorners[e][1]]);
      const auto index = std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin();
      nodes[4 + e] = static_cast<std::uint32_t>(mesh.points.size() + std::size_t(index));
    }
    quadratic.tetrahedra.push_back(nodes);
  }
  return quadratic;
}

SolidMatrices quadraticElements(const QuadraticMesh& mesh) {
  Triplets stiffness, mass;
  for (const std::array<std::uint32_t, 10>& nodes : mesh.tetrahedra) {
    const TetrahedronFrame frame = frameOf(fourCorners(mesh.nodes, nodes));
    addQuadraticStiffness(stiffness, nodes, frame);
    addPairs(mass, nodes, [&](std::size_t i, std::size_t j) -> Matrix3d {
      return frame.volume / 420.0 * quadraticMass(i, j) * Matrix3d::Identity();
    });
  }
  const auto points = static_cast<Index>(mesh.nodes.size());
  return {sumOf(stiffness, points), sumOf(mass, points)};
}

// --- vibrations --------------------------------------------------------------------------------------------

namespace {

/// Returns the rows of these nodes, 3 #nodes x #columns.
MatrixXd rowsOf(const MatrixXd& matrix, const std::vector<std::uint32_t>& nodes) {
  MatrixXd rows(3 * static_cast<Index>(nodes.size()), matrix.cols());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    rows.middleRows<3>(3 * static_cast<Index>(i)) = matrix.middleRows<3>(3 * nodes[i]);
  return rows;
}

void subtractFromRows(MatrixXd& matrix, const std::vector<std::uint32_t>& nodes, const MatrixXd& rows) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    matrix.middleRows<3>(3 * nodes[i]) -= rows.middleRows<3>(3 * static_cast<Index>(i));
}

/// Returns the nodes of each piece, ascending. `elements` are the nodes of each tetrahedron.
template <class Elements>
std::vector<std::vector<std::uint32_t>> nodesOfPieces(const std::vector<Tetrahedron>& tetrahedra,
                                                      const Elements& elements) {
  const std::vector<std::uint32_t> piece = findPieces(tetrahedra);
  std::vector<std::vector<std::uint32_t>> nodes;
  for (std::size_t t = 0; t < elements.size(); ++t) {
    if (piece[t] == nodes.size()) nodes.emplace_back();
    nodes[piece[t]].insert(nodes[piece[t]].end(), elements[t].begin(), elements[t].end());
  }
  for (std::vector<std::uint32_t>& all : nodes) sortUnique(all);
  return nodes;
}

/// Makes forces on the nodes of a tetrahedral mesh self-equilibrated, for each piece of the body.
class ForceBalance {
 public:
  /// `elements`: the nodes of each tetrahedron. `mass`: the lower triangle, couples nodes of one piece only.
  template <class Elements>
  ForceBalance(const std::vector<Vector3d>& nodes, const std::vector<Tetrahedron>& tetrahedra,
               const Elements& elements, const Eigen::SparseMatrix<double>& mass) {
    MatrixXd motions = MatrixXd::Zero(3 * static_cast<Index>(nodes.size()), 6);
    for (std::vector<std::uint32_t>& piece : nodesOfPieces(tetrahedra, elements)) {
      const MatrixXd rigid = rigidMotions(chosen(nodes, piece));
      for (std::size_t i = 0; i < piece.size(); ++i)
        motions.block(3 * piece[i], 0, 3, rigid.cols()) = rigid.middleRows<3>(3 * static_cast<Index>(i));
      pieces_.push_back({std::move(piece), rigid, {}});
    }
    const MatrixXd momenta = symmetricProduct(mass, motions);
    for (Piece& piece : pieces_) piece.momenta = rowsOf(momenta, piece.nodes).leftCols(piece.motions.cols());
  }

  /// Subtracts the inertial forces of the rigid acceleration that the forces (3 #nodes x #loads) cause.
  void balance(MatrixXd& forces) const {
    for (const Piece& piece : pieces_) {
      const MatrixXd inertia = transposedProduct(piece.motions, piece.momenta);
      MatrixXd acceleration = transposedProduct(piece.motions, rowsOf(forces, piece.nodes));
      solveSmall(inertia, acceleration);
      subtractFromRows(forces, piece.nodes, product(piece.momenta, acceleration));
    }
  }

 private:
  struct Piece {
    std::vector<std::uint32_t> nodes;
    MatrixXd motions, momenta;  ///< 3 #nodes x 6: rigid motions, and the mass times these
  };
  std::vector<Piece> pieces_;
};

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
  const ForceBalance balance(modes.mesh.nodes, mesh.tetrahedra, modes.mesh.tetrahedra, solid.mass);
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

/// Returns the values of the ten shape functions at a position with these barycentric coordinates.
std::array<double, 10> quadraticShapes(const Eigen::Vector4d& barycentric) {
  std::array<double, 10> shapes{};
  for (std::size_t i = 0; i < 4; ++i) shapes[i] = barycentric[Index(i)] * (2.0 * barycentric[Index(i)] - 1.0);
  for (std::size_t e = 0; e < 6; ++e)
    shapes[4 + e] = 4.0 * barycentric[Index(kEdgeCorners[e][0])] * barycentric[Index(kEdgeCorners[e][1])];
  return shapes;
}

/// An element: its first corner, and the gradients of the barycentric coordinates.
struct Element {
  Vector3d corner;
  TetrahedronFrame frame;

  Eigen::Vector4d barycentric(const Vector3d& position) const {
    Eigen::Vector4d coordinates;
    for (Index i = 0; i < 4; ++i)
      coordinates[i] = (i == 0 ? 1.0 : 0.0) + frame.gradients[std::size_t(i)].dot(position - corner);
    return coordinates;
  }
};

/// Returns the element that contains the position, or the one with the largest smallest coordinate.
std::size_t elementAt(const std::vector<Element>& elements, const Vector3d& position) {
  std::size_t best = 0;
  double largest = -HUGE_VAL;
  for (std::size_t t = 0; t < elements.size() && largest < 0.0; ++t) {
    const double smallest = elements[t].barycentric(position).minCoeff();
    if (smallest > largest) largest = smallest, best = t;
  }
  return best;
}

}  // namespace

MatrixXd displacementsAt(const SolidModes& modes, const std::vector<Vector3d>& positions) {
  MatrixXd result = MatrixXd::Zero(3 * static_cast<Index>(positions.size()), modes.displacements.cols());
  std::vector<Element> elements;
  for (const auto& nodes : modes.mesh.tetrahedra)
    elements.push_back({modes.mesh.nodes[nodes[0]], frameOf(fourCorners(modes.mesh.nodes, nodes))});
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::size_t t = elementAt(elements, positions[i]);
    const std::array<double, 10> shapes = quadraticShapes(elements[t].barycentric(positions[i]));
    for (std::size_t node = 0; node < 10; ++node)
      result.middleRows<3>(3 * static_cast<Index>(i)) +=
          shapes[node] * modes.displacements.middleRows<3>(3 * Index(modes.mesh.tetrahedra[t][node]));
  }
  return result;
}

// --- responses to loads ------------------------------------------------------------------------------------

namespace {

/// Weights of the groups. The uniform stresses have the largest one: they define modulus and isotropy.
constexpr double kUniformWeight = 2.0, kLinearWeight = 1.0, kModeWeight = 1.0;

/// Number of vibrations, and of points of the mesh on which they are computed.
constexpr Index kModes = 20;
constexpr std::size_t kModePoints = 600;

/// A stress (Pa) that varies linearly about the centre of the body.
struct LinearStress {
  Matrix3d uniform = Matrix3d::Zero();
  std::array<Matrix3d, 3> slopes{Matrix3d::Zero(), Matrix3d::Zero(), Matrix3d::Zero()};  ///< along x, y, z

  Matrix3d at(const Vector3d& offset) const {
    return uniform + offset[0] * slopes[0] + offset[1] * slopes[1] + offset[2] * slopes[2];
  }
};

Matrix3d stressComponent(int a, int b) {
  Matrix3d stress = Matrix3d::Zero();
  stress(a, b) = stress(b, a) = 1.0;
  return stress;
}

std::vector<LinearStress> uniformStresses() {
  std::vector<LinearStress> stresses;
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) stresses.push_back({stressComponent(a, b)});
  return stresses;
}

/// Returns a basis of the linear stresses without divergence:  s_aa = x_b,  s_bc = x_a,  and
/// s_aa = x_a, s_ab = -x_b.
std::vector<LinearStress> linearStresses() {
  std::vector<LinearStress> stresses;
  for (int a = 0; a < 3; ++a) {
    LinearStress shear;
    shear.slopes[std::size_t(a)] = stressComponent((a + 1) % 3, (a + 2) % 3);
    stresses.push_back(shear);
    for (const int b : {(a + 1) % 3, (a + 2) % 3}) {
      LinearStress bending, mixed;
      bending.slopes[std::size_t(b)] = stressComponent(a, a);
      mixed.slopes[std::size_t(a)] = stressComponent(a, a);
      mixed.slopes[std::size_t(b)] = -stressComponent(a, b);
      stresses.insert(stresses.end(), {bending, mixed});
    }
  }
  return stresses;
}

/// Returns the forces of the stress on the surface, 3 #points, integrated against linear shape functions.
Eigen::VectorXd surfaceForces(const TetrahedralMesh& mesh, const LinearStress& stress,
                              const Vector3d& centre) {
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(3 * static_cast<Index>(mesh.points.size()));
  for (const Triangle& t : mesh.surface) {
    const auto [a, b, c] = cornersOf(mesh.points, t);
    const Vector3d area = areaVector(a, b, c);
    const Matrix3d sum = stress.at(a - centre) + stress.at(b - centre) + stress.at(c - centre);
    for (const std::uint32_t corner : t)
      forces.segment<3>(3 * Index(corner)) += (sum + stress.at(mesh.points[corner] - centre)) * area / 12.0;
  }
  return forces;
}

/// Returns  s : C^-1 : t  for a Young's modulus of 1 and a Poisson ratio of 1/4.
double energyProduct(const Matrix3d& s, const Matrix3d& t) {
  return 1.25 * s.cwiseProduct(t).sum() - 0.25 * s.trace() * t.trace();
}

double complianceOf(const LinearStress& s, const LinearStress& t, const SolidMoments& solid) {
  double sum = energyProduct(s.uniform, t.uniform);
  for (Index a = 0; a < 3; ++a)
    for (Index b = 0; b < 3; ++b)
      sum += solid.second(a, b) * energyProduct(s.slopes[std::size_t(a)], t.slopes[std::size_t(b)]);
  return solid.volume * sum;
}

/// Loads of one group, and the compliance that they should meet.
struct LoadGroup {
  MatrixXd loads, compliance;
  double weight = 1.0;
};

/// Combines the stresses so that the compliance is the unit matrix.
LoadGroup stressGroup(const TetrahedralMesh& mesh, const std::vector<LinearStress>& stresses,
                      const SolidMoments& solid, double weight) {
  const auto count = static_cast<Index>(stresses.size());
  MatrixXd forces(3 * static_cast<Index>(mesh.points.size()), count), compliance(count, count);
  for (Index i = 0; i < count; ++i) {
    const LinearStress& stress = stresses[std::size_t(i)];
    forces.col(i) = surfaceForces(mesh, stress, solid.centre);
    for (Index j = 0; j < count; ++j)
      compliance(i, j) = complianceOf(stress, stresses[std::size_t(j)], solid);
  }
  const SymmetricParts parts = symmetricParts(compliance);
  const MatrixXd scaled = parts.vectors * parts.values.cwiseSqrt().cwiseInverse().asDiagonal();
  return {product(forces, scaled), MatrixXd::Identity(count, count), weight};
}

/// Returns the response of a mesh of linear elements: loads^T K^-1 loads.
MatrixXd linearCompliance(const SolidMatrices& elements, const MatrixXd& loads) {
  // makes the matrix regular; the loads do not excite rigid motions
  const double shift = 1e-9 * elements.stiffness.diagonal().sum() / elements.mass.diagonal().sum();
  const SparseFactor factor = factorise(elements.stiffness + shift * elements.mass);
  return transposedProduct(loads, solve(factor, loads));
}

/// Returns the inertial forces of the modes on the points of a mesh. Their work on the modes' displacements
/// is the root of the compliance, so that the compliance is scaled to 1.
MatrixXd inertialForces(const TetrahedralMesh& mesh, const SolidMatrices& elements, const SolidModes& modes) {
  const MatrixXd displacements = displacementsAt(modes, mesh.points);
  MatrixXd forces = symmetricProduct(elements.mass, displacements);
  ForceBalance(mesh.points, mesh.tetrahedra, mesh.tetrahedra, elements.mass).balance(forces);
  for (Index i = 0; i < forces.cols(); ++i)
    forces.col(i) *= std::sqrt(modes.squaredFrequencies[i]) / forces.col(i).dot(displacements.col(i));
  return forces;
}

/// Returns the mesh itself, or one with fewer points of the same body.
std::optional<TetrahedralMesh> meshForModes(const TetrahedralMesh& mesh) {
  if (mesh.points.size() <= kModePoints) return mesh;
  const Result<WeldedMesh> welded = weld(meshOf(mesh.points, mesh.surface));
  if (!welded) return {};
  const Result<TetrahedralMesh> coarse = fillWithPoints(*welded, kModePoints);
  return coarse ? std::optional(*coarse) : std::nullopt;
}

std::optional<LoadGroup> modeGroup(const TetrahedralMesh& mesh) {
  const std::optional<TetrahedralMesh> coarse = meshForModes(mesh);
  if (!coarse) return {};
  const SolidModes modes = slowestModes(*coarse, kModes);
  const SolidMatrices fineElements = linearElements(mesh), coarseElements = linearElements(*coarse);
  const MatrixXd loads = inertialForces(mesh, fineElements, modes);
  const MatrixXd unit = MatrixXd::Identity(loads.cols(), loads.cols());
  if (coarse->points.size() >= mesh.points.size()) return LoadGroup{loads, unit, kModeWeight};
  const double pointsRatio = double(coarse->points.size()) / double(mesh.points.size());
  const MatrixXd missing =
      unit - linearCompliance(coarseElements, inertialForces(*coarse, coarseElements, modes));
  return LoadGroup{loads, linearCompliance(fineElements, loads) + std::pow(pointsRatio, 2.0 / 3.0) * missing,
                   kModeWeight};
}

void append(SolidResponses& responses, const LoadGroup& group) {
  const Index before = responses.loads.cols(), added = group.loads.cols();
  const auto extend = [&](MatrixXd& matrix, const MatrixXd& block) {
    matrix.conservativeResizeLike(MatrixXd::Zero(before + added, before + added));
    matrix.bottomRightCorner(added, added) = block;
  };
  responses.loads.conservativeResize(group.loads.rows(), before + added);
  responses.loads.rightCols(added) = group.loads;
  extend(responses.compliance, group.compliance);
  extend(responses.weights, MatrixXd::Constant(added, added, group.weight * group.weight));
}

}  // namespace

SolidResponses solidResponses(const TetrahedralMesh& mesh) {
  const SolidMoments solid = solidMoments(mesh.points, mesh.surface);
  SolidResponses responses;
  append(responses, stressGroup(mesh, uniformStresses(), solid, kUniformWeight));
  append(responses, stressGroup(mesh, linearStresses(), solid, kLinearWeight));
  if (const std::optional<LoadGroup> modes = modeGroup(mesh)) append(responses, *modes);
  return responses;
}

}  // namespace limber
