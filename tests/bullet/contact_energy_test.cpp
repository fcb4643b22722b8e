// SPDX-License-Identifier: Zlib
// Contacts with what is held make no energy, and know no units.
#include "support/bullet_world.h"
#include "support/constants.h"
#include "support/networks.h"
#include "support/small_meshes.h"
#include "support/tested_way.h"

#include <limber/network_builder.h>
#include <limber/soft_body_system.h>
#include <limber/soft_contact.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace limber {
namespace {

using Eigen::Vector3d;
using test::BulletWorld;
using test::kGravity;
using test::kPi;
using test::kTick;
using test::vec;

/// J: motion, springs and height.
double energyWithHeight(const SoftBody& body, double gravity = kGravity) {
  return body.kineticEnergy() + body.elasticEnergy() + gravity * body.totalMass() * body.centerOfMass().y();
}

// --- tumbling drops ----------------------------------------------------------------------------------------

/// Held by its volume alone, so that it folds.
SharedNetwork networkOf(const TriangleMesh& mesh) {
  NetworkSettings settings;
  settings.braces = BraceRule::None;
  return *buildNetwork(mesh, settings);
}

/// 0.48 m in radius, rings of 8 points around 16.
TriangleMesh ringMesh() {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 16; ++i)
    for (std::uint32_t j = 0; j < 8; ++j) {
      const double u = kPi / 8 * i, v = kPi / 4 * j, r = 0.35 + 0.13 * std::cos(v);
      mesh.positions.emplace_back(r * std::cos(u), 0.13 * std::sin(v), r * std::sin(u));
      const auto at = [&](std::uint32_t a, std::uint32_t b) { return (i + a) % 16 * 8 + (j + b) % 8; };
      mesh.triangles.push_back({at(0, 0), at(0, 1), at(1, 0)});
      mesh.triangles.push_back({at(1, 0), at(0, 1), at(1, 1)});
    }
  return mesh;
}

/// A ball of 42 points, every third farther out.
TriangleMesh spikyMesh() {
  TriangleMesh mesh = small_meshes::icosphere(1);
  for (Vector3d& p : mesh.positions) {
    const double wave = std::sin(7.0 * p.x() + 3.0 * p.y()) * std::cos(5.0 * p.z());
    p *= wave > 0.3 ? 0.6 : 0.4;
  }
  return mesh;
}

void addTwoTriangles(BulletWorld& bullet) {
  auto mesh = std::make_unique<btTriangleMesh>();
  mesh->addTriangle(vec(-50, 0, -50), vec(-50, 0, 50), vec(50, 0, -50));
  mesh->addTriangle(vec(50, 0, -50), vec(-50, 0, 50), vec(50, 0, 50));
  auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
  bullet.meshes.push_back(std::move(mesh));
  bullet.add(std::move(shape), 0, vec(0, 0, 0));
}

using FloorMaker = void (*)(BulletWorld&);

/// The largest rise of energy over that of the start, as a share of it; stops when it is decided. Velocity,
/// spin, attitude, stiffness and friction are drawn from the seed.
double riseInDrop(const SharedNetwork& network, FloorMaker addFloor, unsigned seed, double allowed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  const auto vector = [&] { return Vector3d(draw(random), draw(random), draw(random)); };
  BulletWorld bullet(-kGravity);
  addFloor(bullet);
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = test::testedSettings();
  s.extensionStiffness = s.compressionStiffness = seed % 2 ? 1e4 : 1e3;
  s.friction = seed / 2 % 2 ? 1.0 : 0.0;
  s.position = {0, 0.9, 0};
  s.rotation = Eigen::AngleAxisd(3.0 * draw(random), vector().normalized());
  s.linearVelocity = {2.0 * draw(random), 0.0, 2.0 * draw(random)};
  s.angularVelocity = 5.0 * vector();
  const SoftBody* body = *system.createBody(network, s);
  const double start = energyWithHeight(*body);
  double rise = 0.0;
  for (int tick = 0; tick < 90 && rise <= allowed; ++tick) {
    bullet.tick(kTick);
    rise = std::max(rise, energyWithHeight(*body) / start - 1.0);
  }
  return rise;
}

/// The motion of a damped body on what stands still only loses energy; a hundredth is what substeps that
/// resolve the stiffest oscillation by a few steps may be wrong by.
void expectDropsWithoutRise(FloorMaker addFloor) {
  const SharedNetwork ring = networkOf(ringMesh()), spiky = networkOf(spikyMesh());
  for (unsigned seed = 0; seed < 10; ++seed)
    EXPECT_LE(riseInDrop(ring, addFloor, seed, 0.01), 0.01) << "ring, seed " << seed;
  for (unsigned seed = 17; seed < 24; ++seed)
    EXPECT_LE(riseInDrop(spiky, addFloor, seed, 0.01), 0.01) << "spiky, seed " << seed;
}

TEST(TumblingDrops, makeNoEnergyOnAPlane) {
  expectDropsWithoutRise([](BulletWorld& b) { b.addPlaneFloor(); });
}
TEST(TumblingDrops, makeNoEnergyOnABox) {
  expectDropsWithoutRise([](BulletWorld& b) { b.addBoxFloor(); });
}
TEST(TumblingDrops, makeNoEnergyOnAHull) {
  expectDropsWithoutRise([](BulletWorld& b) { b.addHullFloor(); });
}
TEST(TumblingDrops, makeNoEnergyOnTwoTriangles) { expectDropsWithoutRise(addTwoTriangles); }

/// A point that a spring throws within the tick, faster than anything moved at its start, meets the floor.
TEST(TumblingDrops, pointsThrownBySpringsStayOutside) {
  for (const FloorMaker addFloor :
       {FloorMaker([](BulletWorld& b) { b.addBox(vec(5, 0.02, 5), 0, vec(0, -0.02, 0)); }),
        FloorMaker(addTwoTriangles)})
    for (const double height : {0.1, 0.4, 0.8}) {
      BulletWorld bullet(0.0);
      addFloor(bullet);
      SoftBodySystem system(*bullet.world);
      SoftBodySettings s = test::testedSettings();
      s.extensionStiffness = s.compressionStiffness = 1e4;
      s.position = {0.1, height, 0.2};
      s.rotation = Eigen::AngleAxisd(kPi / 2, Vector3d::UnitZ());
      s.damping = 0.0;
      SoftBody* body = *system.createBody(test::pairNetwork(), s);
      // 1 m long at rest; 0.03 m long now, and nothing moves
      for (std::uint32_t i = 0; i < 2; ++i) {
        btTransform pose = body->point(i)->getWorldTransform();
        pose.getOrigin().setY(btScalar(height + 0.03 * i));
        body->point(i)->setWorldTransform(pose);
      }
      const double start = energyWithHeight(*body, 0.0);
      for (int tick = 0; tick < 5; ++tick) {
        bullet.tick(kTick);
        for (std::uint32_t i = 0; i < 2; ++i) EXPECT_GT(body->position(i).y(), 0.0) << height << ", " << tick;
        EXPECT_LE(energyWithHeight(*body, 0.0), 1.01 * start) << height << ", " << tick;
      }
    }
}

// --- restitution -------------------------------------------------------------------------------------------

struct Rebound {
  double least = 0.0, most = 0.0;  ///< of the energy of the start
  double top = 0.0;                ///< m, of the centre of mass after the first touch
};

struct Fall {
  SharedNetwork network;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  double stiffness = 2e3, restitution = 1.0;
  int substeps = 5;
};

/// From 1 m between the centre of mass and where it is when a flat body lies on the plane.
Rebound fall(const Fall& f) {
  BulletWorld bullet(-kGravity);
  bullet.addPlaneFloor()->setRestitution(1);
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = test::testedSettings();
  s.extensionStiffness = s.compressionStiffness = f.stiffness;
  s.damping = 0.0;
  s.friction = 0.0;
  s.volumeModulus = 0.0;
  s.restitution = f.restitution;
  s.stepping.minSubsteps = f.substeps;
  s.position = {0, 1.5, 0};
  s.rotation = f.rotation;
  s.sleepingSpeed = 0.0;
  const SoftBody* body = *system.createBody(f.network, s);
  const double start = energyWithHeight(*body);
  Rebound rebound{1.0, 1.0, 0.0};
  bool touched = false;
  for (int tick = 0; tick < 120; ++tick) {
    bullet.tick(kTick);
    rebound.least = std::min(rebound.least, energyWithHeight(*body) / start);
    rebound.most = std::max(rebound.most, energyWithHeight(*body) / start);
    touched = touched || !body->contacts().empty();
    if (touched) rebound.top = std::max(rebound.top, body->centerOfMass().y());
  }
  return rebound;
}

Eigen::Quaterniond turned(double angle, const Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

SharedNetwork bracedBall() {
  TriangleMesh mesh = small_meshes::icosphere(1);
  for (Vector3d& p : mesh.positions) p *= 0.5;
  NetworkSettings settings;
  settings.braces = BraceRule::TwoRing;
  return *buildNetwork(mesh, settings);
}

/// Bodies that nothing damps, e = 1: the points of a vertical pair and of a cube, flat and on a corner, and
/// of a ball, bounce against each other for two seconds. Substeps resolve the stiffest oscillation by more
/// than a hundred steps: the rest is their error, which falls with their square.
TEST(Restitution, ofOneKeepsTheEnergyOfAnUndampedBody) {
  const Eigen::Quaterniond upright = turned(kPi / 2, Vector3d::UnitZ());
  for (const Fall& f : {Fall{test::pairNetwork(), upright}, Fall{test::fullCubeNetwork()},
                        Fall{test::fullCubeNetwork(), turned(0.7, {1, 2, 0.5})}, Fall{bracedBall()}}) {
    Fall fine = f;
    fine.substeps = 150;
    const Rebound rebound = fall(fine);
    const std::size_t points = f.network->restPoints.size();
    EXPECT_LE(rebound.most, 1.001) << points << " points";
    EXPECT_GE(rebound.least, 0.995) << points << " points";
  }
}

/// In the usual substeps (omega dt = 1) the energy of the stiffest oscillations swings by an eighth of what
/// is in them. What bounces gains none on top of that, and rises no higher than a rigid body would.
TEST(Restitution, neverGivesEnergy) {
  for (const double stiffness : {2e3, 1e4})
    for (const double restitution : {1.0, 0.8, 0.5})
      for (const Fall& f : {Fall{test::fullCubeNetwork()},
                            Fall{test::fullCubeNetwork(), turned(0.7, {1, 2, 0.5})}, Fall{bracedBall()}}) {
        Fall usual = f;
        usual.stiffness = stiffness;
        usual.restitution = restitution;
        const Rebound rebound = fall(usual);
        EXPECT_LE(rebound.most, 1.1) << f.network->restPoints.size() << ", " << stiffness << ", "
                                     << restitution;
        EXPECT_LE(rebound.top, 1.51) << f.network->restPoints.size() << ", " << stiffness << ", "
                                     << restitution;
      }
}

// --- impulses ----------------------------------------------------------------------------------------------

/// Whichever stepper: an undamped cloth that is shot into the wedge between two planes is pushed by
/// them, never pulled.
TEST(HeldContacts, neverPull) {
  for (const Stepper stepper : {Stepper::Verlet, Stepper::ImplicitMidpoint, Stepper::BandedNewton}) {
    BulletWorld bullet(-kGravity);
    bullet.addPlaneFloor();
    bullet.add(std::make_unique<btStaticPlaneShape>(vec(-0.6, -0.8, 0), btScalar(-0.9)), 0, vec(0, 0, 0));
    SoftBodySystem system(*bullet.world);
    SoftBodySettings s = test::testedSettings();
    s.stepping.stepper = stepper;
    s.damping = 0.0;
    s.totalMass = 0.3;
    s.position = {-0.5, 0.7, 0};
    s.linearVelocity = {8, 0, 0};
    s.rotation = turned(0.7, {1, 2, 0.5});
    ClothSettings cloth;
    cloth.columns = cloth.rows = 3;
    const SoftBody* body = *system.createBody(*buildCloth(cloth), s);
    int pushes = 0;
    for (int tick = 0; tick < 80; ++tick) {
      bullet.tick(kTick);
      for (const SoftContact& c : body->contacts()) {
        // N s: rounding of what a kilogram falls with
        EXPECT_GE(c.normalImpulse, -1e-9) << int(stepper) << ", tick " << tick;
        pushes += c.normalImpulse > 0.0;
      }
    }
    EXPECT_GT(pushes, 10) << int(stepper);
    EXPECT_EQ(body->stepper(), stepper);
  }
}

// --- budgets -----------------------------------------------------------------------------------------------

/// A cloth that touches itself and a hull is stepped by Verlet, as coarsely as the budget asks for and
/// stability allows. A corner that is put somewhere else stretches it by several times its length, which such
/// substeps resolve no more: the energy there is with that is the most there may be.
TEST(TightBudget, ofAClothThatTouchesItselfMakesNoEnergy) {
  if (!test::kSurface) GTEST_SKIP() << "only surfaces touch themselves";
  for (unsigned seed = 0; seed < 16; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> draw(-1.0, 1.0);
    BulletWorld bullet(-kGravity);
    bullet.addPlaneFloor();
    auto hull = std::make_unique<btConvexHullShape>();
    for (int i = 0; i < 8; ++i)
      hull->addPoint(vec(i & 1 ? 0.3 : -0.3, i & 2 ? 0.3 : -0.3, i & 4 ? 0.3 : -0.3));
    bullet.add(std::move(hull), 0, vec(0.1 * draw(random), 0.3, 0));
    SoftBodySystem system(*bullet.world);
    SoftBodySettings s = test::testedSettings();
    s.position = {0, 1.0, 0};
    s.damping = s.friction = 0.0;
    s.totalMass = 0.3;
    s.selfCollision = true;
    s.stepping.maxSubsteps = 4;
    ClothSettings cloth;
    cloth.columns = cloth.rows = 3;
    SoftBody* body = *system.createBody(*buildCloth(cloth), s);
    bullet.simulate(0.45);
    btRigidBody& corner = *body->point(seed % 16);
    btTransform pose = corner.getWorldTransform();
    const double x = draw(random), y = std::abs(draw(random)), z = draw(random);
    pose.setOrigin(pose.getOrigin() + vec(x, y, z));
    corner.setWorldTransform(pose);
    const double start = energyWithHeight(*body);
    for (int tick = 0; tick < 40; ++tick) {
      bullet.tick(kTick);
      ASSERT_LE(energyWithHeight(*body), 1.01 * start) << "seed " << seed << ", tick " << tick;
    }
  }
}

// --- units -------------------------------------------------------------------------------------------------

/// The scene in other units: lengths are L times as large and gravity is the same, so times are sqrt(L)
/// times, masses L^3 times and stiffnesses L^2 times as large.
struct Units {
  double length;
  double time() const { return std::sqrt(length); }
  double mass() const { return length * length * length; }
};

/// Heights of all points, in lengths of the scene, in every tick of a second: a cube of 1 m above (or below)
/// a floor, and a second one that falls on it.
std::vector<double> heightsIn(const Units& u, double height, double restitution, double gravity) {
  BulletWorld bullet(-gravity);
  bullet.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)), 0, vec(0, 0, 0))
      ->setRestitution(1);
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = test::testedSettings();
  s.totalMass = u.mass();
  s.extensionStiffness = s.compressionStiffness = 2e3 * u.mass() / (u.time() * u.time());
  s.damping = 5.0 * u.mass() / u.time();
  s.restitution = restitution;
  s.scale.setConstant(u.length);
  s.position = {0, height * u.length, 0};
  s.sleepingSpeed = 0.0;
  std::vector<SoftBody*> bodies = {*system.createBody(test::closedCubeNetwork(), s)};
  s.position = {0.1 * u.length, (height + 1.3) * u.length, 0.05 * u.length};
  bodies.push_back(*system.createBody(test::closedCubeNetwork(), s));
  std::vector<double> heights;
  for (int tick = 0; tick < 60; ++tick) {
    bullet.tick(kTick * u.time());
    for (const SoftBody* body : bodies)
      for (std::uint32_t i = 0; i < body->pointCount(); ++i)
        heights.push_back(body->position(i).y() / u.length);
  }
  return heights;
}

/// m: rounding decides whether a tick of a fast hit has one search or substep more, which makes 2e-3 m of
/// difference until the bodies have bounced. An absolute constant in a bounce makes more than a hundredth.
constexpr double kUnitsTolerance = 4e-3;

void expectSameInOtherUnits(double height, double restitution, double gravity) {
  const std::vector<double> here = heightsIn({1.0}, height, restitution, gravity);
  for (const double length : {0.01, 100.0}) {
    const std::vector<double> there = heightsIn({length}, height, restitution, gravity);
    double largest = 0.0;
    for (std::size_t i = 0; i < here.size(); ++i) largest = std::max(largest, std::abs(here[i] - there[i]));
    EXPECT_LE(largest, kUnitsTolerance) << "lengths x " << length;
  }
}

TEST(Units, doNotChangeHowBodiesBounce) { expectSameInOtherUnits(0.9, 0.5, kGravity); }
TEST(Units, doNotChangeHowBodiesAreLiftedOutOfAFloor) { expectSameInOtherUnits(0.5, 0.0, kGravity); }
TEST(Units, doNotChangeHowBodiesAreLiftedOutOfAFloorWithoutGravity) { expectSameInOtherUnits(0.5, 0.0, 0.0); }

}  // namespace
}  // namespace limber
