// SPDX-License-Identifier: Zlib
// Closed bodies in a world keep their volume; pressure inflates them.
#include "support/small_meshes.h"
#include "support/soft_world.h"
#include "support/variants.h"

#include <random>

namespace limber::test {
namespace {

TEST(Volume, isRefusedWhereThereIsNoneAndNothingIsLeftBehind) {
  SoftWorld bullet;
  SoftBodySettings s = testedSettings();
  s.pressure = 1.0;
  EXPECT_EQ(bullet.system.createBody(*buildCloth(), s).error(),
            "pressure: a rope or cloth encloses no volume");
  EXPECT_EQ(bullet.world->getNumCollisionObjects(), 0);
  s.pressure = -1.0;
  EXPECT_EQ(bullet.system.createBody(closedCubeNetwork(), s).error(),
            "settings: pressure is -1, must be from 0 to 1e12");
}

TEST(Volume, bringsAnInvertedBodyBack) {
  SoftWorld bullet(0.0);
  for (const bool withVolume : {true, false}) {
    SoftBodySettings s = testedSettings();
    if (!withVolume) s.volumeModulus = 0.0;
    s.position = {withVolume ? 0.0 : 5.0, 0, 0};
    SoftBody* body = bullet.addSoft(closedCubeNetwork(), s);
    for (std::uint32_t i = 0; i < 8; ++i) {
      const Eigen::Vector3d x = s.position - body->network().restPoints[i];
      body->point(i)->getWorldTransform().setOrigin(vec(x.x() + 1e-3 * i, x.y(), x.z()));
    }
    bullet.simulate(10.0);
    EXPECT_NEAR(volumeOf(*body), withVolume ? 1.0 : -1.0, 1e-4)
        << "with the volume term it turns back, the springs alone do not mind";
  }
}

/// Returns the hashes of falling bodies, rotated and mirrored, which share one network or have one each.
std::vector<std::uint64_t> hashes(bool shared) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  const SharedNetwork cube = closedCubeNetwork();
  for (int i = 0; i < 12; ++i) {
    SoftBodySettings s = settingsAt({2.0 * i, 1.5, 0});
    s.scale = {i % 3 == 1 ? -1.0 : 1.0, 1.0 + 0.1 * i, 1.0};
    s.pressure = 5.0 * i;
    s.ambientPressure = i % 4 == 3 ? 100.0 : 0.0;
    s.angularVelocity = {1, 2, 3};
    (void)bullet.addSoft(shared ? cube : closedCubeNetwork(), s);
  }
  bullet.simulate(2.0);
  std::vector<std::uint64_t> all;
  for (std::size_t i = 0; i < bullet.system.bodyCount(); ++i) {
    all.push_back(bullet.system.body(i)->stateHash());
    EXPECT_GT(std::abs(volumeOf(*bullet.system.body(i))), 0.8);
  }
  return all;
}

TEST(Volume, isTheSameToTheBitForBodiesSteppedTogether) { EXPECT_EQ(hashes(true), hashes(false)); }

/// Undamped bodies in free space, next to each other, with random velocities of the points up to `speed`
/// (m/s).
struct UndampedFlight {
  UndampedFlight(const SharedNetwork& network, std::size_t count, double speed, int minSubsteps) {
    SoftBodySettings s = testedSettings();
    s.damping = 0.0;
    s.stepping.minSubsteps = minSubsteps;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> component(-speed, speed);
    for (std::size_t b = 0; b < count; ++b) {
      s.position.x() = 1000.0 * static_cast<double>(b);
      SoftBody* body = *system.createBody(network, s);
      for (std::uint32_t i = 0; i < body->pointCount(); ++i) {
        body->point(i)->setLinearVelocity(vec(component(random), component(random), component(random)));
        body->point(i)->setActivationState(DISABLE_DEACTIVATION);
      }
    }
  }
  double energy(std::size_t b) const {
    return system.body(b)->kineticEnergy() + system.body(b)->elasticEnergy();
  }

  BulletWorld bullet{0.0};
  SoftBodySystem system{*bullet.world};
};

TEST(Volume, undampedFlightKeepsItsEnergy) {
  for (const SharedNetwork& network : {closedCubeNetwork(), bracedNetwork(small_meshes::icosphere(1))})
    for (const std::size_t bodies : {1u, 3u})  // alone, and side by side in SIMD lanes
      for (const double speed : variants({0.8, 8.0}, {2.0}))
        for (const int minSubsteps : {5, 60}) {
          SCOPED_TRACE(testing::Message() << network->restPoints.size() << " points, " << bodies
                                          << " bodies, " << speed << " m/s, " << minSubsteps << " substeps");
          UndampedFlight flight(network, bodies, speed, minSubsteps);
          flight.bullet.tick();
          std::vector<double> start, minEnergy, maxEnergy;
          for (std::size_t b = 0; b < bodies; ++b) start.push_back(flight.energy(b));
          minEnergy = maxEnergy = start;
          for (int i = 0; i < 600; ++i) {
            flight.bullet.tick();
            for (std::size_t b = 0; b < bodies; ++b) {
              minEnergy[b] = std::min(minEnergy[b], flight.energy(b));
              maxEnergy[b] = std::max(maxEnergy[b], flight.energy(b));
            }
          }
          // A mode's energy swings by (omega dt)^2 / 4: up to a quarter for the stiffest at the default
          // tolerance. The sum over this many modes swings by some hundredths.
          const double swing = minSubsteps == 5 ? 0.06 : 0.002;
          for (std::size_t b = 0; b < bodies; ++b) {
            EXPECT_GT(minEnergy[b], (1.0 - swing) * start[b]);
            EXPECT_LT(maxEnergy[b], (1.0 + swing) * start[b]);
          }
        }
}

TEST(Volume, undampedFlightIsReversible) {
  for (const SharedNetwork& network : {closedCubeNetwork(), bracedNetwork(small_meshes::icosphere(1))})
    for (const std::size_t bodies : {1u, 3u}) {
      UndampedFlight flight(network, bodies, 2.0, 5);
      const SoftBody& body = *flight.system.body(0);
      flight.bullet.simulate(1.0);
      std::vector<Eigen::Vector3d> start;
      for (std::uint32_t i = 0; i < body.pointCount(); ++i) start.push_back(body.position(i));
      flight.bullet.simulate(1.0);
      for (std::size_t b = 0; b < bodies; ++b)
        for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
          btRigidBody& point = *flight.system.body(b)->point(i);
          point.setLinearVelocity(-point.getLinearVelocity());
        }
      flight.bullet.simulate(1.0);
      // the reversed velocities are floats with errors of 1e-7 m/s, which the chaotic motion amplifies
      for (std::uint32_t i = 0; i < body.pointCount(); ++i)
        EXPECT_LT((body.position(i) - start[i]).norm(), 1e-5) << network->restPoints.size() << " points";
    }
}

TEST(Volume, isKeptByABallThatIsPressedFlat) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  double heights[2], volumes[2];
  for (const int gas : {0, 1}) {
    NetworkSettings network;
    network.braces = BraceRule::None;
    network.braceWeight = 1.0;
    SoftBodySettings s = settingsAt({5.0 * gas, 1.0, 0});
    setSprings(s, 10.0, 1.0);
    s.volumeModulus = 0.0;
    s.pressure = gas ? 20.0 : 0.0;
    SoftBody* ball = bullet.addSoft(*buildNetwork(small_meshes::icosphere(1), network), s);
    bullet.simulate(8.0);
    heights[gas] = ball->centerOfMass().y(), volumes[gas] = volumeOf(*ball);
  }
  EXPECT_LT(volumes[0], 2.0) << "without gas it slumps";
  EXPECT_GT(volumes[1], 3.5);
  EXPECT_GT(heights[1], heights[0] + 0.2);
}

/// A ball of 1 kg filled with air, on the floor: its volume is  V0 (1 + p / a),  less what springs and weight
/// take, which is less than a thousandth at sea level.
TEST(Volume, ofABallFilledWithAirFollowsBoylesLaw) {
  for (const int maxSubsteps : {0, 12}) {
    SoftWorld bullet;
    bullet.addBoxFloor();
    NetworkSettings network;
    network.braces = BraceRule::None;
    network.braceWeight = 1.0;
    SoftBodySettings s = settingsAt({0, 1.2, 0});
    setSprings(s, 50.0, 1.0);
    s.volumeModulus = 0.0;
    s.pressure = 5000.0;
    s.ambientPressure = 101325.0;
    s.stepping.maxSubsteps = maxSubsteps;
    SoftBody* ball = bullet.addSoft(*buildNetwork(small_meshes::icosphere(2), network), s);
    const double rest = volumeOf(*ball);
    bullet.simulate(4.0);
    EXPECT_NEAR(volumeOf(*ball) / rest, 1.0 + 5000.0 / 101325.0, 1e-3) << ball->softening();
    EXPECT_NEAR(ball->volume() / volumeOf(*ball), 1.0, 1e-12);
    EXPECT_EQ(ball->restorations(), 0u);
    EXPECT_EQ(ball->softening() < 0.5, maxSubsteps > 0);
  }
}

/// Returns the width of the body relative to its rest width, from all points near half its height.
double width(const SoftBody& body) {
  double sum = 0.0, squares = 0.0;
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    const Eigen::Vector3d& rest = body.network().restPoints[i];
    if (std::abs(rest.y()) > 0.3) continue;
    sum += rest.x() * body.position(i).x() + rest.z() * body.position(i).z();
    squares += rest.x() * rest.x() + rest.z() * rest.z();
  }
  return sum / squares;
}

/// Presses a block of 1 x 1 x 1 m to 0.98 of its height; its ends can slide. Returns its relative increase in
/// width divided by 0.02, which is its Poisson ratio.
double swellingOf(SoftBody& body, BulletWorld& bullet) {
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    const Eigen::Vector3d& rest = body.network().restPoints[i];
    if (std::abs(rest.y()) < 0.499) continue;
    btRigidBody& point = *body.point(i);
    const btVector3 position = point.getWorldTransform().getOrigin();
    point.getWorldTransform().setOrigin(btVector3(position.x(), position.y() * btScalar(0.98), position.z()));
    point.setLinearFactor(btVector3(1, 0, 1));
  }
  bullet.simulate(4.0);
  return (width(body) - 1.0) / 0.02;
}

TEST(Volume, givesABodyOfAMaterialItsPoissonRatio) {
  const SharedNetwork block = solidNetwork(small_meshes::cube(), 150);
  double swelling[3];
  const double ratios[] = {0.25, 0.35, 0.45};
  for (int i = 0; i < 3; ++i) {
    SoftWorld bullet(0.0);
    SoftBodySettings s = *withMaterial(*block, {1e5, ratios[i], 1000.0}, testedSettings());
    s.damping = 30.0;
    swelling[i] = swellingOf(*bullet.addSoft(block, s), bullet);
    // the requested ratio is a mean over all directions of a lattice that is not quite isotropic
    EXPECT_NEAR(swelling[i], ratios[i], 0.06);
  }
  EXPECT_NEAR(swelling[1] - swelling[0], 0.1, 0.03);
  EXPECT_NEAR(swelling[2] - swelling[0], 0.2, 0.03);
}

TEST(Volume, ofTetrahedraCountsAsElasticEnergy) {
  const SharedNetwork block = solidNetwork(small_meshes::cube(), 40);
  SoftWorld bullet(0.0);
  double energies[2];
  for (const int i : {0, 1}) {
    SoftBodySettings s = settingsAt({3.0 * i, 0, 0});
    s.volumeModulus = i * 1e6;
    SoftBody* body = bullet.addSoft(block, s);
    for (std::uint32_t p = 0; p < body->pointCount(); ++p) {
      const Eigen::Vector3d x = s.position + 0.9 * block->restPoints[p];
      body->point(p)->getWorldTransform().setOrigin(vec(x.x(), x.y(), x.z()));
    }
    energies[i] = body->elasticEnergy();
  }
  // K/2 (V - V0)^2 / V0 of 1 m^3 shrunk to 0.9^3
  EXPECT_NEAR(energies[1] - energies[0], 0.5e6 * 0.271 * 0.271, 200.0);
}

TEST(Volume, ofTetrahedraIsTheSameToTheBitForBodiesSteppedTogether) {
  MaterialMesh mesh;
  mesh.points = 40;
  const SharedNetwork shared = *buildMaterialNetwork(small_meshes::cube(), mesh);
  const auto hash = [&](bool together) {
    SoftWorld bullet;
    bullet.addBoxFloor();
    std::vector<std::uint64_t> all;
    for (int i = 0; i < 5; ++i) {
      SoftBodySettings s = testedSettings();
      s.scale.x() = i == 3 ? -1.0 : 1.0;
      s.position = {3.0 * i, 1.0, 0.0};
      s.angularVelocity = {1, 2, 3};
      s = *withMaterial(*shared, {1e4, 0.3, 200.0}, s);
      const auto body =
          bullet.system.createBody(together ? shared : std::make_shared<SpringNetwork>(*shared), s);
      EXPECT_TRUE(body) << body.error();
    }
    bullet.simulate(1.0);
    for (std::size_t i = 0; i < bullet.system.bodyCount(); ++i)
      all.push_back(bullet.system.body(i)->stateHash());
    return all;
  };
  EXPECT_EQ(hash(true), hash(false));
}

/// Returns the positions of a ball of a material that spins, half a second after it was hit.
std::vector<double> hitBall(const SharedNetwork& ball, const Material& material, int minSubsteps) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = *withMaterial(*ball, material, testedSettings());
  s.angularVelocity = {0, 3, 0};
  s.stepping.minSubsteps = minSubsteps;
  SoftBody* body = bullet.addSoft(ball, s);
  body->applyImpulse(btVector3(0, btScalar(0.005 * s.totalMass), 0), 0);
  bullet.simulate(0.5);
  std::vector<double> xyz;
  for (std::uint32_t i = 0; i < body->pointCount(); ++i)
    for (const double x : body->position(i)) xyz.push_back(x);
  return xyz;
}

/// The usual substeps allow the fastest oscillation a period error of 4 %. What one sees is slower, and its
/// error falls with the square of the frequency. Where the limit of the volume force softens tetrahedra in
/// these substeps, the error of rubber is above 1e-4 m.
TEST(Volume, ofTetrahedraIsResolvedByTheUsualSubsteps) {
  const SharedNetwork ball = solidNetwork(small_meshes::icosphere(3), 150);
  for (const Material& material : {Material::jelly(), Material::rubber(), Material::stiff()}) {
    SCOPED_TRACE(material.youngsModulus);
    const std::vector<double> usual = hitBall(ball, material, 5), exact = hitBall(ball, material, 400);
    double largest = 0.0;
    for (std::size_t i = 0; i < usual.size(); ++i) largest = std::max(largest, std::abs(usual[i] - exact[i]));
    EXPECT_LT(largest, 1e-4);
  }
}

}  // namespace
}  // namespace limber::test
