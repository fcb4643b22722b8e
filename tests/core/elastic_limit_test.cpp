// SPDX-License-Identifier: Zlib
// Springs beyond their elastic limit, compared with the law in solver/springs.cpp.
#include "solver/springs.h"
#include "solver/stepping_choice.h"
#include "support/networks.h"
#include "support/stepped_body.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

using test::SteppedTestBody;

/// One spring of length 1 and k = 100 N/m between two points of 1/2 kg.
struct LimitedPair : SteppedTestBody {
  explicit LimitedPair(const ElasticLimit& limit) : SteppedTestBody(test::pairNetwork(), 100.0, 0.0) {
    settings.elasticLimit = limit;
    springs = makeSprings(*net, settings);
  }
  /// Returns the force (N) on point 0 towards point 1, with the points `length` apart.
  double forceAt(double length) {
    state.position.col(0).setZero();
    state.position.col(1) = Eigen::Vector3d(length, 0.0, 0.0);
    computeSpringForces(springs, state);
    EXPECT_DOUBLE_EQ(state.force(0, 0), -state.force(0, 1));
    return state.force(0, 0);
  }
};

TEST(ElasticLimit, isOffByDefault) {
  LimitedPair pair{ElasticLimit()};
  EXPECT_FALSE(pair.springs->limited);
  EXPECT_DOUBLE_EQ(pair.forceAt(3.0), 200.0);
  EXPECT_EQ(pair.springs->restLength[0], 1.0);
}

TEST(ElasticLimit, stiffensBeyondItsStrainOnBothSides) {
  ElasticLimit limit;
  limit.stiffenStrain = 0.1;
  limit.stiffenFactor = 4.0;
  LimitedPair pair(limit);
  EXPECT_NEAR(pair.forceAt(1.08), 8.0, 1e-12);
  EXPECT_NEAR(pair.forceAt(1.3), 10.0 + 4.0 * 20.0, 1e-12);
  EXPECT_NEAR(pair.forceAt(0.92), -8.0, 1e-12);
  EXPECT_NEAR(pair.forceAt(0.7), -10.0 - 4.0 * 20.0, 1e-12);
  EXPECT_NEAR(pair.forceAt(1.08), 8.0, 1e-12) << "elastic: nothing is left";
}

TEST(ElasticLimit, theStiffenedForceIsTheGradientOfTheEnergy) {
  ElasticLimit limit;
  limit.stiffenStrain = 0.1;
  limit.stiffenFactor = 7.0;
  LimitedPair pair(limit);
  const double step = 1e-6;
  for (const double length : {0.6, 0.95, 1.05, 1.5}) {
    const auto energyAt = [&](double l) {
      pair.state.position.col(1) = Eigen::Vector3d(l, 0.0, 0.0);
      return elasticEnergy(pair.springs, pair.state.position);
    };
    const double force = pair.forceAt(length);
    EXPECT_NEAR((energyAt(length + step) - energyAt(length - step)) / (2 * step), force, 1e-6) << length;
  }
}

TEST(ElasticLimit, countsWithItsStiffnessTowardsTheFastestOscillation) {
  std::vector<double> sums;
  ElasticLimit limit;
  LimitedPair plain(limit);
  limit.stiffenStrain = 0.1;
  limit.stiffenFactor = 9.0;
  LimitedPair stiffening(limit);
  const double bound = frequencyBoundSquared(plain.springs, plain.state.inverseMass, sums);
  EXPECT_DOUBLE_EQ(frequencyBoundSquared(stiffening.springs, stiffening.state.inverseMass, sums),
                   9.0 * bound);
}

TEST(ElasticLimit, yieldsPerfectlyPlasticallyAndKeepsThePermanentStrain) {
  ElasticLimit limit;
  limit.yieldStrain = 0.1;
  LimitedPair pair(limit);
  EXPECT_NEAR(pair.forceAt(1.09), 9.0, 1e-12) << "elastic below the limit";
  EXPECT_NEAR(pair.forceAt(1.3), 10.0, 1e-12) << "never more than k times the yield strain";
  EXPECT_NEAR(pair.springs->restLength[0], 1.2, 1e-12);
  EXPECT_NEAR(pair.forceAt(1.2), 0.0, 1e-12) << "unloaded it stays longer";
  EXPECT_NEAR(pair.forceAt(1.0), -10.0, 1e-12) << "and yields the other way";
  EXPECT_NEAR(pair.springs->restLength[0], 1.1, 1e-12);
}

TEST(ElasticLimit, yieldsNoFartherThanItsMaximum) {
  ElasticLimit limit;
  limit.yieldStrain = 0.1;
  limit.yieldMaximum = 0.3;
  LimitedPair pair(limit);
  EXPECT_NEAR(pair.forceAt(2.0), 100.0 * (2.0 - 1.3), 1e-12) << "elastic again from there";
  EXPECT_NEAR(pair.springs->restLength[0], 1.3, 1e-12);
  EXPECT_NEAR(pair.forceAt(0.2), -100.0 * (0.7 - 0.2), 1e-12);
  EXPECT_NEAR(pair.springs->restLength[0], 0.7, 1e-12);
}

TEST(ElasticLimit, yieldingDoesNotDependOnTheSubsteps) {
  // the points start with 2 m/s each; the largest length determines the permanent strain
  const auto restLengthAfter = [](int substeps) {
    ElasticLimit limit;
    limit.yieldStrain = 0.05;
    LimitedPair pair(limit);
    pair.state.position.col(1) = Eigen::Vector3d(1.0, 0.0, 0.0);
    pair.state.position.col(0).setZero();
    pair.state.velocity(0, 0) = -2.0;
    pair.state.velocity(0, 1) = 2.0;
    stepVerlet(pair.group, 1.0, substeps);
    return pair.springs->restLength[0];
  };
  const double reference = restLengthAfter(100000);
  EXPECT_GT(reference, 1.1);
  const double coarse = std::abs(restLengthAfter(100) - reference);
  const double fine = std::abs(restLengthAfter(200) - reference);
  EXPECT_LT(coarse, 0.02 * (reference - 1.0));
  EXPECT_LT(fine, 0.6 * coarse) << "it converges";
}

TEST(ElasticLimit, breaksForGoodWhenPulledAndNotWhenPressed) {
  ElasticLimit limit;
  limit.breakStrain = 0.5;
  LimitedPair pair(limit);
  EXPECT_NEAR(pair.forceAt(0.3), -70.0, 1e-12);
  EXPECT_NEAR(pair.forceAt(1.49), 49.0, 1e-12);
  EXPECT_EQ(pair.springs.broken, 0u);
  EXPECT_EQ(pair.forceAt(1.51), 0.0);
  EXPECT_EQ(pair.springs.broken, 1u);
  EXPECT_EQ(pair.forceAt(1.2), 0.0);
  EXPECT_EQ(pair.forceAt(0.5), 0.0);
  EXPECT_EQ(pair.springs.broken, 1u) << "once";
}

}  // namespace
}  // namespace limber
