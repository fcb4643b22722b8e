// SPDX-License-Identifier: Zlib
// Measures the moduli of a body of springs: solves for its small displacements under uniform stresses.

#include "network/material.h"

#include "network/masses.h"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Fraction of the largest diagonal entry, which is added to the diagonal: without it, rigid motions would
/// make the matrix singular. The forces do not excite them. The softest modes of solids have 1e-5 of the
/// largest entry and more.
constexpr double kShift = 1e-10;

using Positions = std::vector<Vector3d>;

Positions scaledPoints(const ElasticBody& body) {
  Positions points = body.network.restPoints;
  for (Vector3d& p : points) p = p.cwiseProduct(body.scale);
  return points;
}

/// Returns the points as columns.
Eigen::Map<const MatrixXd> asMatrix(const Positions& points) {
  return {points.front().data(), 3, static_cast<Index>(points.size())};
}

/// Adds springs without tension: k n n^T along their directions n.
void addSprings(const ElasticBody& body, const Positions& points, Triplets& triplets) {
  for (const NetworkSpring& s : body.network.springs) {
    const Vector3d n = (points[s.b] - points[s.a]).normalized();
    const Matrix3d block = body.stiffness * s.stiffnessScale * n * n.transpose();
    addBlock(triplets, s.a, s.a, block);
    addBlock(triplets, s.b, s.b, block);
    addBlock(triplets, s.b, s.a, -block);
  }
}

/// At rest the volume term K/2 (V - V0)^2 / V0 of a tetrahedron has the Hessian K/V0 g g^T. g is the gradient
/// of the volume: for each corner a third of the area vector of the opposite face, pointing to the corner.
void addTetrahedra(const ElasticBody& body, const Positions& points, Triplets& triplets) {
  for (const Tetrahedron& t : body.network.tetrahedra) {
    const Vector3d a = points[t[0]], b = points[t[1]] - a, c = points[t[2]] - a, d = points[t[3]] - a;
    std::array<Vector3d, 4> g{Vector3d::Zero(), c.cross(d) / 6.0, d.cross(b) / 6.0, b.cross(c) / 6.0};
    g[0] = -(g[1] + g[2] + g[3]);
    const double factor = body.volumeModulus / std::abs(b.dot(g[1]));
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        if (t[i] >= t[j]) addBlock(triplets, t[i], t[j], factor * g[i] * g[j].transpose());
  }
}

/// Returns sqrt(K/V0) g for the volume term of the whole inside of the surface.
MatrixXd surfaceGradient(const ElasticBody& body, const Positions& points) {
  MatrixXd gradient = MatrixXd::Zero(3 * static_cast<Index>(points.size()), 1);
  for (const Triangle& t : body.network.surface)
    for (const std::uint32_t corner : t) gradient.block<3, 1>(3 * corner, 0) += areaVector(points, t) / 3.0;
  // the volume is a homogeneous function of third degree (Euler)
  const double volume = std::abs(gradient.col(0).dot(asMatrix(points).reshaped())) / 3.0;
  return gradient * std::sqrt(body.volumeModulus / volume);
}

}  // namespace

LinearResponse::LinearResponse(const ElasticBody& body) : points_(scaledPoints(body)) {
  Triplets triplets;
  addSprings(body, points_, triplets);
  if (body.volumeModulus > 0.0) addTetrahedra(body, points_, triplets);
  Eigen::SparseMatrix<double> stiffness = sumOf(triplets, static_cast<Index>(points_.size()));
  const double shift = kShift * stiffness.diagonal().maxCoeff();
  for (Index i = 0; i < stiffness.rows(); ++i) stiffness.coeffRef(i, i) += shift;
  factor_ = factorise(stiffness);
  if (body.volumeModulus <= 0.0 || !body.network.tetrahedra.empty()) return;
  volumeGradient_ = surfaceGradient(body, points_);
  volumeResponse_ = solve(factor_, volumeGradient_);
}

/// Includes the volume term, of rank one, by the formula of Sherman and Morrison. This keeps the matrix
/// sparse.
MatrixXd LinearResponse::displacements(const MatrixXd& forces) const {
  MatrixXd u = solve(factor_, forces);
  if (volumeGradient_.size() == 0) return u;
  const double gradientDotResponse = volumeGradient_.col(0).dot(volumeResponse_.col(0));
  return u - product(volumeResponse_, transposedProduct(volumeGradient_, u)) / (1.0 + gradientDotResponse);
}

namespace {

constexpr int kDirections = 40;

/// Returns one of kDirections directions, spread evenly over a half sphere by the golden angle.
Vector3d direction(int i) {
  const double z = (i + 0.5) / kDirections, radius = std::sqrt(1.0 - z * z);
  const double angle = i * kPi * (3.0 - std::sqrt(5.0));
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/// Returns one of the uniform stresses xx, yy, zz, yz, xz, xy of 1 Pa.
Matrix3d unitStress(int i) {
  Matrix3d stress = Matrix3d::Zero();
  const int a = i < 3 ? i : (i - 2) % 3, b = i < 3 ? i : (i - 1) % 3;
  stress(a, b) = stress(b, a) = 1.0;
  return stress;
}

/// Returns the coefficients of the unit stresses in the stress d d^T.
std::array<double, 6> uniaxial(const Vector3d& d) {
  return {d[0] * d[0], d[1] * d[1], d[2] * d[2], d[1] * d[2], d[2] * d[0], d[0] * d[1]};
}

/// Adds the tractions of a stress along a direction that grows in proportion to the coordinate `across` of
/// the points, integrated against linear shape functions. The force of a corner is area / 12 times the sum of
/// the stresses at all corners, where its own stress counts twice.
void addTractions(const Positions& points, const Triangle& t, const Vector3d& along,
                  const Eigen::RowVectorXd& across, Eigen::Ref<MatrixXd> forces) {
  const double area = along.dot(areaVector(points, t));
  const double sum = across[t[0]] + across[t[1]] + across[t[2]];
  for (const std::uint32_t corner : t)
    forces.block<3, 1>(3 * Index(corner), 0) += area / 12.0 * (sum + across[corner]) * along;
}

/// Adds the loads of a body's bending, 3 #points x 6: stresses along each principal axis of the solid that
/// grow across each other. Returns the moduli, which are still the work of a body of 1 Pa.
std::array<BendingModulus, 6> addBending(const SpringNetwork& network, const Positions& points,
                                         Eigen::Ref<MatrixXd> forces) {
  const SolidMoments solid = solidMoments(points, network.surface);
  const SymmetricParts3 principal = symmetricParts3(solid.second);
  std::array<BendingModulus, 6> moduli;
  for (Index load = 0; load < 6; ++load) {
    const Index along = load / 2, across = (along + 1 + load % 2) % 3;
    const Eigen::RowVectorXd height =
        principal.vectors.col(across).transpose() * (asMatrix(points).colwise() - solid.centre);
    for (const Triangle& t : network.surface)
      addTractions(points, t, principal.vectors.col(along), height, forces.col(load));
    moduli[static_cast<std::size_t>(load)] = {solid.volume * principal.values[across],
                                              std::sqrt(principal.values[along] / principal.values[across])};
  }
  return moduli;
}

/// The mean strain under each unit stress, and the response to bending.
struct Responses {
  std::array<Matrix3d, 6> strains;
  std::array<BendingModulus, 6> bending;
};

Responses responsesOf(const ElasticBody& body) {
  const LinearResponse response(body);
  const Positions& points = response.points();
  MatrixXd forces = MatrixXd::Zero(3 * static_cast<Index>(points.size()), 12);
  double volume = 0.0;
  for (const Triangle& t : body.network.surface) {
    const Vector3d area = areaVector(points, t);
    volume += area.dot(points[t[0]]) / 3.0;
    for (int load = 0; load < 6; ++load)
      for (const std::uint32_t corner : t)
        forces.block<3, 1>(3 * corner, load) += unitStress(load) * area / 3.0;
  }
  Responses found;
  found.bending = addBending(body.network, points, forces.rightCols(6));
  const MatrixXd u = response.displacements(forces);
  for (int load = 0; load < 6; ++load) {
    Matrix3d sum = Matrix3d::Zero();
    for (const Triangle& t : body.network.surface)
      for (const std::uint32_t corner : t)
        sum += u.block<3, 1>(3 * corner, load) * areaVector(points, t).transpose() / 3.0;
    found.strains[static_cast<std::size_t>(load)] = (sum + sum.transpose()) / (2.0 * volume);
  }
  for (Index load = 0; load < 6; ++load)
    found.bending[static_cast<std::size_t>(load)].modulus /= forces.col(6 + load).dot(u.col(6 + load));
  return found;
}

}  // namespace

ElasticModuli measureModuli(const ElasticBody& body) {
  const Responses found =
      responsesOf({body.network, body.stiffness, body.volumeModulus, body.scale.cwiseAbs()});
  ElasticModuli moduli;
  for (int i = 0; i < kDirections; ++i) {
    const Vector3d d = direction(i);
    const std::array<double, 6> part = uniaxial(d);
    Matrix3d strain = Matrix3d::Zero();
    for (std::size_t load = 0; load < 6; ++load) strain += part[load] * found.strains[load];
    const double along = d.dot(strain * d);
    moduli.youngsModuli.push_back(1.0 / along);
    moduli.youngsModulus += 1.0 / (along * kDirections);
    moduli.poissonRatio += 0.5 * (along - strain.trace()) / (along * kDirections);
  }
  const auto [smallest, largest] =
      std::minmax_element(moduli.youngsModuli.begin(), moduli.youngsModuli.end());
  moduli.isotropy = *smallest / *largest;
  moduli.bulkModulus = 1.0 / (found.strains[0] + found.strains[1] + found.strains[2]).trace();
  moduli.bending = found.bending;
  return moduli;
}

}  // namespace limber
