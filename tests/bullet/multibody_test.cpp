// SPDX-License-Identifier: Zlib
// Contacts of soft bodies with links of multibodies, which react through their joints, and with ghosts.
#include "support/soft_world.h"
#include "support/variants.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <cmath>

namespace limber::test {
namespace {

using Eigen::Vector3d;

/// A world with the multibodies that a test adds.
struct MultiBodyWorld : BulletWorld {
  explicit MultiBodyWorld(double gravity) : BulletWorld(gravity) {
    auto made = std::make_unique<btMultiBodyDynamicsWorld>(&dispatcher, &broadphase, &links, &configuration);
    multiWorld = made.get();
    world = std::move(made);
    world->setGravity(vec(0, gravity, 0));
  }
  ~MultiBodyWorld() {
    for (auto& body : multiBodies) multiWorld->removeMultiBody(body.get());
    for (auto& collider : colliders) world->removeCollisionObject(collider.get());
  }

  btMultiBody* addMultiBody(int linkCount, double baseMass, const btVector3& halfBase,
                            const btVector3& position, bool fixed) {
    const btBoxShape box(halfBase);
    btVector3 inertia(0, 0, 0);
    if (baseMass > 0) box.calculateLocalInertia(static_cast<btScalar>(baseMass), inertia);
    multiBodies.push_back(
        std::make_unique<btMultiBody>(linkCount, static_cast<btScalar>(baseMass), inertia, fixed, false));
    btMultiBody* body = multiBodies.back().get();
    body->setBasePos(position);
    body->setLinearDamping(0);
    body->setAngularDamping(0);
    return body;
  }

  /// Adds a box about the centre of a link, or of the base (-1).
  btMultiBodyLinkCollider* addCollider(btMultiBody* body, int link, const btVector3& half) {
    shapes.push_back(std::make_unique<btBoxShape>(half));
    colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(body, link));
    btMultiBodyLinkCollider* collider = colliders.back().get();
    collider->setCollisionShape(shapes.back().get());
    collider->setFriction(0);
    if (link < 0)
      body->setBaseCollider(collider);
    else
      body->getLink(link).m_collider = collider;
    return collider;
  }

  /// Adds the body to the world. Call it after its links and colliders have been added.
  void enter(btMultiBody* body) {
    body->finalizeMultiDof();
    multiWorld->addMultiBody(body);
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> positions;
    body->forwardKinematics(rotations, positions);
    body->updateCollisionObjectWorldTransforms(rotations, positions);
    for (auto& collider : colliders)
      if (collider->m_multiBody == body && !collider->getBroadphaseHandle())
        world->addCollisionObject(collider.get());
  }

  btMultiBodyConstraintSolver links;
  btMultiBodyDynamicsWorld* multiWorld = nullptr;
  std::vector<std::unique_ptr<btMultiBody>> multiBodies;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
};

SoftBodySettings cubeBesideLinksAt(const Vector3d& position, double friction = 0.0) {
  SoftBodySettings s = settingsAt(position);
  s.totalMass = 1.0;
  setSprings(s, 1e4, 5.0);
  s.friction = friction;
  s.pointRadius = kRadius;
  return s;
}

btVector3 inertiaOf(const btVector3& half, double mass) {
  btVector3 inertia;
  btBoxShape(half).calculateLocalInertia(static_cast<btScalar>(mass), inertia);
  return inertia;
}

struct Momenta {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
};

/// Returns the sums over all links and the base, about the origin. Adds their energy (J) to `energy`.
Momenta momentaOf(const btMultiBody& m, double& energy) {
  Momenta sum;
  const int count = m.getNumLinks() + 1;
  std::vector<btVector3> spins(static_cast<std::size_t>(count)), velocities(spins.size());
  m.compTreeLinkVelocities(spins.data(), velocities.data());
  for (int i = 0; i < count; ++i) {
    const int link = i - 1;
    if (link < 0 && m.hasFixedBase()) continue;
    const btMatrix3x3 basis = link < 0 ? btMatrix3x3(m.getWorldToBaseRot().inverse())
                                       : m.localFrameToWorld(link, btMatrix3x3::getIdentity());
    const btVector3 position = link < 0 ? m.getBasePos() : m.localPosToWorld(link, btVector3(0, 0, 0));
    const btScalar mass = link < 0 ? m.getBaseMass() : m.getLinkMass(link);
    const btVector3 inertia = link < 0 ? m.getBaseInertia() : m.getLinkInertia(link);
    const auto index = static_cast<std::size_t>(i);
    const btVector3 p = mass * (basis * velocities[index]), spin = basis * (inertia * spins[index]);
    sum.linear += eigen(p);
    sum.angular += eigen(position.cross(p) + spin);
    energy += 0.5 * double(mass * velocities[index].length2() + spins[index].dot(inertia * spins[index]));
  }
  return sum;
}

TEST(MultiBody, aSlowLinkWakesASleepingBody) {
  MultiBodyWorld bullet(-9.81);
  bullet.addBoxFloor();
  SoftBodySystem system(*bullet.world);
  SoftBody* cube = *system.createBody(closedCubeNetwork(), settingsAt({0, 0.52, 0}));
  for (int i = 0; i < 600 && !cube->sleeping(); ++i) bullet.tick();
  ASSERT_TRUE(cube->sleeping());
  const btVector3 half = vec(0.6, 0.2, 0.6);
  btMultiBody* body = bullet.addMultiBody(0, 1.0, half, vec(0, 1.25, 0), false);
  bullet.addCollider(body, -1, half);
  bullet.enter(body);
  for (int i = 0; i < 60; ++i) bullet.tick();
  EXPECT_FALSE(cube->sleeping());
  EXPECT_LT(cube->position(2).y(), 1.0);
  EXPECT_GT(double(body->getBasePos().y()), 1.0);
}

TEST(MultiBodies, aFixedBaseCarriesACube) {
  MultiBodyWorld w(-9.81);
  btMultiBody* table = w.addMultiBody(0, 0, vec(1, 0.2, 1), vec(0, 0.3, 0), true);
  w.addCollider(table, -1, vec(1, 0.2, 1));
  w.enter(table);
  SoftBodySystem system(*w.world);
  SoftBody* cube = *system.createBody(closedCubeNetwork(), cubeBesideLinksAt({0.2, 1.1, 0}));
  w.simulate(1.5);
  // its sag under its weight is below 1 mm at 1e4 N/m
  EXPECT_NEAR(lowest(*cube), 0.5 + kRadius, 1e-4);
  EXPECT_NEAR(cube->centerOfMass().y(), 1.0 + kRadius, 2e-3);
  ASSERT_FALSE(cube->contacts().empty());
  EXPECT_EQ(cube->contacts()[0].other, w.colliders[0].get());
}

TEST(MultiBodies, aBaseWithoutLinksIsHitAsARigidBox) {
  double end[2] = {0, 0};
  for (const bool multi : {false, true}) {
    MultiBodyWorld w(0);
    const btVector3 half = vec(0.3, 0.4, 0.5);
    btMultiBody* base = nullptr;
    btRigidBody* box = nullptr;
    if (multi) {
      base = w.addMultiBody(0, 2, half, vec(1.2, 0.1, 0), false);
      w.addCollider(base, -1, half);
      base->setCanSleep(false);
      w.enter(base);
    } else {
      box = w.addBox(half, 2, vec(1.2, 0.1, 0));
      box->setFriction(0);
      box->setActivationState(DISABLE_DEACTIVATION);
    }
    SoftBodySystem system(*w.world);
    SoftBodySettings s = cubeBesideLinksAt({0, 0, 0});
    s.linearVelocity = {3, 0, 0};
    SoftBody* cube = *system.createBody(closedCubeNetwork(), s);
    for (int i = 0; i < 45; ++i) {
      w.tick();
      double energy = 0;
      const double p = multi ? momentaOf(*base, energy).linear.x() : 2 * double(box->getLinearVelocity().x());
      // in single precision
      ASSERT_NEAR(cube->linearMomentum().x() + p, 3.0, 1e-4)
          << (multi ? "multibody" : "rigid") << " tick " << i;
      end[multi] = p;
    }
    EXPECT_GT(end[multi], 1.5);
  }
  // a multibody gets the velocity change of a tick at its start, a rigid body evenly over the tick
  EXPECT_NEAR(end[1], end[0], 0.05 * end[0]);
}

TEST(MultiBodies, aMassFactorMakesABaseAsHeavyAsARigidBox) {
  if (!kSurface) GTEST_SKIP() << "the points of the cube pass the box";
  MultiBodyWorld w(0);
  const btVector3 half = vec(0.3, 0.4, 0.5);
  btMultiBody* base = w.addMultiBody(0, 2, half, vec(1.2, 0, 0), false);
  w.addCollider(base, -1, half);
  w.enter(base);
  SoftBodySystem system(*w.world);
  constexpr double kFactor = 1e4;
  system.setContactFilter([](ContactCandidate& c) { c.otherMassFactor = kFactor; });
  SoftBodySettings s = cubeBesideLinksAt({0, 0, 0});
  s.linearVelocity = {3, 0, 0};
  SoftBody* cube = *system.createBody(closedCubeNetwork(), s);
  w.simulate(0.75);
  EXPECT_LT(cube->linearMomentum().x(), 0.0) << "it has come back";
  // at most as if the cube of 1 kg rebounded with its speed
  EXPECT_LT(std::abs(double(base->getBaseVel().x())), 2 * 3.0 / (2 * kFactor));
  EXPECT_GT(double(base->getBaseVel().x()), 0.0);
}

TEST(MultiBodies, aChainInSpaceKeepsAllMomentaInAHit) {
  for (const int rate : {60, 480}) {
    MultiBodyWorld w(0);
    const btVector3 half = vec(0.1, 0.4, 0.4);
    btMultiBody* chain = w.addMultiBody(2, 1, half, vec(1.0, -0.5, 0.1), false);
    w.addCollider(chain, -1, half);
    for (int i = 0; i < 2; ++i) {
      // hinges about z at the upper edges
      chain->setupRevolute(i, btScalar(0.5), inertiaOf(half, 0.5), i - 1, btQuaternion::getIdentity(),
                           btVector3(0, 0, 1), vec(0, 0.45, 0), vec(0, 0.45, 0), true);
      w.addCollider(chain, i, half);
    }
    chain->setCanSleep(false);
    w.enter(chain);
    SoftBodySystem system(*w.world);
    SoftBodySettings s = cubeBesideLinksAt({0.2, 0.2, 0});
    s.linearVelocity = {4, 0, 0};
    SoftBody* cube = *system.createBody(closedCubeNetwork(), s);
    const Vector3d angular = cube->angularMomentum();
    double jointSpeed = 0;
    for (int i = 0; i < rate; ++i) {
      w.tick(1.0 / rate);
      double energy = energyOf(*cube);
      const Momenta m = momentaOf(*chain, energy);
      // Bullet keeps the joint speeds, not the momenta of a rotating chain, and the impulses of a tick are
      // those at its start: an error of the tick's order
      ASSERT_LT((cube->linearMomentum() + m.linear - Vector3d(4, 0, 0)).norm(), 0.15 * 60 / rate)
          << "tick " << i;
      ASSERT_LT((cube->angularMomentum() + m.angular - angular).norm(), 0.2 * 60 / rate) << "tick " << i;
      ASSERT_LT(energy, 8.0 * 1.02) << "tick " << i << " at " << rate << " Hz";
      jointSpeed = std::max(jointSpeed, std::abs(double(chain->getJointVel(0))));
    }
    EXPECT_LT(cube->linearMomentum().x(), 3.0);
    EXPECT_GT(jointSpeed, 0.5);
  }
}

TEST(MultiBodies, aDoorSwingsOpenWhenItIsHit) {
  MultiBodyWorld w(0);
  btMultiBody* frame = w.addMultiBody(1, 0, vec(0.1, 1, 0.1), vec(1, 0, -0.6), true);
  const btVector3 half = vec(0.05, 0.6, 0.6);
  frame->setupRevolute(0, 2, inertiaOf(half, 2), -1, btQuaternion::getIdentity(), btVector3(0, 1, 0),
                       vec(0, 0, 0), vec(0, 0, 0.6), true);
  w.addCollider(frame, 0, half);
  frame->setCanSleep(false);
  w.enter(frame);
  SoftBodySystem system(*w.world);
  SoftBodySettings s = cubeBesideLinksAt({0, 0, 0.2});
  s.linearVelocity = {3, 0, 0};
  SoftBody* cube = *system.createBody(closedCubeNetwork(), s);
  double farthest = -1;
  for (int i = 0; i < 45; ++i) {
    w.tick();
    double energy = energyOf(*cube);
    momentaOf(*frame, energy);
    ASSERT_LT(energy, 4.5 * 1.02) << "tick " << i;
    // the hinge transfers forces but no torque about its axis: the sum is m v r of the cube
    const double hinge = (cube->angularMomentum() - Vector3d(1, 0, -0.6).cross(cube->linearMomentum())).y();
    const double door = double(frame->getJointVel(0)) * (2.0 * (1.44 + 0.01) / 12.0 + 2.0 * 0.36);
    // to a thousandth; to two hundredths for masses in the world, on which Bullet's solver also acts
    ASSERT_NEAR(hinge + door, 3.0 * 0.8, kSurface ? 3e-3 : 0.05) << "tick " << i;
    // in the door's frame no point is on its other side
    const btTransform pose = w.colliders[0]->getWorldTransform();
    for (std::uint32_t p = 0; p < 8; ++p) {
      const Vector3d point = cube->position(p),
                     x = eigen(pose.inverse() * vec(point.x(), point.y(), point.z()));
      if (std::abs(x.z()) < 0.55) farthest = std::max(farthest, x.x());
    }
  }
  EXPECT_GT(double(frame->getJointVel(0)), 0.3);
  // in the tick of the impact Bullet moves the door further after the contact: about a centimetre
  EXPECT_LT(farthest, -0.05 - kRadius + 0.03);
}

TEST(MultiBodies, whatACubeHitsWhenItReboundsWithinATickKeepsMomentum) {
  constexpr double kSpeed = 20.0;
  MultiBodyWorld w(0);
  // The first is behind a cube that flies towards the second: their contact is not predicted.
  for (const double x : {-0.75, 0.75}) {
    btMultiBody* box = w.addMultiBody(0, 4, vec(0.2, 0.6, 0.6), vec(x, 0, 0), false);
    w.addCollider(box, -1, vec(0.2, 0.6, 0.6));
    box->setCanSleep(false);
    w.enter(box);
  }
  SoftBodySystem system(*w.world);
  SoftBodySettings s = cubeBesideLinksAt({0, 0, 0});
  s.linearVelocity = {kSpeed, 0, 0};
  s.restitution = 1.0;
  s.extensionStiffness = s.compressionStiffness = 1e5;
  SoftBody* cube = *system.createBody(closedCubeNetwork(), s);
  for (int i = 0; i < 3; ++i) {
    w.tick(1.0 / 15);
    double energy = energyOf(*cube);
    Vector3d momentum = cube->linearMomentum();
    for (const auto& body : w.multiBodies) momentum += momentaOf(*body, energy).linear;
    // within the rounding of Bullet's floats
    ASSERT_NEAR(momentum.x(), kSpeed, 1e-4 * kSpeed) << "tick " << i;
    ASSERT_LT(energy, 0.5 * kSpeed * kSpeed * 1.02) << "tick " << i;
  }
  EXPECT_LT(w.multiBodies[0]->getBaseVel().x(), -0.3);
  EXPECT_GT(w.multiBodies[1]->getBaseVel().x(), 1);
}

/// How an arm is pressed down.
enum class Drive { JointTorque, LinkTorque, Motor };

/// Returns the moment (N m) of the contacts about the joint of an arm of 1 kg and 0.5 m that lies on a soft
/// cube and is pressed with 5 N m; 0.25 m g cos(angle) is the share of its weight. Less 5 N m and this share.
double missingMoment(Drive drive, double tick, double& sagged) {
  MultiBodyWorld bullet(-kGravity);
  bullet.addPlaneFloor();
  SoftBodySystem system(*bullet.world);
  const btVector3 half = vec(0.25, 0.03, 0.03);
  btMultiBody* arm = bullet.addMultiBody(1, 0.0, half, vec(-0.5, 0.25, 0), true);
  arm->setupRevolute(0, 1, inertiaOf(half, 1.0), -1, btQuaternion::getIdentity(), vec(0, 0, 1), vec(0, 0, 0),
                     vec(0.25, 0, 0), false);
  const btMultiBodyLinkCollider* link = bullet.addCollider(arm, 0, half);
  bullet.enter(arm);
  arm->setJointPos(0, btScalar(0.6));
  btMultiBodyJointMotor motor(arm, 0, -3, btScalar(5.0 * tick));
  if (drive == Drive::Motor) bullet.multiWorld->addMultiBodyConstraint(&motor);
  SoftBodySettings s = cubeBesideLinksAt({-0.1, 0.16, 0}, 0.5);
  s.scale.setConstant(0.3);
  setSprings(s, 3000.0, 10.0);
  s.pointRadius = 0.005;
  const SoftBody& cube = **system.createBody(closedCubeNetwork(), s);
  const auto press = [&](double seconds) {
    double moment = 0.0;
    const int ticks = static_cast<int>(seconds / tick + 0.5);
    for (int i = 0; i < ticks; ++i) {
      if (drive == Drive::JointTorque) arm->addJointTorque(0, -5);
      if (drive == Drive::LinkTorque) arm->addLinkTorque(0, vec(0, 0, -5));
      bullet.tick(tick);
      for (const SoftContact& c : cube.contacts())
        if (c.other == link)
          moment -= double((c.position - vec(-0.5, 0.25, 0)).cross(c.impulse).z()) / seconds;
    }
    return moment;
  };
  press(2.0);
  const double before = double(arm->getJointPos(0)), moment = press(1.0);
  sagged = before - double(arm->getJointPos(0));
  if (drive == Drive::Motor) bullet.multiWorld->removeMultiBodyConstraint(&motor);
  return 5.0 + kGravity * 0.25 * std::cos(before) - moment;
}

/// Their torques were not part of the step: the arm sank at 0.1 rad/s, and the contacts carried its weight.
TEST(MultiBodies, torquesAndMotorsOfJointsPressWithTheirMoment) {
  if (!kSurface) GTEST_SKIP() << "the arm falls between the points";
  for (const Drive drive : {Drive::JointTorque, Drive::LinkTorque, Drive::Motor})
    for (const double tick : {1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0}) {
      double sagged = 0.0;
      EXPECT_NEAR(missingMoment(drive, tick, sagged), 0.0, 0.05) << int(drive) << ' ' << tick;
      EXPECT_NEAR(sagged, 0.0, 2e-3) << int(drive) << ' ' << tick;
    }
}

/// Bullet integrated the velocity at the end of the tick, which is not that of the step on the way: a box
/// that fell on a cloth tilted by half a radian and sank into it.
TEST(MultiBodies, aBaseOnAClothLiesFlat) {
  if (!kSurface) GTEST_SKIP() << "the box falls between the points";
  for (const double tick : variants({1.0 / 30.0, 1.0 / 240.0}, {1.0 / 60.0})) {
    MultiBodyWorld bullet(-kGravity);
    SoftBodySystem system(*bullet.world);
    const btVector3 half = vec(0.1, 0.1, 0.1);
    btMultiBody* box = bullet.addMultiBody(0, 2.0, half, vec(0.03, 2.13, 0.02), false);
    bullet.addCollider(box, -1, half)->setFriction(btScalar(0.5));
    bullet.enter(box);
    SoftBodySettings s;
    s.position.y() = 2.0;
    s.totalMass = 2.0;
    setSprings(s, 8000.0, 5.0);
    SoftBody& cloth = **system.createBody(squareCloth(14, 2.0), s);
    for (std::uint32_t i = 0; i < 15; ++i)
      for (const std::uint32_t border : {i, 210 + i, 15 * i, 15 * i + 14}) cloth.pin(border);
    for (double time = 0.0; time < 3.0; time += tick) {
      bullet.tick(tick);
      const btVector3 up = btMatrix3x3(box->getWorldToBaseRot()).getColumn(1);
      ASSERT_GT(double(up.y()), 0.99) << tick << ", at " << time << " s";
      ASSERT_GT(double(box->getBasePos().y()), 1.9) << tick << ", at " << time << " s";
    }
  }
}

/// The second arm shares only the fixed base with the first one, which lies on a cube. It swings as it would
/// alone: with forces of the tick's start alone it gained 6 J in 20 s and went over the top.
TEST(MultiBodies, whatIsNotTouchedSwingsAsBefore) {
  MultiBodyWorld bullet(-kGravity);
  bullet.addPlaneFloor();
  SoftBodySystem system(*bullet.world);
  const btVector3 half = vec(0.25, 0.03, 0.03);
  btMultiBody* arms = bullet.addMultiBody(2, 0.0, half, vec(-0.5, 0.25, 0), true);
  for (int link = 0; link < 2; ++link) {
    arms->setupRevolute(link, 1, inertiaOf(half, 1.0), -1, btQuaternion::getIdentity(), vec(0, 0, 1),
                        vec(0, 0, link), vec(0.25, 0, 0), false);
    bullet.addCollider(arms, link, half);
  }
  bullet.enter(arms);
  SoftBodySettings s = cubeBesideLinksAt({-0.1, 0.16, 0}, 0.5);
  s.scale.setConstant(0.3);
  s.pointRadius = 0.005;
  (void)*system.createBody(closedCubeNetwork(), s);
  // of the pendulum: (I + m l^2) w^2 / 2 + m g l sin(angle), I about its centre
  const double inertia = double(inertiaOf(half, 1.0).z()) + 0.0625;
  const auto energy = [&] {
    const double angle = double(arms->getJointPos(1)), speed = double(arms->getJointVel(1));
    return 0.5 * inertia * speed * speed + kGravity * 0.25 * std::sin(angle);
  };
  for (int i = 0; i < 600; ++i) {
    bullet.tick();
    EXPECT_LT(energy(), 0.1) << i;  // Bullet alone: up to 0.1 of the 2.5 J that it swings with
  }
  EXPECT_GT(energy(), -0.3);
}

/// Nothing is searched for near a body at rest but what is near.
TEST(MultiBodies, aBaseThatIsThrownSuddenlyIsStopped) {
  if (!kSurface) GTEST_SKIP() << "Bullet finds the partners of points";
  for (const bool rested : {false, true}) {
    MultiBodyWorld bullet(0.0);
    SoftBodySystem system(*bullet.world);
    const btVector3 half = vec(0.4, 0.4, 0.4);
    btMultiBody* box = bullet.addMultiBody(0, 1.0, half, vec(0, 1.5, 0), false);
    bullet.addCollider(box, -1, half);
    bullet.enter(box);
    SoftBodySettings s = cubeBesideLinksAt({0.02, 0, 0.01});
    s.totalMass = 20.0;
    s.extensionStiffness = s.compressionStiffness = 5e4;
    SoftBody& cube = **system.createBody(closedCubeNetwork(), s);
    if (rested) bullet.simulate(0.5);
    box->setBaseVel(vec(0, -60, 0));  // a metre a tick
    bullet.simulate(0.1);
    EXPECT_GT(double(box->getBasePos().y()), cube.centerOfMass().y()) << rested;
    EXPECT_LT(cube.linearMomentum().y(), -30.0) << rested;
  }
}

/// What carries it is for Bullet's solver, to which it must not seem to fall in each tick.
TEST(MultiBodies, aBaseOnTheFloorUnderACubeStaysStill) {
  MultiBodyWorld bullet(-kGravity);
  bullet.addBoxFloor()->setFriction(1);
  SoftBodySystem system(*bullet.world);
  const btVector3 half = vec(0.7, 0.2, 0.7);
  btMultiBody* box = bullet.addMultiBody(0, 5.0, half, vec(0, 0.2, 0), false);
  btMultiBodyLinkCollider* collider = bullet.addCollider(box, -1, half);
  bullet.enter(box);
  // Bullet adds it as a static object
  collider->getBroadphaseHandle()->m_collisionFilterGroup = btBroadphaseProxy::DefaultFilter;
  collider->getBroadphaseHandle()->m_collisionFilterMask = btBroadphaseProxy::AllFilter;
  SoftBodySettings s = cubeBesideLinksAt({0.02, 0.93, 0.01}, 1.0);
  s.sleepingSpeed = 0.0;
  const SoftBody& cube = **system.createBody(closedCubeNetwork(), s);
  bullet.simulate(3.0);
  EXPECT_NEAR(double(box->getBasePos().y()), 0.2, 0.01);
  EXPECT_LT(double(box->getBaseVel().length()), 0.02);
  EXPECT_NEAR(cube.centerOfMass().y(), 0.92, 0.02);
  EXPECT_LT(cube.linearMomentum().norm(), 1e-3);
}

/// Stops at its limit and stays there, whether a soft body or nothing presses it.
TEST(MultiBodies, aDoorThatIsHitStopsAtItsLimit) {
  if (!kSurface) GTEST_SKIP() << "its edge passes between the points";
  MultiBodyWorld bullet(0.0);
  SoftBodySystem system(*bullet.world);
  const btVector3 half = vec(0.5, 1, 0.05);
  btMultiBody* door = bullet.addMultiBody(1, 0.0, half, vec(0, 0, 0), true);
  door->setupRevolute(0, 2, inertiaOf(half, 2.0), -1, btQuaternion::getIdentity(), vec(0, 1, 0), vec(0, 0, 0),
                      vec(0.5, 0, 0), false);
  bullet.addCollider(door, 0, half);
  bullet.enter(door);
  btMultiBodyJointLimitConstraint limit(door, 0, btScalar(-0.3), btScalar(0.3));
  bullet.multiWorld->addMultiBodyConstraint(&limit);
  SoftBodySettings s = cubeBesideLinksAt({0.6, 0, 0.8});
  s.linearVelocity.z() = -5.0;
  SoftBody& cube = **system.createBody(closedCubeNetwork(), s);
  double farthest = 0.0;
  for (int i = 0; i < 120; ++i) {
    bullet.tick();
    farthest = std::max(farthest, std::abs(double(door->getJointPos(0))));
  }
  EXPECT_GT(farthest, 0.29);
  EXPECT_LT(farthest, 0.32);
  EXPECT_LT(std::abs(double(door->getJointVel(0))), 1.0);
  EXPECT_GT(cube.linearMomentum().z(), 0.0);
  bullet.multiWorld->removeMultiBodyConstraint(&limit);
}

TEST(MultiBodies, aMovingCharacterPushesACubeASensorDoesNot) {
  for (const bool sensor : {false, true}) {
    SoftWorld bullet(0);
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), cubeBesideLinksAt({0, 0, 0}));
    btCapsuleShape capsule(btScalar(0.3), btScalar(1));
    btPairCachingGhostObject ghost;
    ghost.setCollisionShape(&capsule);
    ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT |
                            (sensor ? btCollisionObject::CF_NO_CONTACT_RESPONSE : 0));
    double x = -1.4;
    ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(x, 0, 0)));
    bullet.world->addCollisionObject(&ghost, btBroadphaseProxy::CharacterFilter,
                                     btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
    for (int i = 0; i < 60; ++i) {
      // as btKinematicCharacterController does
      x += 2 * kTick;
      ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(x, 0, 0)));
      bullet.tick();
    }
    bullet.world->removeCollisionObject(&ghost);
    if (sensor) {
      EXPECT_EQ(cube->linearMomentum().norm(), 0.0);
      continue;
    }
    EXPECT_LT(cube->linearMomentum().x(), 4.1);
    // a capsule fits between the corners of the face
    if (!kSurface) continue;
    EXPECT_GT(cube->linearMomentum().x(), 1.9);
    EXPECT_GT(cube->centerOfMass().x(), x + 0.3 + 0.5 - 0.15);
  }
}

}  // namespace
}  // namespace limber::test
