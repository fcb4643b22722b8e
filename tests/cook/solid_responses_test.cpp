// SPDX-License-Identifier: Zlib
// The reference of a material's springs: solids of finite elements, compared with closed forms.

#include "mesh/linear_algebra.h"
#include "mesh/surface.h"
#include "network/material.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

TetrahedralMesh filled(const TriangleMesh& mesh, std::size_t points) {
  return *fillWithPoints(*weld(mesh), points);
}

/// Displacements of all nodes, 3 #nodes, for a displacement field.
template <class Field>
Eigen::MatrixXd displacementsOf(const std::vector<Eigen::Vector3d>& nodes, const Field& field) {
  Eigen::MatrixXd u(3 * Eigen::Index(nodes.size()), 1);
  for (std::size_t i = 0; i < nodes.size(); ++i) u.middleRows<3>(3 * Eigen::Index(i)) = field(nodes[i]);
  return u;
}

/// Pure bending of a cube, s_xx = y, has the energy  1/(2E) integral of y^2 = 1/24.
TEST(SolidElements, quadraticOnesAreExactInBendingAndLinearOnesTooStiff) {
  const TetrahedralMesh mesh = filled(small_meshes::cube(1), 100);
  const auto bending = [](const Eigen::Vector3d& p) {
    const double x = p.x(), y = p.y(), z = p.z();
    return Eigen::Vector3d(x * y, -(x * x + (y * y - z * z) / 4) / 2, -y * z / 4);
  };
  const auto energy = [](const SolidMatrices& solid, const Eigen::MatrixXd& u) {
    return 0.5 * u.col(0).dot(symmetricProduct(solid.stiffness, u).col(0));
  };
  const QuadraticMesh quadratic = withMiddles(mesh);
  double volume = 0.0;
  for (const Tetrahedron& t : mesh.tetrahedra) volume += volumeOf(mesh.points, t);
  ASSERT_NEAR(volume, 1.0, 1e-9) << "the lattice fits the cube";
  EXPECT_NEAR(energy(quadraticElements(quadratic), displacementsOf(quadratic.nodes, bending)), 1.0 / 24.0,
              1e-12);
  EXPECT_GT(energy(linearElements(mesh), displacementsOf(mesh.points, bending)), 1.05 / 24.0);
}

TEST(SolidElements, haveTheMassOfTheirVolume) {
  const TetrahedralMesh mesh = filled(test_shapes::lShape(), 100);
  double volume = 0.0;
  for (const Tetrahedron& t : mesh.tetrahedra) volume += volumeOf(mesh.points, t);
  const QuadraticMesh quadratic = withMiddles(mesh);
  const auto right = [](const Eigen::Vector3d&) { return Eigen::Vector3d::UnitX(); };
  const Eigen::MatrixXd u = displacementsOf(quadratic.nodes, right), v = displacementsOf(mesh.points, right);
  EXPECT_NEAR(u.col(0).dot(symmetricProduct(quadraticElements(quadratic).mass, u).col(0)), volume,
              1e-12 * volume);
  EXPECT_NEAR(v.col(0).dot(symmetricProduct(linearElements(mesh).mass, v).col(0)), volume, 1e-12 * volume);
}

/// Lame's modes of a cube of edge 1, in which its sides stay plane and shear stress vanishes on them:
/// squared frequency 2 pi^2 G. The elements are too stiff by their error of fourth order.
TEST(SolidModes, ofACubeIncludeThoseOfLame) {
  const SolidModes modes = slowestModes(filled(small_meshes::cube(1), 300), 20);
  ASSERT_EQ(modes.squaredFrequencies.size(), 20);
  EXPECT_GT(modes.squaredFrequencies[0], 1.0) << "no rigid motion";
  const double lame = 2.0 * kPi * kPi * kShearModulus;
  EXPECT_GE(((modes.squaredFrequencies.array() / lame - 1.0).abs() < 0.003).count(), 2);
}

/// Two bodies that do not touch have twelve rigid motions, and the modes of both. Those of a body 1.2 times
/// as large are 1.2 times slower.
TEST(SolidModes, ofTwoPiecesAreThoseOfEach) {
  const TetrahedralMesh one = filled(small_meshes::cube(1), 60);
  TetrahedralMesh two = one;
  const auto count = static_cast<std::uint32_t>(one.points.size());
  for (const Eigen::Vector3d& p : one.points) two.points.push_back(1.2 * p + Eigen::Vector3d(3.0, 0.0, 0.0));
  for (const Tetrahedron& t : one.tetrahedra)
    two.tetrahedra.push_back({t[0] + count, t[1] + count, t[2] + count, t[3] + count});
  const Eigen::VectorXd alone = slowestModes(one, 12).squaredFrequencies;
  std::vector<double> expected;
  for (const double squared : alone) expected.insert(expected.end(), {squared, squared / 1.44});
  std::sort(expected.begin(), expected.end());
  const Eigen::VectorXd both = slowestModes(two, 12).squaredFrequencies;
  ASSERT_EQ(both.size(), 12);
  for (Eigen::Index i = 0; i < 12; ++i)
    EXPECT_NEAR(both[i] / expected[std::size_t(i)], 1.0, 0.01) << "after few iterations of the subspace";
}

TEST(SolidModes, areInterpolatedExactlyAtTheirNodes) {
  const SolidModes modes = slowestModes(filled(test_shapes::lShape(), 100), 8);
  EXPECT_LT((displacementsAt(modes, modes.mesh.nodes) - modes.displacements).cwiseAbs().maxCoeff(), 1e-9);
}

/// The loads must not push or turn the body. Under uniform stresses linear elements are exact, in bending and
/// in vibrations they are too stiff.
TEST(SolidResponses, areSelfEquilibratedAndSofterThanLinearElements) {
  const TetrahedralMesh mesh = filled(test_shapes::figure(), 150);
  const SolidResponses responses = solidResponses(mesh);
  const Eigen::Index points = Eigen::Index(mesh.points.size());
  for (Eigen::Index load = 0; load < responses.loads.cols(); ++load) {
    Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = force;
    for (Eigen::Index i = 0; i < points; ++i) {
      const Eigen::Vector3d f = responses.loads.block<3, 1>(3 * i, load);
      force += f;
      torque += mesh.points[std::size_t(i)].cross(f);
    }
    const double size = responses.loads.col(load).norm();
    EXPECT_LT(force.norm() + torque.norm(), 1e-9 * size) << "load " << load;
  }
  const SolidMatrices elements = linearElements(mesh);
  const SparseFactor factor = factorise(elements.stiffness + 1e-7 * elements.mass);
  const Eigen::MatrixXd u = solve(factor, responses.loads);
  for (Eigen::Index load = 0; load < responses.loads.cols(); ++load) {
    const double compliance = responses.loads.col(load).dot(u.col(load));
    if (load < 6)
      EXPECT_NEAR(compliance, responses.compliance(load, load), 1e-4);
    else
      EXPECT_LT(compliance, 1.02 * responses.compliance(load, load));
  }
}

/// A fit must not make the network worse, and must keep the limits.
TEST(ResponseFit, improvesTheResponseWithinTheLimits) {
  const TetrahedralMesh mesh = filled(test_shapes::lShape(), 100);
  SpringNetwork network;
  network.restPoints = mesh.points;
  network.tetrahedra = mesh.tetrahedra;
  network.surface = mesh.surface;
  setMaterialSprings(network);
  SpringLimits limits;
  for (NetworkSpring& s : network.springs) {
    s.stiffnessScale *= 1.5 * network.stiffnessPerModulus;
    limits.smallest.push_back(0.5 * s.stiffnessScale);
    limits.largest.push_back(1.1 * s.stiffnessScale);
  }
  const SolidResponses wanted = solidResponses(mesh);
  const auto misfit = [&] {
    const Eigen::MatrixXd u = LinearResponse({network}).displacements(wanted.loads);
    return (transposedProduct(wanted.loads, u) - wanted.compliance).cwiseProduct(wanted.weights).norm();
  };
  const double before = misfit();
  fitResponses(network, wanted, limits);
  EXPECT_LT(misfit(), 0.5 * before);
  for (std::size_t i = 0; i < network.springs.size(); ++i) {
    EXPECT_GE(network.springs[i].stiffnessScale, limits.smallest[i] * (1.0 - 1e-12));
    EXPECT_LE(network.springs[i].stiffnessScale, limits.largest[i] * (1.0 + 1e-12));
  }
}

}  // namespace
}  // namespace limber
