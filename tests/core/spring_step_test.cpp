// SPDX-License-Identifier: Zlib
// The Verlet step without Bullet, compared with closed forms and conservation laws.
#include "mesh/linear_algebra.h"
#include "solver/point_state.h"
#include "solver/springs.h"
#include "solver/stepping_choice.h"
#include "solver/verlet_step.h"
#include "support/networks.h"
#include "support/stepped_body.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

using Body = test::SteppedTestBody;

TEST(SpringForces, areTheGradientOfTheEnergy) {
  Body body(test::cubeNetwork(), 123.0, 0.0);
  body.settings.compressionStiffness = 77.0;
  body.springs = makeSprings(*body.net, body.settings);
  body.state.position += 0.2 * Points::Random(3, 8);
  body.state.force.setZero();
  computeSpringForces(body.springs, body.state);
  const double step = 1e-6;
  for (Eigen::Index i = 0; i < body.state.position.size(); ++i) {
    Points right = body.state.position, left = body.state.position;
    right.data()[i] += step;
    left.data()[i] -= step;
    const double slope =
        (elasticEnergy(body.springs, right) - elasticEnergy(body.springs, left)) / (2 * step);
    // central differences: step^2 times the third derivative, plus rounding 1e-16 * energy / step
    EXPECT_NEAR(body.state.force.data()[i], -slope, 1e-6) << i;
  }
}

TEST(SpringForces, coincidentEndsAndSlackSidesHaveNone) {
  EXPECT_EQ(springPull(Eigen::Vector3d::Zero(), 1.0, 10.0, 10.0).force, 0.0);
  const Eigen::Vector3d d(0.5, 0, 0);
  EXPECT_EQ(springPull(d, 1.0, 10.0, 0.0).force, 0.0) << "compressed, extension only";
  EXPECT_EQ(springPull(d, 1.0, 10.0, 0.0).direction, Eigen::Vector3d::Zero().eval())
      << "and no damper either";
  EXPECT_DOUBLE_EQ(springPull(d, 1.0, 10.0, 4.0).force, -2.0);
  EXPECT_DOUBLE_EQ(springPull(d, 0.0, 10.0, 4.0).force, 5.0) << "rest length 0";
}

TEST(VelocityVerlet, isOfSecondOrderInFreeFlight) {
  const auto finalPosition = [](int substeps, double damping) {
    Body body(test::cubeNetwork(), 200.0, damping);
    body.spin({1.0, 2.0, 3.0});
    body.state.position *= 1.05;
    body.state.acceleration.row(1).setConstant(-9.81);
    stepVerlet(body.group, 0.5, substeps);
    return body.state.position;
  };
  for (double damping : {0.0, 0.3}) {
    const Points reference = finalPosition(51200, damping);
    const double coarse = (finalPosition(200, damping) - reference).norm();
    const double fine = (finalPosition(400, damping) - reference).norm();
    EXPECT_GT(std::log2(coarse / fine), 1.9) << "damping " << damping;
  }
}

TEST(VelocityVerlet, keepsMomentumWithDamping) {
  Body body(test::cubeNetwork(), 500.0, 2.0);
  body.spin({1.0, 2.0, 3.0});
  body.state.velocity += Points::Random(3, 8);
  const Eigen::Vector3d p = linearMomentum(body.state), l = angularMomentum(body.state);
  stepVerlet(body.group, 10.0, 10000);
  EXPECT_LT((linearMomentum(body.state) - p).norm(), 1e-12);
  EXPECT_LT((angularMomentum(body.state) - l).norm(), 1e-11);
}

TEST(VelocityVerlet, reversesInTimeWithoutDamping) {
  Body body(test::cubeNetwork(), 500.0, 0.0);
  body.spin({1.0, 2.0, 3.0});
  body.state.position += 0.1 * Points::Random(3, 8);
  const Points start = body.state.position;
  stepVerlet(body.group, 1.0, 200);
  body.state.velocity = -body.state.velocity;
  stepVerlet(body.group, 1.0, 200);
  EXPECT_LT((body.state.position - start).norm(), 1e-9);
}

TEST(Damping, decayIsBoundedFallingAndCloseToTheExponential) {
  double previous = 1.0;
  for (double z = 0.01; z < 1e6; z *= 1.3) {
    const double d = decay(z);
    EXPECT_GT(d, 0.0);
    EXPECT_LT(d, previous);
    if (z < 1.0) {
      EXPECT_NEAR(d, std::exp(-z), std::pow(z, 5) / 120 + 1e-15);
    }
    previous = d;
  }
  EXPECT_EQ(decay(0.0), 1.0);
}

TEST(Damping, neverLimitsTheStepFromNoneToAThousandTimesCritical) {
  const double stiffness = 1000.0, mass = 0.125;
  for (double ratio : {0.0, 1e-3, 0.1, 1.0, 10.0, 1000.0}) {
    Body body(test::cubeNetwork(), stiffness, ratio * 2 * std::sqrt(stiffness * mass));
    body.spin({1.0, -2.0, 0.5});
    body.state.position += 0.2 * Points::Random(3, 8);
    const double start = body.energy();
    std::vector<double> sums;
    Stepping coarsest;
    coarsest.periodTolerance = 1.0;  // as coarse as stability allows
    const double tick = 1.0 / 60;
    const double bound = frequencyBoundSquared(body.springs, body.state.inverseMass, sums);
    const int n = substepCount({bound, bound}, tick, coarsest);
    double highest = 0.0;
    for (int i = 0; i < 600; ++i) {
      stepVerlet(body.group, tick, n);
      highest = std::max(highest, body.energy());
    }
    // close to the stability limit the energy of the stiffest oscillations fluctuates by a factor of up to 1
    // / (1 - (omega dt)^2 / 4); the test is that it stays bounded, and falls with damping
    EXPECT_LT(highest, 1.6 * start) << "ratio " << ratio;
    if (ratio >= 0.1) {
      EXPECT_LT(body.energy(), start) << "ratio " << ratio;
    }
  }
}

TEST(Damping, relativeSpeedOfAPairDecaysExponentially) {
  // only a damper, masses 1/2 kg each: u(t) = u0 exp(-c (2 + 2) t)
  const double total = 0.25 * 4.0 * 0.5;
  for (int substeps : {1, 3, 50}) {
    Body body(test::pairNetwork(), 1e-9, 0.25);
    body.state.velocity(0, 1) = 0.01;
    stepVerlet(body.group, 0.5, substeps);
    const double u = body.state.velocity(0, 1) - body.state.velocity(0, 0);
    // the share of each half or whole substep differs from the exponential's by up to z^3 / 3
    const double z = total / substeps;
    EXPECT_NEAR(u, 0.01 * std::exp(-total), 0.01 * substeps * z * z * z / 3 + 1e-9) << substeps;
  }
}

/// Returns the velocities after `time` seconds in which only the dampers act, at fixed positions, by the
/// classical Runge-Kutta method in many steps.
Points dampedTruth(const Body& body, double time, int steps) {
  const PointState& p = body.state;
  const auto acceleration = [&](const Points& v) {
    Points a = Points::Zero(3, v.cols());
    for (std::size_t s = 0; s < body.springs.size(); ++s) {
      const Eigen::Index i = body.springs->a[s], j = body.springs->b[s];
      const Eigen::Vector3d n = (p.position.col(j) - p.position.col(i)).normalized();
      const Eigen::Vector3d f = body.springs->damping[s] * n.dot(v.col(j) - v.col(i)) * n;
      a.col(i) += f * p.inverseMass(0, i);
      a.col(j) -= f * p.inverseMass(0, j);
    }
    return a;
  };
  Points v = p.velocity;
  for (int i = 0; i < steps; ++i) {
    const double h = time / steps;
    const Points k1 = acceleration(v), k2 = acceleration(v + 0.5 * h * k1);
    const Points k3 = acceleration(v + 0.5 * h * k2), k4 = acceleration(v + h * k3);
    v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return v;
}

TEST(Damping, smoothMotionSlowsDownAsItShouldWhereASubstepWouldStopAPair) {
  // a block that bends: its neighbours hardly move against each other, so it slows down much later than a
  // pair
  for (const double damping : {1.0, 5.0, 20.0}) {
    Body body(test::tetrahedralBlockNetwork(8, 2, 2), 1e-9, damping);
    const double length = body.state.position.row(0).maxCoeff() - body.state.position.row(0).minCoeff();
    for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
      const double x = (body.state.position(0, i) - body.state.position.row(0).minCoeff()) / length;
      body.state.velocity(1, i) = 1e-6 * std::cos(2 * 3.14159 * x);
    }
    // up to eight times the time in which a damper alone would stop its pair, in each of four substeps
    const double time = 0.01, pair = damping * 2 * body.state.inverseMass(0, 0) * time;
    const double before = body.state.velocity.norm();
    const Points truth = dampedTruth(body, time, static_cast<int>(10 * pair) + 100);
    stepVerlet(body.group, time, 4);
    EXPECT_LT(truth.norm(), 0.92 * before);
    // one sweep a substep with the shares of single pairs is off by 0.3 of the velocity at the strongest
    // with up to 1.5 pair times a sweep by 0.017, less than the 0.04 by which periods may be off
    EXPECT_LT((body.state.velocity - truth).norm(), 0.02 * before) << damping;
  }
}

/// Returns omega^2 of the fastest mode of M^-1 K at rest, from the dense matrix.
double denseEigenvalue(const Body& body) {
  const Eigen::Index n = body.state.position.size();
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t s = 0; s < body.springs.size(); ++s) {
    const Eigen::Index a = body.springs->a[s], b = body.springs->b[s];
    const Eigen::Vector3d d = (body.state.position.col(b) - body.state.position.col(a)).normalized();
    const Eigen::Matrix3d block = body.springs->extensionStiffness[s] * d * d.transpose();
    k.block<3, 3>(3 * a, 3 * a) += block;
    k.block<3, 3>(3 * b, 3 * b) += block;
    k.block<3, 3>(3 * a, 3 * b) -= block;
    k.block<3, 3>(3 * b, 3 * a) -= block;
  }
  const Eigen::Map<const Eigen::VectorXd> w(body.state.inverseMass.data(), n);
  const Eigen::VectorXd root = w.cwiseSqrt();
  const Eigen::MatrixXd symmetric = root.asDiagonal() * k * root.asDiagonal();
  return symmetricValues(symmetric).maxCoeff();
}

TEST(FrequencyBound, liesAboveTheTrueLargestEigenvalueAndNotFar) {
  for (const SharedNetwork& network :
       {test::pairNetwork(), test::chainNetwork(16), test::cubeNetwork(), test::fullCubeNetwork()}) {
    Body body(network, 1000.0, 0.0);
    body.state.inverseMass.col(0).setConstant(0.3);  // one heavy point
    std::vector<double> sums;
    const double bound = frequencyBoundSquared(body.springs, body.state.inverseMass, sums);
    const double exact = denseEigenvalue(body);
    EXPECT_GE(bound, exact * (1 - 1e-12));
    EXPECT_LT(bound, 3.2 * exact);
  }
}

TEST(FastestOscillation, isTheLargestEigenvalue) {
  for (const SharedNetwork& network :
       {test::pairNetwork(), test::chainNetwork(16), test::cubeNetwork(), test::fullCubeNetwork()}) {
    Body body(network, 1000.0, 0.0);
    body.state.inverseMass.col(0).setConstant(0.3);
    const double exact = denseEigenvalue(body);
    EXPECT_NEAR(fastestOscillationSquared(body.springs, {}, {}, body.state, 1e-6), exact, 1e-9 * exact);
    // for a residual r, the error is r^2 over the distance to the next eigenvalue
    EXPECT_NEAR(fastestOscillationSquared(body.springs, {}, {}, body.state, 0.03), exact, 0.01 * exact);
  }
}

TEST(FastestOscillation, ofAStretchedSpringIsAcrossIt) {
  // at twice its rest length: k (wa + wb) along the spring, and force / length = k / 2 instead of k across it
  Body body(test::pairNetwork(), 1000.0, 0.0);
  const double along = fastestOscillationSquared(body.springs, {}, {}, body.state, 1e-6);
  body.state.position.col(1) = 2.0 * body.state.position.col(1) - body.state.position.col(0);
  EXPECT_NEAR(fastestOscillationSquared(body.springs, {}, {}, body.state, 1e-6), along, 1e-9 * along);
  body.state.inverseMass.row(0).setZero();  // the spring is along x
  EXPECT_NEAR(fastestOscillationSquared(body.springs, {}, {}, body.state, 1e-6), 0.5 * along, 1e-9 * along);
}

TEST(FrequencyBound, isExactForASpringOnAHeldPoint) {
  Body body(test::pairNetwork(), 1000.0, 0.0);
  body.state.inverseMass.col(0).setZero();
  std::vector<double> sums;
  EXPECT_DOUBLE_EQ(frequencyBoundSquared(body.springs, body.state.inverseMass, sums), 1000.0 * 2.0);
}

TEST(CoincidentPoints, arePutApartAroundTheirCentre) {
  Body body(test::fullCubeNetwork(), 100.0, 0.0);
  body.state.position.setZero();
  body.state.inverseMass.col(3).setZero();
  separateCoincident(body.springs, body.state);
  EXPECT_LT(body.state.position.cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_TRUE(body.state.position.col(3).isZero(0.0)) << "held";
  for (std::size_t s = 0; s < body.springs.size(); ++s)
    EXPECT_GT(
        (body.state.position.col(body.springs->b[s]) - body.state.position.col(body.springs->a[s])).norm(),
        0.0);
  Body pair(test::pairNetwork(), 100.0, 0.0);
  pair.state.position.setOnes();
  pair.state.inverseMass.col(1) *= 3.0;
  separateCoincident(pair.springs, pair.state);
  EXPECT_LT((centerOfMass(pair.state) - Eigen::Vector3d::Ones()).norm(), 1e-15);
  const Points before = pair.state.position;
  separateCoincident(pair.springs, pair.state);
  EXPECT_TRUE((pair.state.position.array() == before.array()).all()) << "apart already";
}

}  // namespace
}  // namespace limber
