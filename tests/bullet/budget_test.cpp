// SPDX-License-Identifier: Zlib
// Bodies whose budget (maxSubsteps) is far below what Verlet needs: the number of substeps, momenta, the true
// strain at rest, and contacts, pins, anchors, links and rigid partners.
#include "support/bullet_world.h"
#include "support/constants.h"
#include "support/networks.h"
#include "support/tested_way.h"

#include <limber/network_builder.h>
#include <limber/soft_body_system.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace limber {
namespace {

using test::BulletWorld;
using test::kGravity;

constexpr int kBudget = 20;

SoftBodySettings stiff(double stiffness, double mass) {
  SoftBodySettings s = test::testedSettings();
  s.extensionStiffness = s.compressionStiffness = stiffness;
  s.damping = 0.0;
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

SharedNetwork cloth(std::uint32_t cells) {
  ClothSettings settings;
  settings.columns = settings.rows = cells;
  return *buildCloth(settings);
}

TEST(BudgetInContact, holdsAtAnyStiffness) {
  for (const double stiffness : {1e3, 1e5, 1e7}) {
    BulletWorld bullet(-kGravity);
    bullet.addPlaneFloor();
    bullet.addBox({btScalar(0.2), btScalar(0.2), btScalar(0.2)}, 2.0, {0, 2, 0});
    SoftBodySystem system(*bullet.world);
    SoftBodySettings s = stiff(stiffness, 1.0);
    s.position.y() = 0.6;
    SoftBody* body = *system.createBody(test::fullCubeNetwork(), s);
    for (int tick = 0; tick < 120; ++tick) {
      bullet.tick();
      ASSERT_LE(body->substeps(), kBudget) << stiffness;
    }
    EXPECT_LT(strainOf(*body), 0.05) << stiffness;
  }
}

TEST(BudgetInContact, aBoxRestsOnAStiffCube) {
  BulletWorld bullet(-kGravity);
  bullet.addPlaneFloor();
  btRigidBody* box = bullet.addBox({btScalar(0.3), btScalar(0.3), btScalar(0.3)}, 5.0, {0, btScalar(1.5), 0});
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = stiff(1e6, 1.0);
  s.collision = Collision::Surface;
  s.position.y() = 0.53;
  SoftBody* body = *system.createBody(test::closedCubeNetwork(), s);
  bullet.simulate(5.0);
  const double radius = pointRadius(body->network(), body->settings());
  // the cube's half edge, twice its radius, the box and Bullet's margin of 0.04
  EXPECT_NEAR(double(box->getWorldTransform().getOrigin().y()), 1.0 + 2.0 * radius + 0.3, 0.02);
  EXPECT_LT(double(box->getLinearVelocity().length()), 0.01);
  EXPECT_LE(body->substeps(), kBudget);
}

TEST(BudgetInContact, aStackOfTenStands) {
  if (test::testedSettings().collision == Collision::Points) GTEST_SKIP() << "corners alone do not stack";
  BulletWorld bullet(-kGravity);
  bullet.addPlaneFloor();
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = stiff(1e6, 1.0);
  s.damping = 20.0;
  std::vector<SoftBody*> cubes;
  for (int i = 0; i < 10; ++i) {
    s.position.y() = 0.55 + 1.05 * i;
    cubes.push_back(*system.createBody(test::closedCubeNetwork(), s));
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
  BulletWorld bullet(-kGravity);
  bullet.add(std::make_unique<btSphereShape>(btScalar(0.3)), 0.0, {0, 0, 0});
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = stiff(stiffness, 0.2);
  s.damping = 0.01;
  s.position.y() = 0.4;
  s.pointRadius = 0.005;
  s.stepping.maxSubsteps = maxSubsteps;
  SoftBody* body = *system.createBody(cloth(14), s);
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

TEST(BudgetInContact, aStiffClothDrapesLikeVerlets) {
  const Drape budget = drape(5e4, kBudget, 3.0), exact = drape(5e4, 0, 3.0);
  EXPECT_LE(budget.substeps, kBudget);
  EXPECT_GT(exact.substeps, 5 * kBudget) << "Verlet needs many more";
  EXPECT_LT(budget.largest, 0.005);
  EXPECT_LT(budget.strain, 0.001);
  // 2 % of the size: folds differ, since the fall onto the ball is chaotic
  EXPECT_NEAR(budget.height, exact.height, 0.02);
}

TEST(Budget, aPinnedClothHasItsTrueStrainAtRest) {
  std::vector<double> strains, heights;
  for (const int budget : {kBudget, 0}) {
    BulletWorld bullet(-kGravity);
    SoftBodySystem system(*bullet.world);
    SoftBodySettings s = stiff(1e4, 1.0);
    s.damping = 2.0;
    s.rotation = Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitX());
    s.sleepingSpeed = 0.0;
    s.stepping.maxSubsteps = budget;
    SoftBody* body = *system.createBody(cloth(8), s);
    for (std::uint32_t i = 0; i < 9; ++i) ASSERT_TRUE(body->pin(i));
    bullet.simulate(12.0);
    strains.push_back(strainOf(*body));
    heights.push_back(body->centerOfMass().y());
  }
  // the softest waves of Verlet's cloth have not come to rest after 12 s
  EXPECT_NEAR(strains[0], strains[1], 0.03 * strains[1]);
  EXPECT_NEAR(heights[0], heights[1], 1e-4);
}

TEST(Budget, aLinkedBodyHangsAtTheLengthOfItsSpring) {
  BulletWorld bullet(-kGravity);
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = stiff(1e5, 1.0);
  s.damping = 5.0;
  s.position.y() = -1.0;
  SoftBody* body = *system.createBody(test::fullCubeNetwork(), s);
  SpringSettings link;
  link.stiffness = 1e5;
  link.damping = 20.0;
  link.restLength = 0.5;
  std::uint32_t top = 0;
  for (std::uint32_t i = 0; i < body->pointCount(); ++i)
    if (body->position(i).sum() > body->position(top).sum()) top = i;
  ASSERT_TRUE(system.addSpring({body->point(top)}, {nullptr, btVector3(0, 0, 0)}, link));
  bullet.simulate(10.0);
  EXPECT_EQ(body->substeps(), kBudget);
  // the link stretches by m g / k
  EXPECT_NEAR(body->position(top).norm(), 0.5 + kGravity / 1e5, 2e-3);
}

TEST(Budget, anAttachedBodyFollowsItsRigidBody) {
  BulletWorld bullet(-kGravity);
  SoftBodySystem system(*bullet.world);
  btRigidBody* box = bullet.addBox({btScalar(0.2), btScalar(0.2), btScalar(0.2)}, 5.0, {0, btScalar(0.9), 0});
  SoftBody* body = *system.createBody(test::fullCubeNetwork(), stiff(1e6, 1.0));
  std::uint32_t top = 0;
  for (std::uint32_t i = 0; i < body->pointCount(); ++i)
    if (body->position(i).y() > body->position(top).y()) top = i;
  ASSERT_TRUE(system.attach(body, top, *box));
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
}  // namespace limber
