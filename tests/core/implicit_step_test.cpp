// SPDX-License-Identifier: Zlib
// The implicit steppers without Bullet, compared with closed forms, conservation laws, and Verlet.
#include "solver/implicit_step.h"
#include "solver/point_state.h"
#include "solver/springs.h"
#include "support/networks.h"
#include "support/stepped_body.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>
#include <map>
#include <numeric>

namespace limber {
namespace {

using Kind = MidpointSolver::Kind;
using test::SteppedTestBody;

/// Joins all points that are near each other in two rows of `points` / 2 points.
std::vector<PointPair> ladder(std::uint32_t points) {
  std::vector<PointPair> joined;
  for (std::uint32_t i = 0; i < points; ++i)
    for (const std::uint32_t step : {1u, 2u, 3u})
      if (i + step < points) joined.push_back({(7 * i) % points, (7 * (i + step)) % points});
  return joined;
}

TEST(BlockMatrix, solvesAsTheDenseMatrixDoes) {
  const std::uint32_t points = 20;
  const std::vector<PointPair> joined = ladder(points);
  Eigen::MatrixXd dense = 10.0 * Eigen::MatrixXd::Identity(3 * points, 3 * points);
  BlockMatrix blocks;
  setPattern(blocks, joined, points);
  setZero(blocks);
  for (std::uint32_t i = 0; i < points; ++i) blocks.add(i, i, 10.0 * Eigen::Matrix3d::Identity());
  for (const auto& [i, j] : joined) {
    Eigen::Matrix3d block;
    for (Eigen::Index k = 0; k < 9; ++k) block(k / 3, k % 3) = std::sin(double(3 * i + 7 * j) + double(k));
    blocks.add(i, j, block);
    dense.block<3, 3>(3 * i, 3 * j) += block;
    dense.block<3, 3>(3 * j, 3 * i) += block.transpose();
  }
  Eigen::Matrix3Xd x(3, points), scratch(3, points);
  for (Eigen::Index k = 0; k < x.size(); ++k) x(k) = std::cos(double(k));
  const Eigen::VectorXd b = x.reshaped();
  factorise(blocks);
  solve(blocks, x, scratch);
  EXPECT_LT((dense * x.reshaped() - b).norm(), 1e-13 * double(x.size()));
}

TEST(BlockMatrix, staysSparse) {
  SoftBodySettings settings;
  const auto blocks = [&](const SharedNetwork& network) {
    const SpringArrays springs = makeSprings(*network, settings);
    const std::vector<std::uint32_t> fill = fillOf(joinedPoints({springs}), network->restPoints.size());
    return std::accumulate(fill.begin(), fill.end(), 0u);
  };
  EXPECT_EQ(blocks(test::chainNetwork(40)), 40u) << "nothing is filled in";
  EXPECT_EQ(blocks(test::fullCubeNetwork()), 28u) << "all points are joined";
}

class ImplicitStep : public testing::TestWithParam<Kind> {
 public:
  void advance(SteppedTestBody& body, double time, int substeps) {
    stepImplicit(body.stepped(), states[&body], GetParam(), time, substeps, factors);
  }
  void forget() { states.clear(); }
  std::map<const SteppedTestBody*, ImplicitState> states;
  SharedFactors factors;
};

TEST_P(ImplicitStep, isOfSecondOrderInFreeFlight) {
  for (const double damping : {0.0, 0.3}) {
    const auto finalPosition = [&](int substeps, bool verlet) {
      SteppedTestBody body(test::cubeNetwork(), 200.0, damping);
      forget();
      body.spin({1.0, 2.0, 3.0});
      body.state.position *= 1.05;
      body.state.acceleration.row(1).setConstant(-9.81);
      if (verlet)
        stepVerlet(body.group, 0.5, substeps);
      else
        advance(body, 0.5, substeps);
      return body.state.position;
    };
    const Points reference = finalPosition(12800, true);
    const double coarse = (finalPosition(200, false) - reference).norm();
    const double fine = (finalPosition(400, false) - reference).norm();
    EXPECT_GT(std::log2(coarse / fine), 1.9) << "damping " << damping;
  }
}

TEST_P(ImplicitStep, keepsMomentum) {
  SteppedTestBody body(test::cubeNetwork(), 500.0, 2.0);
  body.spin({1.0, 2.0, 3.0});
  body.state.velocity += Points::Random(3, 8);
  const Eigen::Vector3d p = linearMomentum(body.state), l = angularMomentum(body.state);
  advance(body, 10.0, 2400);
  // exact at every iteration; rounding positions to 1e-16 m gives an error of 1e-16 / h in the velocity, 2400
  // times
  EXPECT_LT((linearMomentum(body.state) - p).norm(), 1e-10);
  EXPECT_LT((angularMomentum(body.state) - l).norm(), 1e-10 * l.norm());
}

TEST_P(ImplicitStep, neverGainsEnergyHoweverStiff) {
  for (const double stiffness : {1e2, 1e5, 1e8})
    for (const double ratio : {0.0, 1.0, 1000.0}) {
      SteppedTestBody body(test::fullCubeNetwork(), stiffness, ratio * 2 * std::sqrt(stiffness * 0.125));
      forget();
      body.spin({1.0, -2.0, 0.5});
      body.state.position += 0.3 * Points::Random(3, 8);
      double minimum = body.energy();
      const double start = minimum;
      for (int i = 0; i < 300; ++i) {
        advance(body, 1.0 / 30, 1);
        // the fluctuation that implicit_step.cpp allows: in the motion, and in energy that cannot be removed
        // from it
        ASSERT_LT(body.energy(), minimum + 5e-4 * start) << "k " << stiffness << " damping " << ratio;
        minimum = std::min(minimum, body.energy());
      }
    }
}

TEST_P(ImplicitStep, creepsAtTheRightRateHoweverStronglyDamped) {
  // one spring to a static point, inertia negligible: x(t) = x0 exp(-k t / c)
  for (const double ratio : {10.0, 1e3, 1e5}) {
    const double k = 1000.0, mass = 0.5, c = ratio * 2.0 * std::sqrt(k * mass), time = c / k;
    SteppedTestBody body(test::pairNetwork(), k, c);
    forget();
    body.state.inverseMass.col(0).setZero();
    body.state.position(0, 1) += 0.1;
    advance(body, time, 200);
    const double remaining = body.state.position.col(1).x() - body.state.position.col(0).x() - 1.0;
    // inertia slows it by m k / c^2 = 1 / (4 ratio^2); the first substep, extrapolated to first order only,
    // has an error of about a substep
    EXPECT_NEAR(remaining, 0.1 * std::exp(-1.0), 0.1 * (0.01 + 1.0 / (ratio * ratio))) << ratio;
  }
}

/// Returns contacts of the lower points of a cube of 1 m with a plane at this depth (m) below its centre.
std::vector<PlaneContact> contactsOnPlane(const PointState& state, const Eigen::Vector3d& normal,
                                          double depth, double friction) {
  std::vector<PlaneContact> rows;
  for (std::uint32_t i = 0; i < 8; ++i)
    if (normal.dot(state.position.col(i)) < 0.0) {
      rows.emplace_back();
      rows.back().point = i;
      rows.back().normal = normal;
      rows.back().touch = -depth * normal;
      rows.back().friction = friction;
    }
  return rows;
}

TEST_P(ImplicitStep, restsOnAPlaneWithTheRightForce) {
  for (const double stiffness : {1e3, 1e6}) {
    SteppedTestBody body(test::fullCubeNetwork(), stiffness, 0.1 * 2 * std::sqrt(stiffness * 0.125));
    forget();
    body.state.acceleration.row(1).setConstant(-9.81);
    std::vector<PlaneContact> rows = contactsOnPlane(body.state, Eigen::Vector3d::UnitY(), 0.52, 0.0);
    ASSERT_EQ(rows.size(), 4u);
    body.contacts = &rows;
    double weight = 0.0;
    for (int tick = 0; tick < 600; ++tick) {
      for (PlaneContact& row : rows) row.impulse = TickImpulse();
      advance(body, 1.0 / 60, 4);
      weight = 0.0;
      for (const PlaneContact& row : rows) weight += row.impulse.sum.y() * 60.0;
    }
    EXPECT_NEAR(weight, 9.81, 1e-4 * 9.81) << stiffness;
    for (const PlaneContact& row : rows) EXPECT_NEAR(body.state.position(1, row.point), -0.52, 1e-9);
    EXPECT_LT(body.state.velocity.cwiseAbs().maxCoeff(), 1e-6);
    computeSpringForces(body.springs, body.state);
    for (std::uint32_t i = 0; i < 8; ++i) {
      if (body.state.position(1, i) < 0.0) continue;
      // local/global iterations converge slowly to the stiffest equilibrium
      const double tolerance = GetParam() == Kind::Shared ? 1e-3 : 1e-4;
      EXPECT_NEAR(body.state.force(1, i), 9.81 / 8, tolerance * 9.81) << "each upper point is carried";
    }
  }
}

/// Sliding points are all on the boundary of the friction cone. Rounding must not decide whether they stick.
TEST_P(ImplicitStep, slidesAlikeEverywhere) {
  const auto slide = [&](double x) {
    SteppedTestBody body(test::fullCubeNetwork(), 1e3, 1.0);
    forget();
    body.state.position.row(0).array() += x;
    body.state.velocity.row(0).setConstant(3.0);
    body.state.acceleration.row(1).setConstant(-9.81);
    std::vector<PlaneContact> rows = contactsOnPlane(body.state, Eigen::Vector3d::UnitY(), 0.52, 0.25);
    body.contacts = &rows;
    for (int tick = 0; tick < 30; ++tick) advance(body, 1.0 / 60, 5);
    body.state.position.row(0).array() -= x;
    return body.state.position;
  };
  const Points reference = slide(0.0);
  for (const double x : {1.0 / 3, 3.1, 7.7})
    EXPECT_LT((slide(x) - reference).cwiseAbs().maxCoeff(), 1e-8) << x;
}

TEST_P(ImplicitStep, whatIsOnlyNearChangesNothing) {
  const auto fly = [&](bool near) {
    SteppedTestBody body(test::fullCubeNetwork(), 1e4, 1.0);
    forget();
    body.state.velocity.row(0) = 5.0 * body.state.position.row(1);
    std::vector<PlaneContact> rows = contactsOnPlane(body.state, Eigen::Vector3d::UnitY(), 2.0, 0.5);
    if (near) body.contacts = &rows;
    for (int tick = 0; tick < 30; ++tick) advance(body, 1.0 / 60, 1);
    return body.state.position;
  };
  EXPECT_EQ(fly(true), fly(false));
}

TEST_P(ImplicitStep, whatIsOnlyNearIsNotSolvedFor) {
  SteppedTestBody body(test::fullCubeNetwork(), 1e4, 1.0);
  std::vector<PlaneContact> rows = contactsOnPlane(body.state, Eigen::Vector3d::UnitY(), 2.0, 0.5);
  body.contacts = &rows;
  advance(body, 1.0 / 60, 1);
  const std::vector<char>& responds = states[&body].contacts.responds;
  EXPECT_EQ(responds, std::vector<char>(4, 0)) << "none of the points reaches the plane";
}

TEST_P(ImplicitStep, errorIsThatOfThePresentMotion) {
  const auto errorRate = [&](bool afterAnother) {
    SteppedTestBody body(test::fullCubeNetwork(), 1e4, 0.0);
    const Points stretched = 1.02 * body.state.position;
    forget();
    if (afterAnother) advance(body, 1.0 / 60, 4);
    body.state.position = stretched;
    body.state.velocity.setZero();
    advance(body, 1.0 / 60, 8);
    return body.stepped().errorRate;
  };
  EXPECT_NEAR(errorRate(true), errorRate(false), 1e-9 * errorRate(false));
}

TEST_P(ImplicitStep, contactsAreTheSameInOtherUnits) {
  const auto finalPosition = [&](double length, double mass) {
    SteppedTestBody body(test::fullCubeNetwork(), mass * 1e4, mass * 5.0, mass);
    forget();
    body.settings.scale.setConstant(length);
    body.springs = makeSprings(*body.net, body.settings);
    const Eigen::Vector3d normal = Eigen::Vector3d(0.1, 1.0, 0.05).normalized();
    std::vector<PlaneContact> rows = contactsOnPlane(body.state, normal, 0.5, 0.5);
    for (PlaneContact& row : rows) row.touch *= length;
    body.state.position *= length;
    body.state.velocity.colwise() = length * Eigen::Vector3d(2.0, -0.5, 1.0);
    body.state.acceleration.row(1).setConstant(-9.81 * length);
    body.contacts = &rows;
    for (int tick = 0; tick < 60; ++tick) {
      for (PlaneContact& row : rows) row.impulse = TickImpulse();
      advance(body, 1.0 / 60, 4);
    }
    return Points(body.state.position / length);
  };
  EXPECT_EQ(finalPosition(1.0, 1.0), finalPosition(1024.0, 4.0)) << "powers of two: no other bits";
}

INSTANTIATE_TEST_SUITE_P(Kinds, ImplicitStep, testing::Values(Kind::Shared, Kind::Newton),
                         [](const auto& i) { return i.param == Kind::Shared ? "Shared" : "Newton"; });

TEST(SharedFactors, bodiesOfOneNetworkHaveOne) {
  SharedFactors factors;
  ImplicitState states[3];
  SteppedTestBody a(test::cubeNetwork(), 1e5, 0.1), b(test::cubeNetwork(), 1e5, 0.1),
      softer(test::cubeNetwork(), 1e4, 0.1);
  SteppedTestBody* bodies[] = {&a, &b, &softer};
  for (int i = 0; i < 3; ++i) stepImplicit(bodies[i]->stepped(), states[i], Kind::Shared, 0.01, 2, factors);
  EXPECT_EQ(states[0].solver.shared, states[1].solver.shared);
  EXPECT_NE(states[0].solver.shared, states[2].solver.shared);
}

/// The number of entries in the factor determines the cost of a body's first tick and of all later solves.
/// With a minimum degree ordering it is about n log n for a planar mesh of n points; a band would have
/// n^(3/2).
TEST(SharedFactors, ofAClothHaveFewEntries) {
  for (const std::uint32_t cells : {15u, 31u, 63u}) {
    ClothSettings settings;
    settings.columns = settings.rows = cells;
    SteppedTestBody cloth(*buildCloth(settings), 1e6, 0.1);
    SharedFactors factors;
    ImplicitState state;
    stepImplicit(cloth.stepped(), state, Kind::Shared, 1e-3, 1, factors);
    const double points = std::pow(cells + 1.0, 2);
    EXPECT_LT(static_cast<double>(state.solver.shared->factor.lower.nonZeros()),
              6.0 * points * std::log2(points));
  }
}

TEST(Newton, hangsAStiffChainRightInOneTick) {
  // 16 links of 0.1 kg, k = 1e8 N/m: the sag m g / k M (M + 1) / 2 is 1.3 micrometres
  const int links = 16;
  const double k = 1e8, mass = 0.1;
  SteppedTestBody body(test::chainNetwork(links), k, 2.0 * std::sqrt(k * mass), (links + 1) * mass);
  body.state.inverseMass.col(0).setZero();
  body.state.acceleration.row(1).setConstant(-9.81);
  body.state.acceleration.col(0).setZero();
  ImplicitState implicit;
  SharedFactors factors;
  for (int i = 0; i < 300; ++i) stepImplicit(body.stepped(), implicit, Kind::Newton, 1.0 / 30, 4, factors);
  const double sag = -1.0 - body.state.position(1, links);
  EXPECT_NEAR(sag, mass * 9.81 / k * links * (links + 1) / 2, 1e-4 * sag);
}

}  // namespace
}  // namespace limber
