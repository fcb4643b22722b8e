// SPDX-License-Identifier: Zlib
// The application's changes to a surface object act on the soft body as on a rigid body of its mass and
// inertia. The tests compare it with such a rigid twin in a second world.
#include "support/soft_world.h"

#include <cmath>

namespace limber::test {
namespace {

using Eigen::Vector3d;

constexpr double kMass = 2.0;

SoftBodySettings cubeSettings(const Vector3d& position, double stiffness = 1e4) {
  SoftBodySettings s = settingsAt(position);
  s.totalMass = kMass;
  setSprings(s, stiffness, 0.1 * std::sqrt(stiffness));
  return s;
}

/// A soft cube and, in a second world, a rigid one with the inertia of eight points at its corners.
struct Twins {
  explicit Twins(double gravity = 0.0, const Vector3d& position = Vector3d(0.3, 2, -0.2))
      : world(gravity), twinWorld(gravity), system(*world.world) {
    soft = *system.createBody(closedCubeNetwork(), cubeSettings(position));
    object = soft->surfaceObject();
    twin = twinWorld.addBox(vec(0.5, 0.5, 0.5), kMass, vec(position.x(), position.y(), position.z()));
    twin->setMassProps(static_cast<btScalar>(kMass), vec(0.5 * kMass, 0.5 * kMass, 0.5 * kMass));
    twin->updateInertiaTensor();
    for (btRigidBody* body : {object, twin}) body->setActivationState(DISABLE_DEACTIVATION);
  }

  void tick() {
    world.tick();
    twinWorld.tick();
  }

  /// Tolerance: 1e-5, with momenta of about 1.
  void expectEqualMomenta(const char* when) const {
    EXPECT_LT((soft->linearMomentum() - momentumOf(*twin)).norm(), 1e-5) << when;
    EXPECT_LT((soft->angularMomentum() - angularMomentumOf(*twin)).norm(), 2e-5) << when;
  }

  BulletWorld world, twinWorld;
  SoftBodySystem system;
  SoftBody* soft;
  btRigidBody *object, *twin;
};

TEST(SurfaceObjects, areRigidBodiesToTheirUsers) {
  Twins t;
  EXPECT_NEAR(double(t.object->getInvMass()), 1 / kMass, 1e-6);
  EXPECT_FALSE(t.object->isStaticOrKinematicObject());
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(double(t.object->getInvInertiaTensorWorld()[i][i]), 1 / kMass / 0.5, 1e-5);
  t.soft->point(0)->setMassProps(1, btVector3(0, 0, 0));
  t.tick();
  EXPECT_NEAR(double(t.object->getInvMass()), 1 / (kMass + 0.75), 1e-6);
  for (std::uint32_t i = 0; i < 8; ++i) t.soft->pin(i);
  t.tick();
  EXPECT_EQ(double(t.object->getInvMass()), 0.0);
  EXPECT_FALSE(t.object->isStaticOrKinematicObject());
}

TEST(SurfaceObjects, impulsesActAsOnARigidBody) {
  Twins t;
  const btVector3 impulse = vec(0.4, -0.3, 0.9), arm = vec(0.5, 0.2, -0.4);
  for (btRigidBody* body : {t.object, t.twin}) {
    body->applyCentralImpulse(vec(0, 0.5, 0));
    body->applyImpulse(impulse, arm);
  }
  t.expectEqualMomenta("at once");
  for (int i = 0; i < 30; ++i) t.tick();
  t.expectEqualMomenta("after half a second");
  EXPECT_LT((t.soft->centerOfMass() - eigen(t.twin->getCenterOfMassPosition())).norm(), 1e-5);
  // the object has the same velocity
  EXPECT_LT((eigen(t.object->getLinearVelocity()) - eigen(t.twin->getLinearVelocity())).norm(), 1e-5);
}

TEST(SurfaceObjects, impulsesActOnBodiesWhosePointsAreInUseToo) {
  Twins t;
  t.soft->point(3)->applyCentralImpulse(vec(0.1, 0, 0));
  t.twin->applyImpulse(vec(0.1, 0, 0), vec(0, 0, 0));
  const Vector3d arm = t.soft->position(3) - t.soft->centerOfMass();
  t.twin->applyTorqueImpulse(vec(arm.x(), arm.y(), arm.z()).cross(vec(0.1, 0, 0)));
  for (btRigidBody* body : {t.object, t.twin}) body->applyImpulse(vec(0, 0.7, 0), vec(0.5, 0, 0.2));
  t.expectEqualMomenta("at once");
  // the points have single precision
  EXPECT_LT((eigen(t.soft->point(5)->getLinearVelocity()) - t.soft->velocity(5)).norm(), 1e-6);
  for (int i = 0; i < 10; ++i) t.tick();
  t.expectEqualMomenta("ten ticks later");
}

TEST(SurfaceObjects, aTorqueAboutItsOwnLineDoesNothingToAStraightRope) {
  for (const Vector3d& rotation : {Vector3d(0, 0, 0), Vector3d(0.3, 1.1, -0.5)}) {
    BulletWorld world(0.0);
    SoftBodySystem system(*world.world);
    SoftBodySettings s = cubeSettings(Vector3d(0.3, 2, -0.2));
    if (!rotation.isZero()) s.rotation = Eigen::AngleAxisd(rotation.norm(), rotation.normalized());
    SoftBody& rope = **system.createBody(pairNetwork(), s);
    rope.surfaceObject()->setActivationState(DISABLE_DEACTIVATION);
    const Vector3d axis = (rope.position(1) - rope.position(0)).normalized(), across = axis.unitOrthogonal();
    const auto spin = [&]() -> Vector3d {
      return rope.angularMomentum() - rope.centerOfMass().cross(rope.linearMomentum());
    };
    rope.surfaceObject()->applyTorqueImpulse(vec(3 * axis.x(), 3 * axis.y(), 3 * axis.z()));
    // the direction is in floats
    EXPECT_LT(rope.linearMomentum().norm() + spin().norm(), 1e-5);
    rope.surfaceObject()->applyTorqueImpulse(vec(across.x(), across.y(), across.z()));
    EXPECT_LT((spin() - across).norm(), 1e-5);
    rope.surfaceObject()->applyTorque(vec(60 * axis.x(), 60 * axis.y(), 60 * axis.z()));
    world.tick();
    EXPECT_LT(rope.linearMomentum().norm() + (spin() - across).norm(), 1e-4);
  }
}

TEST(SurfaceObjects, forcesActForAllTicksOfAStep) {
  for (const int ticks : {1, 2, 4}) {
    Twins t;
    for (int step = 0; step < 10; ++step) {
      for (btRigidBody* body : {t.object, t.twin}) {
        body->applyForce(vec(6, 0, 1), vec(0, 0.4, 0.1));
        body->applyTorque(vec(0, 2, 0));
      }
      for (BulletWorld* w : {&t.world, &t.twinWorld})
        w->world->stepSimulation(btScalar(kTick) * btScalar(1.0001), ticks, btScalar(kTick / ticks));
    }
    // one N for ten steps, and none for the steps after
    for (int i = 0; i < 3; ++i) t.tick();
    EXPECT_NEAR(t.soft->linearMomentum().x(), 60 * kTick, 1e-4) << ticks;
    EXPECT_LT((t.soft->linearMomentum() - momentumOf(*t.twin)).norm(), 1e-5) << ticks;
    // both torques act in the rotated state; the soft body is also slightly deformed
    const Vector3d spin = t.soft->angularMomentum() - t.soft->centerOfMass().cross(t.soft->linearMomentum());
    const Vector3d twinSpin =
        angularMomentumOf(*t.twin) - eigen(t.twin->getCenterOfMassPosition()).cross(momentumOf(*t.twin));
    EXPECT_LT((spin - twinSpin).norm(), 1e-4) << ticks;
  }
}

/// Of frames at 144 Hz more than half have no tick. Bullet clears the forces of each frame.
TEST(SurfaceObjects, forcesOfFramesWithoutATickAreLost) {
  Twins t;
  for (int frame = 0; frame < 144; ++frame) {
    for (btRigidBody* body : {t.object, t.twin}) {
      body->applyCentralForce(vec(6, 0, 1));
      body->applyTorque(vec(0, 0.2, 0));
    }
    for (BulletWorld* w : {&t.world, &t.twinWorld})
      w->world->stepSimulation(btScalar(1.0 / 144.0), 10, btScalar(kTick));
    // the system learns of forces in the first tick with one
    if (frame < 5) t.object->clearForces();
  }
  EXPECT_GT(momentumOf(*t.twin).x(), 4.0);
  EXPECT_LT((t.soft->linearMomentum() - momentumOf(*t.twin)).norm(), 1e-4);
  EXPECT_NEAR(t.soft->angularMomentum().y(), angularMomentumOf(*t.twin).y(), 1e-3);
}

TEST(SurfaceObjects, velocitiesAreTakenOver) {
  Twins t;
  for (btRigidBody* body : {t.object, t.twin}) {
    body->setLinearVelocity(vec(1, 2, -1));
    body->setAngularVelocity(vec(0.3, -1, 0.2));
  }
  t.expectEqualMomenta("at once");
  for (int i = 0; i < 10; ++i) t.tick();
  t.expectEqualMomenta("ten ticks later");
  for (btRigidBody* body : {t.object, t.twin}) {
    body->setLinearVelocity(vec(0, 0, 0));
    body->setAngularVelocity(vec(0, 0, 0));
  }
  t.expectEqualMomenta("stopped");
}

TEST(SurfaceObjects, aBodyIsPutWhereTheObjectIsPut) {
  for (const bool asleep : {false, true}) {
    Twins t;
    t.object->setLinearVelocity(vec(1, 0, 0));
    t.object->setAngularVelocity(vec(0, 0, 0.5));
    t.tick();
    if (asleep) {
      t.object->forceActivationState(ACTIVE_TAG);
      t.object->setLinearVelocity(vec(0, 0, 0));
      t.object->setAngularVelocity(vec(0, 0, 0));
      for (int i = 0; i < 200 && !t.soft->sleeping(); ++i) t.tick();
      ASSERT_TRUE(t.soft->sleeping());
    }
    const Vector3d velocity = t.soft->linearMomentum(), corner = t.soft->position(6);
    const double energy = t.soft->elasticEnergy();
    const btTransform before = t.object->getWorldTransform();
    const btTransform after(btQuaternion(vec(1, 2, 0.5).normalized(), btScalar(0.8)), vec(7, 3, 1));
    if (asleep)
      t.object->setWorldTransform(after);
    else
      t.object->setCenterOfMassTransform(after);
    const Vector3d expected = eigen(after * (before.inverse() * vec(corner.x(), corner.y(), corner.z())));
    // in single precision, at 7 m
    EXPECT_LT((t.soft->position(6) - expected).norm(), 2e-6);
    EXPECT_LT((t.soft->linearMomentum() - velocity).norm(), 1e-6);
    EXPECT_NEAR(t.soft->elasticEnergy(), energy, 1e-6);
    t.world.tick();
    EXPECT_LT((t.soft->position(6) - expected).norm(), asleep ? 1e-5 : 0.05);
    // rays find it at the new pose
    btCollisionWorld::ClosestRayResultCallback ray(vec(7, 9, 1), vec(7, -9, 1));
    t.world.world->rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
    EXPECT_EQ(ray.m_collisionObject, t.object);
  }
}

TEST(SurfaceObjects, itTurnsWithTheBody) {
  Twins t;
  for (btRigidBody* body : {t.object, t.twin}) body->setAngularVelocity(vec(0.5, 2, -1));
  for (int i = 0; i < 120; ++i) t.tick();
  const btQuaternion soft = t.object->getWorldTransform().getRotation();
  // five radians; the rotation extends the cube slightly, m r w^2 / k, which makes it slower
  EXPECT_LT(double(soft.angleShortestPath(t.twin->getWorldTransform().getRotation())), 0.02);
}

TEST(SurfaceObjects, nonsenseIsRefused) {
  Twins t;
  const std::uint64_t hash = t.soft->stateHash();
  t.object->applyCentralImpulse(vec(std::nan(""), 0, 0));
  EXPECT_EQ(t.soft->stateHash(), hash);
  EXPECT_EQ(double(t.object->getLinearVelocity().length()), 0.0);
}

// --- constraints -------------------------------------------------------------------------------------------

/// Works like Bullet's CommonRigidBodyBase::pickBody(), movePickedBody() and removePickingConstraint().
class Picker {
 public:
  Picker(btDiscreteDynamicsWorld& world, const btVector3& from, const btVector3& to) : world_(&world) {
    btCollisionWorld::ClosestRayResultCallback ray(from, to);
    world.rayTest(from, to, ray);
    if (!ray.hasHit()) return;
    auto* body = const_cast<btRigidBody*>(btRigidBody::upcast(ray.m_collisionObject));
    if (!body || body->isStaticObject() || body->isKinematicObject()) return;
    state_ = body->getActivationState();
    body->setActivationState(DISABLE_DEACTIVATION);
    const btVector3 pivot = body->getCenterOfMassTransform().inverse() * ray.m_hitPointWorld;
    picked_ = std::make_unique<btPoint2PointConstraint>(*body, pivot);
    world.addConstraint(picked_.get(), true);
    picked_->m_setting.m_impulseClamp = btScalar(30);
    picked_->m_setting.m_tau = btScalar(0.001);
    hitPoint = ray.m_hitPointWorld;
  }
  ~Picker() {
    if (!picked_) return;
    picked_->getRigidBodyA().forceActivationState(state_);
    picked_->getRigidBodyA().activate();
    world_->removeConstraint(picked_.get());
  }
  Picker(const Picker&) = delete;
  Picker& operator=(const Picker&) = delete;

  bool has() const { return picked_ != nullptr; }
  void moveTo(const btVector3& target) { picked_->setPivotB(target); }
  btVector3 hitPoint = btVector3(0, 0, 0);

 private:
  btDiscreteDynamicsWorld* world_;
  std::unique_ptr<btPoint2PointConstraint> picked_;
  int state_ = 0;
};

TEST(SurfaceObjects, bulletsPickingDragsASoftCubeAsARigidOne) {
  Twins t(0.0, {0, 2, 0});
  t.object->forceActivationState(ACTIVE_TAG);
  Picker soft(*t.world.world, vec(0.2, 2.3, 5), vec(0.2, 2.3, -5));
  // the same ray picks both, but the soft cube's surface is one radius farther out
  Picker rigid(*t.twinWorld.world, vec(0.2, 2.3, 5), vec(0.2, 2.3, -5));
  ASSERT_TRUE(soft.has());
  ASSERT_TRUE(rigid.has());
  double distance = 0;
  for (int i = 0; i < 90; ++i) {
    distance = std::min(distance + 2 * kTick, 2.0);
    soft.moveTo(soft.hitPoint + vec(distance, 0.5 * distance, 0));
    rigid.moveTo(rigid.hitPoint + vec(distance, 0.5 * distance, 0));
    t.tick();
    const Vector3d offset = t.soft->centerOfMass() - eigen(t.twin->getCenterOfMassPosition());
    // a few per cent of the distance; the radius is 4 % of the moment arm
    ASSERT_LT(offset.norm(), 0.02 + 0.03 * distance) << "tick " << i;
  }
  EXPECT_GT(t.soft->centerOfMass().x(), 0.5);
}

TEST(SurfaceObjects, aPointToPointConstraintHoldsThemAsRigidBodies) {
  Twins t(-9.81, {0, 2, 0});
  std::vector<std::unique_ptr<btPoint2PointConstraint>> joints;
  const btVector3 pivot = vec(0.5, 0.5, 0.5);
  for (auto [body, world] : {std::pair(t.object, &t.world), std::pair(t.twin, &t.twinWorld)}) {
    joints.push_back(std::make_unique<btPoint2PointConstraint>(*body, pivot));
    world->world->addConstraint(joints.back().get());
  }
  double energy = 0;
  for (int i = 0; i < 120; ++i) {
    t.tick();
    const btVector3 softPivot = t.object->getCenterOfMassTransform() * pivot;
    const btVector3 twinPivot = t.twin->getCenterOfMassTransform() * pivot;
    // the pivot of the twin itself moves by up to a centimetre
    ASSERT_LT(double((softPivot - vec(0.5, 2.5, 0.5)).length()), 0.001)
        << "tick " << i << ", the twin: " << double((twinPivot - vec(0.5, 2.5, 0.5)).length());
    energy = energyOf(*t.soft) + kMass * 9.81 * (t.soft->centerOfMass().y() - 2);
    // of the 17 J of its swing; the rigid twin has an error of some per cent
    ASSERT_LT(energy, 0.02) << "tick " << i;
    if (i < 60) {
      ASSERT_LT((t.soft->centerOfMass() - eigen(t.twin->getCenterOfMassPosition())).norm(), 0.05) << i;
    }
  }
  EXPECT_GT(energy, -0.2);
  t.world.world->removeConstraint(joints[0].get());
  t.twinWorld.world->removeConstraint(joints[1].get());
}

/// A mouse at 3 m/s that stops 1.5 m behind a wall: 10 N s per tick on a body of 1 kg. Bullet's box goes in
/// by 10 cm. The points used to end up behind the wall and to stay there.
TEST(SurfaceObjects, picksDoNotPullThemThroughWalls) {
  for (const double thickness : {0.1, 0.2, 4.0})
    for (const double clamp : {2.0, 10.0, 30.0}) {
      SoftWorld bullet;
      bullet.addPlaneFloor();
      bullet.addBox(vec(thickness / 2, 5, 5), 0, vec(2 + thickness / 2, 0, 0));
      SoftBodySettings s = settingsAt({0.5, 1.0, 0});
      setSprings(s, 2e4, 60.0);
      SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
      btPoint2PointConstraint pick(*cube->surfaceObject(), vec(0.1, 0.2, 0));
      pick.m_setting.m_impulseClamp = btScalar(clamp);
      pick.m_setting.m_tau = btScalar(0.001);
      bullet.world->addConstraint(&pick, true);
      double deepest = -HUGE_VAL;
      for (int i = 0; i < 180; ++i) {
        pick.setPivotB(vec(std::min(0.5 + 0.05 * i, 3.5), 1.2, 0));
        cube->wake();
        bullet.tick();
        for (std::uint32_t p = 0; p < cube->pointCount(); ++p)
          deepest = std::max(deepest, cube->position(p).x() - 2.0);
      }
      bullet.world->removeConstraint(&pick);
      // the points are spheres of the radius outside it; what presses them in is 600 times their weight
      EXPECT_LT(deepest, 0.0) << thickness << " m, " << clamp << " N s";
      bullet.simulate(1.0);
      EXPECT_LT(cube->centerOfMass().x(), 1.6) << thickness << " m, " << clamp << " N s";
    }
}

/// A shelf bears a box, and a box on a soft cube stands on a plank: the joints' forces act in the same step
/// as the contacts.
TEST(SurfaceObjects, jointedOnesBearFreeBodiesAndStandOnThem) {
  for (const double tick : {1.0 / 240, 1.0 / 120, 1.0 / 60, 1.0 / 15})
    for (const double mass : {0.2, 1.0, 5.0}) {
      SoftWorld bullet;
      bullet.addPlaneFloor();
      SoftBodySettings s = settingsAt({0, 2, 0});
      setSprings(s, 1e4, 5.0);
      SoftBody* shelf = bullet.addSoft(closedCubeNetwork(), s);
      s.position = {5, 0.7, 0};
      SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
      const double radius = kRadius;
      btRigidBody* load = bullet.addBox(vec(0.4, 0.2, 0.4), mass, vec(0, 2.7 + radius, 0));
      btRigidBody* plank = bullet.addBox(vec(1, 0.1, 1), 5.0, vec(5, 0.1, 0));
      btRigidBody* top = bullet.addBox(vec(0.3, 0.1, 0.3), mass, vec(5, 1.5, 0));
      btTransform up = btTransform::getIdentity();
      up.setOrigin(vec(0, 0.8, 0));
      btFixedConstraint hung(*shelf->surfaceObject(), btTypedConstraint::getFixedBody(),
                             btTransform::getIdentity(),
                             btTransform(btQuaternion::getIdentity(), vec(0, 2, 0)));
      btFixedConstraint carried(*cube->surfaceObject(), *top, up, btTransform::getIdentity());
      bullet.world->addConstraint(&hung, true);
      bullet.world->addConstraint(&carried, true);
      for (double t = 0.0; t < 3.0; t += tick) bullet.world->stepSimulation(btScalar(tick), 0);
      SCOPED_TRACE(testing::Message() << mass << " kg, " << tick << " s");
      EXPECT_NEAR(heightOf(*load), 2.7 + radius, 0.02);
      EXPECT_GT(lowest(*cube), heightOf(*plank) + 0.1 + radius - 0.02);
      // of a sphere above the plank's surface
      EXPECT_NEAR(heightOf(*top), 1.5 + radius, 0.005);
      bullet.world->removeConstraint(&hung);
      bullet.world->removeConstraint(&carried);
    }
}

/// A pendulum of a stiff cube. Displacements in proportion to the joint's spin stretched it: at 1/15 s it
/// stored seven times the energy of its motion.
TEST(SurfaceObjects, aJointDoesNotStretchThem) {
  for (const double tick : {1.0 / 240, 1.0 / 60, 1.0 / 15}) {
    SoftWorld bullet;
    SoftBodySettings s = testedSettings();
    setSprings(s, 1e5, 50.0);
    SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
    cube->surfaceObject()->setActivationState(DISABLE_DEACTIVATION);
    btPoint2PointConstraint joint(*cube->surfaceObject(), vec(-0.5, 0, 0));
    bullet.world->addConstraint(&joint, true);
    double stored = 0.0, fastest = 0.0;
    for (double t = 0.0; t < 2.0; t += tick) {
      bullet.world->stepSimulation(btScalar(tick), 0);
      stored = std::max(stored, cube->elasticEnergy());
      fastest = std::max(fastest, cube->kineticEnergy());
    }
    bullet.world->removeConstraint(&joint);
    EXPECT_GT(fastest, 0.5 * cube->totalMass() * 9.81 * 0.5) << tick;
    // three times its weight at a point stretches it by some 1e-4 of its size
    EXPECT_LT(stored, 1e-3 * fastest) << tick;
  }
}

TEST(SurfaceObjects, aHeldBodyOnAFloorStaysOnIt) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBody* soft = bullet.addSoft(closedCubeNetwork(), cubeSettings({0, 0.52, 0}));
  btRigidBody* object = soft->surfaceObject();
  object->setActivationState(DISABLE_DEACTIVATION);
  // the constraint pulls it into the floor
  btPoint2PointConstraint joint(*object, vec(0, 0, 0));
  joint.setPivotB(vec(0.5, 0.3, 0));
  joint.m_setting.m_impulseClamp = btScalar(0.5);
  bullet.world->addConstraint(&joint);
  for (int i = 0; i < 90; ++i) {
    bullet.tick();
    ASSERT_GT(lowest(*soft), 0.015) << "tick " << i;
  }
  EXPECT_NEAR(soft->centerOfMass().x(), 0.5, 0.1);
  bullet.world->removeConstraint(&joint);
}

/// A free soft cube, or its rigid twin, that a joint holds to a rigid box, which starts at 4 m/s.
struct JoinedPair {
  explicit JoinedPair(const Vector3d& velocity) : twins(0.0, {0, 0, 0}) {
    for (auto [body, world] :
         {std::pair(twins.object, &twins.world), std::pair(twins.twin, &twins.twinWorld)}) {
      btRigidBody* box = world->addBox(vec(0.2, 0.2, 0.2), 1, vec(0, 1.2, 0));
      box->setActivationState(DISABLE_DEACTIVATION);
      box->setLinearVelocity(vec(velocity.x(), velocity.y(), velocity.z()));
      boxes.push_back(box);
      joints.push_back(
          std::make_unique<btPoint2PointConstraint>(*body, *box, vec(0, 0.6, 0), vec(0, -0.6, 0)));
      world->world->addConstraint(joints.back().get(), true);
    }
  }
  ~JoinedPair() {
    twins.world.world->removeConstraint(joints[0].get());
    twins.twinWorld.world->removeConstraint(joints[1].get());
  }
  Vector3d softMomentum() const { return twins.soft->linearMomentum() + momentumOf(*boxes[0]); }
  Vector3d softSpin() const { return twins.soft->angularMomentum() + angularMomentumOf(*boxes[0]); }
  Vector3d twinSpin() const { return angularMomentumOf(*twins.twin) + angularMomentumOf(*boxes[1]); }

  Twins twins;
  std::vector<btRigidBody*> boxes;
  std::vector<std::unique_ptr<btPoint2PointConstraint>> joints;
};

TEST(SurfaceObjects, aJointKeepsMomentumAndAngularMomentum) {
  for (const Vector3d& velocity : {Vector3d(4, 0, 0), Vector3d(4, 0, 1)}) {
    JoinedPair pair(velocity);
    const Vector3d momentum = pair.softMomentum(), spin = pair.softSpin();
    for (int i = 0; i < 600; ++i) {
      pair.twins.tick();
      // within the rounding of Bullet's floats
      ASSERT_LT((pair.softMomentum() - momentum).norm(), 2e-4) << "tick " << i;
    }
    EXPECT_LT((pair.softSpin() - spin).norm(), 1e-3 * spin.norm())
        << "the twin's: " << (pair.twinSpin() - spin).norm();
  }
}

}  // namespace
}  // namespace limber::test
