// SPDX-License-Identifier: Zlib
// Computes the response of a solid body to uniform and linear stresses and to its own vibrations.

#include "network/solid_responses.h"

#include "mesh/linear_algebra.h"
#include "network/masses.h"
#include "network/solid_modes.h"

#include <limber/mesh.h>

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

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
    const Vector3d &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    const Vector3d area = (b - a).cross(c - a) / 2.0;
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
  balanceOf(mesh, elements.mass).balance(forces);
  for (Index i = 0; i < forces.cols(); ++i)
    forces.col(i) *= std::sqrt(modes.squaredFrequencies[i]) / forces.col(i).dot(displacements.col(i));
  return forces;
}

/// Returns the mesh itself, or one with fewer points of the same body.
std::optional<TetrahedralMesh> meshForModes(const TetrahedralMesh& mesh) {
  if (mesh.points.size() <= kModePoints) return mesh;
  TriangleMesh surface;
  surface.positions = mesh.points;
  surface.triangles = mesh.surface;
  const Result<WeldedMesh> welded = weld(surface);
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
