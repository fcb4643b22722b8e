// SPDX-License-Identifier: Zlib
// Bodies whose budget (maxSubsteps) is far below what Verlet needs are softened: the number of substeps, what
// is softened and by how much, and contacts, pins, anchors, links and rigid partners.
#include "support/soft_world.h"

#include <cmath>
#include <memory>
#include <vector>

namespace limber::test {
namespace {

constexpr int kBudget = 20;

SoftBodySettings stiff(double stiffness, double mass) {
  SoftBodySettings s = testedSettings();
  setSprings(s, stiffness, 0.0);
  s.totalMass = mass;
  s.stepping.maxSubsteps = kBudget;
  return s;
}

/// Root mean square of the springs' strains.
double strainOf(const SoftBody& body) {
  const SpringNetwork& network = body.network();
  double sum = 0.0;
  for (const auto& spring : network.springs) {
    const Eigen::Vector3d rest = network.restPoints[spring.b] - network.restPoints[spring.a];
    const double length = (body.position(spring.b) - body.position(spring.a)).norm();
    sum += std::pow(length / rest.cwiseProduct(body.settings().scale).norm() - 1.0, 2);
  }
  return std::sqrt(sum / static_cast<double>(network.springs.size()));
}

TEST(BudgetInContact, holdsAtAnyStiffness) {
  for (const double stiffness : {1e3, 1e5, 1e7}) {
    SoftWorld bullet(-kGravity);
    bullet.addPlaneFloor();
    bullet.addBox({btScalar(0.2), btScalar(0.2), btScalar(0.2)}, 2.0, {0, 2, 0});
    SoftBodySettings s = stiff(stiffness, 1.0);
    s.position.y() = 0.6;
    SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
    for (int tick = 0; tick < 120; ++tick) {
      bullet.tick();
      ASSERT_LE(body->substeps(), kBudget) << stiffness;
    }
    EXPECT_LT(strainOf(*body), 0.05) << stiffness;
  }
}

TEST(BudgetInContact, aBoxRestsOnAStiffCube) {
  SoftWorld bullet(-kGravity);
  bullet.addPlaneFloor();
  btRigidBody* box = bullet.addBox({btScalar(0.3), btScalar(0.3), btScalar(0.3)}, 5.0, {0, btScalar(1.5), 0});
  SoftBodySettings s = stiff(1e6, 1.0);
  s.collision = Collision::Surface;
  s.position.y() = 0.53;
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), s);
  bullet.simulate(5.0);
  const double radius = pointRadius(body->network(), body->settings());
  // the cube's edge, twice its radius, and half of the box
  EXPECT_NEAR(heightOf(*box), 1.0 + 2.0 * radius + 0.3, 0.02);
  EXPECT_LT(double(box->getLinearVelocity().length()), 0.01);
  EXPECT_LE(body->substeps(), kBudget);
}

TEST(BudgetInContact, aStackOfTenStands) {
  if (testedSettings().collision == Collision::Points) GTEST_SKIP() << "corners alone do not stack";
  SoftWorld bullet(-kGravity);
  bullet.addPlaneFloor();
  SoftBodySettings s = stiff(1e6, 1.0);
  s.damping = 20.0;
  std::vector<SoftBody*> cubes;
  for (int i = 0; i < 10; ++i) {
    s.position.y() = 0.55 + 1.05 * i;
    cubes.push_back(bullet.addSoft(closedCubeNetwork(), s));
  }
  bullet.simulate(5.0);
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    const double radius = pointRadius(cubes[i]->network(), cubes[i]->settings());
    const double height = 0.5 + radius + static_cast<double>(i) * (1.0 + 2.0 * radius);
    EXPECT_NEAR(cubes[i]->centerOfMass().y(), height, 0.01) << i;
    EXPECT_LE(cubes[i]->substeps(), kBudget);
  }
}

/// A cloth on a ball: how it hangs at the end, and its largest strain on the way.
struct Drape {
  double height = 0.0, strain = 0.0, largest = 0.0;
  int substeps = 0;
};

Drape drape(double stiffness, int maxSubsteps, double seconds) {
  SoftWorld bullet(-kGravity);
  bullet.add(std::make_unique<btSphereShape>(btScalar(0.3)), 0.0, {0, 0, 0});
  SoftBodySettings s = stiff(stiffness, 0.2);
  s.damping = 0.01;
  s.position.y() = 0.4;
  s.pointRadius = 0.005;
  s.stepping.maxSubsteps = maxSubsteps;
  SoftBody* body = bullet.addSoft(squareCloth(14), s);
  Drape result;
  for (int tick = 0; tick < static_cast<int>(60 * seconds); ++tick) {
    bullet.tick();
    result.substeps = std::max(result.substeps, body->substeps());
    result.largest = std::max(result.largest, strainOf(*body));
  }
  result.height = body->centerOfMass().y();
  result.strain = strainOf(*body);
  return result;
}

TEST(BudgetInContact, aStiffClothStretchesLessWithALargerBudget) {
  const Drape coarse = drape(5e4, kBudget, 3.0), fine = drape(5e4, 2 * kBudget, 3.0);
  EXPECT_LE(coarse.substeps, kBudget);
  EXPECT_LE(fine.substeps, 2 * kBudget);
  EXPECT_LT(coarse.largest, 0.02);
  // twice the substeps resolve four times the stiffness; folds make the strain differ from a quarter
  EXPECT_LT(fine.strain, 0.5 * coarse.strain);
}

TEST(BudgetInContact, anyStiffnessBeyondTheBudgetGivesTheSameMotion) {
  const Drape stiff = drape(1e5, kBudget, 1.0), stiffer = drape(1e8, kBudget, 1.0);
  // both are softened to what the substeps resolve; rounding of the constants differs
  EXPECT_NEAR(stiff.height, stiffer.height, 1e-3);
  EXPECT_NEAR(stiff.strain, stiffer.strain, 1e-4);
}

// --- softening ---------------------------------------------------------------------------------------------

/// A body that has played one tick in free flight.
struct Played {
  BulletWorld bullet{0.0};
  SoftBodySystem system{*bullet.world};
  SoftBody* body;

  Played(const SharedNetwork& network, const SoftBodySettings& settings)
      : body(*system.createBody(network, settings)) {
    bullet.tick();
  }
};

TEST(Softening, isOnlyWhatTheBudgetDoesNotResolve) {
  SoftBodySettings s = stiff(1e3, 1.0);
  s.stepping.maxSubsteps = 1000;
  EXPECT_EQ(Played(closedCubeNetwork(), s).body->softening(), 1.0);
  s = stiff(1e6, 1.0);
  s.stepping.maxSubsteps = 0;
  EXPECT_EQ(Played(closedCubeNetwork(), s).body->softening(), 1.0);
}

TEST(Softening, isInverseToTheStiffnessAndGrowsWithTheSquareOfTheBudget) {
  const auto share = [](double stiffness, int budget) {
    SoftBodySettings s = stiff(stiffness, 1.0);
    s.stepping.maxSubsteps = budget;
    return Played(closedCubeNetwork(), s).body->softening();
  };
  const double once = share(1e6, 10);
  EXPECT_LT(once, 0.1);
  EXPECT_NEAR(share(1e8, 10), 0.01 * once, 1e-6 * once);
  EXPECT_NEAR(share(1e6, 20), 4.0 * once, 1e-6 * once);
}

TEST(Softening, sparesTheSpringsThatAreSlowEnough) {
  // a row of four points: one spring of the settings' stiffness, two far softer ones
  SpringNetwork network;
  network.restPoints = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  network.massFractions = {0.25, 0.25, 0.25, 0.25};
  for (std::uint32_t i = 0; i < 3; ++i) {
    NetworkSpring spring;
    spring.a = i, spring.b = i + 1;
    spring.stiffnessScale = i == 0 ? 1.0 : 1e-6;
    network.springs.push_back(spring);
  }
  SoftBodySettings s = stiff(1e8, 1.0);
  s.pointRadius = 0.05;
  s.damping = 0.0;
  s.stepping.stepper = Stepper::Verlet;
  std::vector<double> ends;
  for (const int budget : {kBudget, 0}) {
    s.stepping.maxSubsteps = budget;
    SoftWorld bullet(0.0);
    SoftBody* body = bullet.addSoft(std::make_shared<SpringNetwork>(network), s);
    body->point(3)->setLinearVelocity(btVector3(btScalar(0.1), 0, 0));
    for (int tick = 0; tick < 60; ++tick) bullet.tick();
    EXPECT_EQ(body->softening() < 0.1, budget > 0);
    for (std::uint32_t i = 1; i < 4; ++i) ends.push_back(body->position(i).x() - body->position(i - 1).x());
  }
  // k = 100 N/m and 0.25 kg: some six oscillations, with amplitudes of 3 mm
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(ends[i], ends[i + 3], 2e-5) << i;
}

TEST(Softening, withoutABudgetIsThatOfTenThousandSubsteps) {
  constexpr double kMass = 1e-9, kStiffness = 1e12, kSpeed = 1e4;
  SoftBodySettings s = stiff(kStiffness, kMass);
  s.pointRadius = 0.01;
  s.stepping.maxSubsteps = 0;
  s.stepping.stepper = Stepper::Verlet;
  Played played(pairNetwork(), s);
  const double softened = played.body->softening() * kStiffness;
  EXPECT_LT(softened, 1e4);
  // the ends fly apart: with half the mass each, the spring stretches by  v / omega,  omega^2 = 4 k / m
  for (const std::uint32_t end : {0u, 1u})
    played.body->point(end)->setLinearVelocity(vec(end == 0 ? -0.5 * kSpeed : 0.5 * kSpeed, 0, 0));
  double largest = 0.0;
  for (int tick = 0; tick < 60; ++tick) {
    played.bullet.tick(1.0 / (61.0 + tick));  // a quarter of the oscillation is one substep of 1/60 s / 10000
    ASSERT_LE(played.body->substeps(), 10000);
    largest = std::max(largest, (played.body->position(1) - played.body->position(0)).norm() - 1.0);
  }
  EXPECT_EQ(played.body->restorations(), 0u);
  const double amplitude = kSpeed / std::sqrt(4.0 * softened / kMass);
  EXPECT_GT(largest, 0.9 * amplitude);
  // as few substeps a period as a budget leaves let the amplitude vary by the root of 2
  EXPECT_LT(largest, 1.5 * amplitude);
}

TEST(Softening, isThatOfTheLongestTick) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), stiff(1e6, 1.0));
  const auto shareAfter = [&](double tick) {
    bullet.tick(tick);
    return body->softening();
  };
  const double once = shareAfter(1.0 / 60);
  const double longer = shareAfter(1.0 / 50);
  EXPECT_NEAR(longer, once * 25 / 36, 1e-4 * once) << "a longer tick must stay stable";
  EXPECT_EQ(shareAfter(1.0 / 240), longer) << "a stiffer body would have more energy";
}

TEST(Softening, keepsMomentaInFreeFlight) {
  SoftBodySettings s = stiff(1e7, 1.0);
  s.linearVelocity = {1, 2, 3};
  s.angularVelocity = {3, -2, 5};
  Played played(closedCubeNetwork(), s);
  const Eigen::Vector3d momentum = played.body->linearMomentum(), spin = played.body->angularMomentum();
  const double energy = energyOf(*played.body);
  for (int tick = 0; tick < 300; ++tick) played.bullet.tick();
  EXPECT_LE(played.body->substeps(), kBudget);
  // Bullet's velocities are in single precision
  EXPECT_LT((played.body->linearMomentum() - momentum).norm(), 1e-5 * momentum.norm());
  EXPECT_LT((played.body->angularMomentum() - spin).norm(), 1e-4 * spin.norm());
  EXPECT_LT(energyOf(*played.body), 1.01 * energy);
}

TEST(Softening, ofAChainAtRestIsThatOfItsStiffness) {
  constexpr int kLinks = 8;
  constexpr double kStiffness = 1e6, kMass = 1.0;
  // each link bears the weight below it: of the points' equal masses, the lowest 1, 2, ...
  double elongation = 0.0;
  for (int below = 1; below <= kLinks; ++below)
    elongation += below * kMass / (kLinks + 1) * kGravity / kStiffness;
  double last = 1.0;
  for (const int budget : {3, 5, 10, 20, 40, 80, 0}) {
    SoftWorld bullet(-kGravity);
    SoftBodySettings s = stiff(kStiffness, kMass);
    s.damping = 20.0;
    s.pointRadius = 0.02;
    s.stepping.maxSubsteps = budget;
    s.stepping.stepper = Stepper::Verlet;
    SoftBody* body = bullet.addSoft(chainNetwork(kLinks), s);
    ASSERT_TRUE(body->pin(0));
    bullet.simulate(5.0);
    const double measured = (body->position(kLinks) - body->position(0)).norm() - 1.0;
    // Bullet's positions are in single precision: eight links of 1e-7 m
    EXPECT_NEAR(measured, elongation / body->softening(), 1e-6 + 0.01 * measured) << budget;
    EXPECT_LT(measured, last + 1e-6) << "more substeps are never worse";
    last = measured;
  }
}

TEST(Softening, ofTheVolumeIsTheSame) {
  SoftBodySettings s = stiff(1e3, 1.0);
  s.volumeModulus = 1e9;
  Played played(closedCubeNetwork(), s);
  EXPECT_LT(played.body->softening(), 0.01);
  EXPECT_LE(played.body->substeps(), kBudget);
}

TEST(Softening, leavesAPendulumItsPeriod) {
  // a rod of two points, let go horizontally; the spring is as long at any stiffness to m g / k
  std::vector<double> lowest;
  for (const int budget : {8, 0}) {
    SoftWorld bullet(-kGravity);
    SoftBodySettings s = stiff(1e6, 1.0);
    s.pointRadius = 0.02;
    s.stepping.maxSubsteps = budget;
    SoftBody* body = bullet.addSoft(pairNetwork(), s);
    ASSERT_TRUE(body->pin(0));
    int tick = 0;
    while (tick < 120 && body->position(1).x() > 0.0) bullet.tick(), ++tick;
    lowest.push_back(tick);
  }
  EXPECT_NEAR(lowest[0], lowest[1], 1.0);
}

// --- pins, links, anchors ----------------------------------------------------------------------------------

/// Linked to a rope with a budget the cube is soft. Strains that cost it little then would throw it apart
/// once it is stiff again: it would gain 1e4 J, and in every other tick 1e11 J.
TEST(BudgetWithLinks, whatIsLinkedInTurnGainsNoEnergy) {
  for (const int period : {1, 3}) {
    SoftWorld bullet(-kGravity);
    bullet.addPlaneFloor();
    SoftBodySettings s = stiff(6e4, 1.0);
    s.damping = 1.0;
    s.stepping.maxSubsteps = 0;
    s.position.y() = 1.2;
    SoftBody* cube = bullet.addSoft(cubeNetwork(), s);
    s = stiff(1e3, 0.2);
    s.stepping.maxSubsteps = 3;
    s.position = {0.5, 1.7, 0.5};
    SoftBody* rope = bullet.addSoft(*buildRope(), s);
    ASSERT_TRUE(rope->pin(16));
    SpringSettings link;
    link.stiffness = 2000.0;
    SpringConstraint* spring = nullptr;
    double least = 1.0;
    const auto energy = [&] {
      double sum = 0.0;
      for (const SoftBody* body : {cube, rope}) sum += energyOf(*body, kGravity);
      return sum;
    };
    const double start = energy();
    for (int i = 0; i < 120; ++i) {
      if (spring && i % period == 0) {
        ASSERT_TRUE(bullet.system.removeSpring(spring));
        spring = nullptr;
      } else if (i % period == 0) {
        spring = *bullet.system.addSpring({cube->point(7)}, {rope->point(0)}, link);
      }
      bullet.tick();
      least = std::min(least, cube->softening());
      ASSERT_LT(energy(), start + 0.1) << period << ' ' << i;
    }
    EXPECT_LT(least, 0.01) << "it was linked";
    ASSERT_TRUE(!spring || bullet.system.removeSpring(spring));
    bullet.simulate(3.0);
    EXPECT_EQ(cube->softening(), 1.0) << "it becomes stiff again";
  }
}

TEST(BudgetWithLinks, aLinkedBodyHangsAtTheLengthOfItsSpring) {
  SoftWorld bullet(-kGravity);
  SoftBodySettings s = stiff(1e5, 1.0);
  s.damping = 5.0;
  s.position.y() = -1.0;
  SoftBody* body = bullet.addSoft(fullCubeNetwork(), s);
  SpringSettings link;
  link.stiffness = 1e5;
  link.damping = 20.0;
  link.restLength = 0.5;
  std::uint32_t top = 0;
  for (std::uint32_t i = 0; i < body->pointCount(); ++i)
    if (body->position(i).sum() > body->position(top).sum()) top = i;
  ASSERT_TRUE(bullet.system.addSpring({body->point(top)}, {nullptr, btVector3(0, 0, 0)}, link));
  bullet.simulate(10.0);
  EXPECT_EQ(body->substeps(), kBudget);
  // The link has half of (1.8 / dt)^2 = 2 k / m at most, as has its point of 1/8 kg with the body's springs:
  // so it stretches by at most m g / k = 9.81 / (0.25 * 2160^2 / 8) = 7e-5 m for each unit of its bound, and
  // the point's own softened springs let it sag by some millimetres.
  EXPECT_NEAR(body->position(top).norm(), 0.5, 0.01);
}

TEST(BudgetWithLinks, anAttachedBodyFollowsItsRigidBody) {
  SoftWorld bullet(-kGravity);
  btRigidBody* box = bullet.addBox({btScalar(0.2), btScalar(0.2), btScalar(0.2)}, 5.0, {0, btScalar(0.9), 0});
  SoftBody* body = bullet.addSoft(fullCubeNetwork(), stiff(1e6, 1.0));
  std::uint32_t top = 0;
  for (std::uint32_t i = 0; i < body->pointCount(); ++i)
    if (body->position(i).y() > body->position(top).y()) top = i;
  ASSERT_TRUE(bullet.system.attach(body, top, *box));
  const btVector3 pivot =
      box->getWorldTransform().inverse() * body->point(top)->getWorldTransform().getOrigin();
  bullet.simulate(1.0);
  const btVector3 at = box->getWorldTransform() * pivot;
  EXPECT_LE(body->substeps(), kBudget);
  EXPECT_LT((body->position(top) - Eigen::Vector3d(at.x(), at.y(), at.z())).norm(), 1e-3);
  // both fall freely: linear momentum is the weight times the time
  const double momentum = body->linearMomentum().y() + 5.0 * double(box->getLinearVelocity().y());
  EXPECT_NEAR(momentum, -6.0 * kGravity, 0.01 * 6.0 * kGravity);
}

}  // namespace
}  // namespace limber::test
