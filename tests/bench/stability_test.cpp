// SPDX-License-Identifier: Zlib
// The measurements of the stability bench, compared with known values.
#include "stability/stability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

namespace limber::bench {
namespace {

HardCase oneCube(double stiffness) { return caseOf("test", "cube", 1, hardCube(stiffness, 0.1)); }

BodyStates atRest(const HardCase& hard) {
  const Eigen::Matrix3Xd x = restPositions(hard.bodies[0]);
  return {{x}, {Eigen::Matrix3Xd::Zero(3, x.cols())}};
}

ShapeCheck shapeOf(const HardCase& hard, const BodyStates& states) {
  const BodyStart start = startOf(hard.bodies[0]);
  return checkShape({hard.bodies[0], start, states.positions[0], states.velocities[0], hard.size, true});
}

TEST(EnergyBalance, AddsMotionSpringsAndHeight) {
  HardCase hard = oneCube(1e3);
  hard.gravity.y() = -10.0;
  hard.lowest = -2.0;
  BodyStates states = atRest(hard);
  const EnergyBalance balance(hard);
  EXPECT_NEAR(balance.energy(states, {}).value, 1.0 * 10.0 * 2.0, 1e-9);
  states.velocities[0].row(0).setConstant(3.0);
  EXPECT_NEAR(balance.energy(states, {}).value, 20.0 + 0.5 * 9.0, 1e-9);
  // twice as large: 12 edges, 12 face diagonals and 4 space diagonals are longer by their own lengths
  states.positions[0] *= 2.0;
  EXPECT_NEAR(balance.energy(states, {}).value, 24.5 + 0.5 * 1e3 * (12.0 + 12.0 * 2.0 + 4.0 * 3.0), 1e-6);
  EXPECT_NEAR(balance.momentum(states).x(), 3.0, 1e-12);
}

TEST(EnergyBalance, KnowsItsRounding) {
  const HardCase hard = oneCube(1e6);
  BodyStates states = atRest(hard);
  states.positions[0].colwise() += Eigen::Vector3d(100.0, 0.0, 0.0);
  const EnergyBalance balance(hard);
  states.positions[0] = states.positions[0].cast<btScalar>().cast<double>();
  const Energy energy = balance.energy(states, {});
  EXPECT_LE(energy.value, energy.rounding);
  EXPECT_LT(energy.rounding, 28 * 0.5 * 1e6 * 4e-10);  // d = 2^-24 (101 + 101) m at most
}

TEST(ShapeCheck, TurnedIsAtRest) {
  const HardCase hard = oneCube(1e3);
  BodyStates states = atRest(hard);
  const Eigen::AngleAxisd rotation(1.0, Eigen::Vector3d(1, 2, 3).normalized());
  states.positions[0] = (rotation.toRotationMatrix() * states.positions[0]).eval();
  EXPECT_EQ(shapeOf(hard, states).shape, Shape::Rest);
}

TEST(ShapeCheck, MirroredIsToldApart) {
  const HardCase hard = oneCube(1e3);
  BodyStates states = atRest(hard);
  states.positions[0].row(1) *= -1.0;
  EXPECT_EQ(shapeOf(hard, states).shape, Shape::Mirrored);
}

TEST(ShapeCheck, AStretchedOneIsLost) {
  const HardCase hard = oneCube(1e3);
  BodyStates states = atRest(hard);
  states.positions[0].row(0) *= 1.1;
  const ShapeCheck check = shapeOf(hard, states);
  EXPECT_EQ(check.shape, Shape::Lost);
  EXPECT_NEAR(check.error, 0.1, 1e-12);  // of the edges along x; smaller for the diagonals
}

TEST(ShapeCheck, ASpinningOneIsHeld) {
  const HardCase hard = oneCube(1e3);
  BodyStates states = atRest(hard);
  states.positions[0] *= 1.01;
  for (Eigen::Index i = 0; i < 8; ++i)
    states.velocities[0].col(i) =
        Eigen::Vector3d(0, 0, 30.0).cross(Eigen::Vector3d(states.positions[0].col(i)));
  EXPECT_EQ(shapeOf(hard, states).shape, Shape::Spinning);
}

TEST(ShapeCheck, AllInOnePlaceIsABalance) {
  const HardCase hard = oneCube(1e3);
  BodyStates states = atRest(hard);
  states.positions[0].setZero();
  const Shape shape = shapeOf(hard, states).shape;
  EXPECT_TRUE(shape == Shape::Other || shape == Shape::Saddle);
}

TEST(CaseResult, EachMissCounts) {
  CaseResult row;
  row.energyRatio = 1.0;
  EXPECT_TRUE(passes(row));
  const auto fails = [&](auto change) {
    CaseResult other = row;
    change(other);
    return !passes(other);
  };
  EXPECT_TRUE(fails([](CaseResult& r) { r.finite = false; }));
  EXPECT_TRUE(fails([](CaseResult& r) { r.energyRatio = 1.0011; }));
  EXPECT_TRUE(fails([](CaseResult& r) { r.energyRatio = std::nan(""); }));
  EXPECT_TRUE(fails([](CaseResult& r) { r.drift = 1.1e-6; }));
  EXPECT_TRUE(fails([](CaseResult& r) { r.spinDrift = 1.1e-3; }));
  EXPECT_TRUE(fails([](CaseResult& r) { r.shape = ShapeCheck{Shape::Lost, 0.1}; }));
  EXPECT_TRUE(fails([](CaseResult& r) { r.wrongSide = 1; }));
  EXPECT_TRUE(fails([](CaseResult& r) { r.reason = "no such thing"; }));
}

TEST(HardCases, AreTheSameEachTime) {
  const std::vector<HardCase> first = allHardCases(true), second = allHardCases(true);
  ASSERT_EQ(first.size(), second.size());
  std::set<std::string> groups;
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].name, second[i].name);
    EXPECT_EQ(first[i].bodies[0].positions, second[i].bodies[0].positions);
    groups.insert(first[i].group);
  }
  EXPECT_GE(groups.size(), 13u);  // --quick includes all groups
}

}  // namespace
}  // namespace limber::bench
