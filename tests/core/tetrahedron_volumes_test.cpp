// SPDX-License-Identifier: Zlib
// The volume term of tetrahedra: gradient, conservation, orientation, frequency.
#include "mesh/linear_algebra.h"
#include "solver/volumes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <optional>

#include <cmath>

namespace limber {
namespace {

/// Two tetrahedra with a face in common.
SpringNetwork pair() {
  SpringNetwork network;
  network.restPoints = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  network.massFractions.assign(5, 0.2);
  network.tetrahedra = {{0, 1, 2, 3}, {1, 4, 2, 3}};
  for (std::uint32_t a = 0; a < 5; ++a)
    for (std::uint32_t b = a + 1; b < 5; ++b)
      if (b != 4 || a != 0) network.springs.push_back({a, b});
  return network;
}

PointState pairState(const SpringNetwork& network) {
  PointState state;
  state.resize(static_cast<Eigen::Index>(network.restPoints.size()));
  for (Eigen::Index i = 0; i < state.position.cols(); ++i)
    state.position.col(i) = network.restPoints[static_cast<std::size_t>(i)];
  state.inverseMass.setConstant(2.0);
  return state;
}

TetrahedronVolumes tetrahedraOf(const SpringNetwork& network, std::optional<double> modulus,
                                const Eigen::Vector3d& scale = Eigen::Vector3d::Ones()) {
  SoftBodySettings settings;
  settings.volumeModulus = modulus;
  settings.scale = scale;
  return makeTetrahedronVolumes(network, settings);
}

TEST(TetrahedronVolumes, areAtRestAtRestAndWhenMirroredByTheScale) {
  const SpringNetwork network = pair();
  for (const Eigen::Vector3d& scale : {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(-2, 1, 3)}) {
    const TetrahedronVolumes v = tetrahedraOf(network, 100.0, scale);
    EXPECT_NEAR(v->restVolume[0], std::abs(scale.prod()) / 6.0, 1e-15);
    PointState state = pairState(network);
    state.position = scale.asDiagonal() * state.position;
    addTetrahedronForces(v, state);
    EXPECT_LT(state.force.norm(), 1e-12);
    EXPECT_NEAR(tetrahedronEnergy(v, state.position), 0.0, 1e-15);
  }
}

TEST(TetrahedronVolumes, haveTheGradientOfTheirEnergyAsForceAndNoNetForceOrTorque) {
  const SpringNetwork network = pair();
  const TetrahedronVolumes v = tetrahedraOf(network, 100.0);
  // in the linear range, compressed, crushed, inverted, swollen, and inverted beyond the limits
  for (const double stretch : {1.1, 0.5, 0.2, -0.7, 2.5, -1.5}) {
    SCOPED_TRACE(stretch);
    PointState state = pairState(network);
    state.position.row(0) *= stretch;
    for (Eigen::Index i = 0; i < 5; ++i)
      state.position(1, i) += 0.05 * std::sin(3.0 * static_cast<double>(i));
    state.position.colwise() += Eigen::Vector3d(3, -1, 2);
    addTetrahedronForces(v, state);
    const double largest = state.force.cwiseAbs().maxCoeff();
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < 5; ++i) {
      torque += Eigen::Vector3d(state.position.col(i)).cross(Eigen::Vector3d(state.force.col(i)));
      for (int axis = 0; axis < 3; ++axis) {
        Points left = state.position, right = state.position;
        left(axis, i) -= 1e-5, right(axis, i) += 1e-5;
        const double slope = (tetrahedronEnergy(v, right) - tetrahedronEnergy(v, left)) / 2e-5;
        EXPECT_NEAR(state.force(axis, i), -slope, 1e-6 * largest);  // rounding over 2e-5 m
      }
    }
    EXPECT_LT(state.force.rowwise().sum().norm(), 1e-13 * largest);
    EXPECT_LT(torque.norm(), 1e-12 * largest);
  }
}

TEST(TetrahedronVolumes, pushBackWhatIsTurnedOverEvenWithoutAModulus) {
  const SpringNetwork network = pair();
  const TetrahedronVolumes v = tetrahedraOf(network, 0.0);
  PointState state = pairState(network);
  state.position.row(0) *= 0.5;
  addTetrahedronForces(v, state);
  EXPECT_EQ(state.force.norm(), 0.0) << "half its volume is no crush";
  state.position.row(0) *= -2.0;
  addTetrahedronForces(v, state);
  EXPECT_GT(state.force(0, 1), 0.0) << "towards the side that it came from";
  EXPECT_GT(tetrahedronEnergy(v, state.position), 0.0);
}

TEST(TetrahedronVolumes, takeTheModulusOfTheSpringsByDefault) {
  const TetrahedronVolumes v = tetrahedraOf(pair(), {});
  EXPECT_GT(v->modulus, 0.0);
  EXPECT_EQ(v->modulus, 2.0 * v->crushModulus) << "with a modulus, less is needed against crushing";
  EXPECT_TRUE(tetrahedraOf(SpringNetwork{}, 5.0).empty());
}

TEST(TetrahedronVolumes, boundTheFrequencyTheyAdd) {
  const SpringNetwork network = pair();
  TetrahedronVolumes v = tetrahedraOf(network, 100.0);
  // not where the push is about to reach its limit: there the bound is that of the side of the limit
  for (const double stretch : {1.0, 1.4, 0.8, 0.1, -0.3}) {
    SCOPED_TRACE(stretch);
    PointState state = pairState(network);
    state.position.row(0) *= stretch;
    // the Hessian by differences of the forces, with equal masses of 1/2 kg
    Eigen::MatrixXd hessian(15, 15);
    for (Eigen::Index k = 0; k < 15; ++k) {
      PointState moved[2] = {state, state};
      for (int side = 0; side < 2; ++side) {
        moved[side].force.setZero();
        moved[side].position(k % 3, k / 3) += side == 0 ? -1e-6 : 1e-6;
        addTetrahedronForces(v, moved[side]);
      }
      hessian.col(k) = -(moved[1].force - moved[0].force).reshaped() / 2e-6;
    }
    const Eigen::MatrixXd symmetric = hessian + hessian.transpose();  // x 1/2 x 2 per kg
    const double largest = symmetricValues(symmetric).cwiseAbs().maxCoeff();
    const double bound = tetrahedronFrequencyBoundSquared(v, state);
    EXPECT_EQ(v.farFromRest, std::abs(stretch - 1.0) > 0.5);
    EXPECT_GE(bound, largest * (1.0 - 1e-6));
    EXPECT_LE(bound, 4.0 * largest) << "a bound that costs at most twice the substeps";
  }
}

/// For example, one point of a falling body is pinned.
TEST(TetrahedronVolumes, areRestlessWhereTheyComeFarFromRestInTheTick) {
  const SpringNetwork network = pair();
  TetrahedronVolumes v = tetrahedraOf(network, 100.0);
  PointState state = pairState(network);
  const auto farFromRest = [&](double tick) {
    tetrahedronFrequencyBoundSquared(v, state, tick);
    return v.farFromRest;
  };
  const Eigen::Vector3d fall(0.3, -7.5, 0.3);
  state.velocity.colwise() = fall;
  EXPECT_FALSE(farFromRest(1.0)) << "all of it falls";
  for (Eigen::Index i = 0; i < state.velocity.cols(); ++i)
    state.velocity.col(i) = Eigen::Vector3d(1, 2, 3).cross(state.position.col(i));
  EXPECT_FALSE(farFromRest(1.0)) << "it turns";
  state.velocity.colwise() = fall;
  state.velocity.col(0).setZero();
  EXPECT_FALSE(farFromRest(1e-3));
  EXPECT_TRUE(farFromRest(1.0));
}

}  // namespace
}  // namespace limber
