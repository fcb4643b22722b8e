// SPDX-License-Identifier: Zlib
// Rigid bodies that touch or carry soft bodies or hang on them. Bullet acts on them before, during and after
// the plugin's part of a tick.
#include "support/soft_world.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace limber::test {
namespace {

btRigidBody* addAwakeBox(BulletWorld& bullet, double half, double mass, const btVector3& position) {
  return bullet.addAwakeBox(vec(half, half, half), mass, position);
}

/// A soft cube next to a stack of two rigid boxes on the floor. It touches the lower box.
struct CubeAtAStack {
  BulletWorld bullet;
  ActionOnce action;
  btRigidBody *lower, *upper;
  std::unique_ptr<SoftBodySystem> system;
  SoftBody* cube;

  CubeAtAStack() {
    bullet.addBoxFloor();
    bullet.world->addAction(&action);
    lower = addAwakeBox(bullet, 0.5, 1.0, vec(0, 0.5, 0));
    upper = addAwakeBox(bullet, 0.5, 1.0, vec(0, 1.5, 0));
    system = std::make_unique<SoftBodySystem>(*bullet.world);
    SoftBodySettings s = settingsAt({1.02, 0.52, 0});
    s.damping = 10;
    cube = *system->createBody(cubeNetwork(), s);
    bullet.simulate(0.5);
    EXPECT_NEAR(heightOf(*upper), 1.5, 0.01);
  }

  void expectTheStackToStand() {
    bullet.simulate(0.5);
    EXPECT_NEAR(heightOf(*lower), 0.5, 0.01);
    EXPECT_NEAR(heightOf(*upper), 1.5, 0.02);
  }
};

void emptyTickCallback(btDynamicsWorld*, btScalar) {}

TEST(RigidNeighbours, standWhenTheLastSoftBodyGoes) {
  CubeAtAStack scene;
  scene.system->destroyBody(scene.cube);
  scene.expectTheStackToStand();
}

TEST(RigidNeighbours, standWhenTheLastSoftBodyGoesInsideATick) {
  CubeAtAStack scene;
  scene.action.act = [&] { scene.system->destroyBody(scene.cube); };
  scene.expectTheStackToStand();
}

TEST(RigidNeighbours, standWhenTheSystemGoes) {
  CubeAtAStack scene;
  scene.system.reset();
  scene.expectTheStackToStand();
}

TEST(RigidNeighbours, standWhenTheCallbackIsOverwritten) {
  CubeAtAStack scene;
  scene.system->onWarning([](const std::string&) {});
  scene.bullet.world->setInternalTickCallback(emptyTickCallback, nullptr, true);
  scene.expectTheStackToStand();
}

TEST(RigidNeighbours, mayGoInATickBeforeTheSystemHearsOfItsEnd) {
  CubeAtAStack scene;
  auto* hinge = new btHingeConstraint(*scene.upper, vec(0, 0.4, 0), vec(0, 1, 0));
  scene.bullet.world->addConstraint(hinge);
  scene.action.act = [&] {
    scene.bullet.world->removeConstraint(hinge);
    delete hinge;
    for (btRigidBody* box : {scene.lower, scene.upper}) {
      scene.bullet.world->removeRigidBody(box);
      const auto isBox = [&](const auto& body) { return body.get() == box; };
      auto& all = scene.bullet.bodies;
      all.erase(std::find_if(all.begin(), all.end(), isBox));
    }
  };
  scene.bullet.simulate(0.5);
  EXPECT_TRUE(scene.cube->alive());
  EXPECT_EQ(scene.bullet.world->getNumCollisionObjects(), 1 + (kSurface ? 1 : 8));
}

// --- links -------------------------------------------------------------------------------------------------

TEST(RigidNeighbours, ofTwoLinksOneMayGoInTheTickInWhichTheOtherComes) {
  SoftWorld bullet(0.0);
  btRigidBody* first = addAwakeBox(bullet, 0.1, 1.0, vec(0, 0, 0));
  btRigidBody* second = addAwakeBox(bullet, 0.1, 1.0, vec(0, 0, 2));
  SpringSettings s;
  s.restLength = 0.5;
  s.stiffness = 10;
  ASSERT_TRUE(bullet.system.addSpring({first}, {nullptr, vec(1, 0, 0)}, s));
  ASSERT_TRUE(bullet.system.addSpring({second}, {nullptr, vec(1, 0, 2)}, s));
  bullet.world->removeRigidBody(second);
  bullet.tick();
  bullet.world->removeRigidBody(first);
  bullet.world->addRigidBody(second);
  const btVector3 left = first->getLinearVelocity();
  bullet.simulate(0.1);
  EXPECT_GT(double(second->getLinearVelocity().x()), 0.1) << "its spring pulls";
  EXPECT_EQ((first->getLinearVelocity() - left).length2(), 0) << "it is in no world";
}

TEST(RigidNeighbours, areJoinedByTheirLinksWhenTheyBecomeFree) {
  // two springs are attached to a body that is static at first; when it becomes dynamic, it connects them
  SoftWorld bullet(0.0);
  btRigidBody* middle = bullet.addBox(vec(0.1, 0.1, 0.1), 0, vec(0, 0, 0));
  btRigidBody* left = addAwakeBox(bullet, 0.1, 1.0, vec(-1, 0, 0));
  btRigidBody* right = addAwakeBox(bullet, 0.1, 1.0, vec(1, 0, 0));
  SpringSettings s;
  s.restLength = 0.5;
  s.stiffness = 10;
  ASSERT_TRUE(bullet.system.addSpring({left}, {middle}, s));
  ASSERT_TRUE(bullet.system.addSpring({right}, {middle}, s));
  bullet.tick();
  bullet.world->removeRigidBody(middle);
  middle->setMassProps(1.0, vec(0.01, 0.01, 0.01));
  middle->setCollisionFlags(0);
  bullet.world->addRigidBody(middle);
  middle->forceActivationState(DISABLE_DEACTIVATION);
  left->setLinearVelocity(vec(0, 0, 0));
  right->setLinearVelocity(vec(0, 0, 0));
  bullet.simulate(0.2);
  const Eigen::Vector3d sum = eigen(left->getLinearVelocity()) + eigen(middle->getLinearVelocity()) +
                              eigen(right->getLinearVelocity());
  EXPECT_LT(sum.norm(), 1e-6) << "momentum";
  EXPECT_LT(std::abs(heightOf(*middle)), 1e-6);
  EXPECT_NEAR(double(middle->getWorldTransform().getOrigin().x()), 0.0, 1e-6) << "both pull alike";
  EXPECT_GT(double(left->getLinearVelocity().x()), 0.5);
}

// --- contacts ----------------------------------------------------------------------------------------------

/// Returns the speed (m/s) of a point after it has hit the floor at 2 m/s. Optionally a tiny box flies next
/// to it and touches nothing.
double rebound(bool withCrumb) {
  SoftWorld bullet(0.0);
  bullet.addBoxFloor()->setRestitution(1);
  SoftBodySettings s = settingsAt({0, 0.2, 0});
  s.linearVelocity = {0, -2, 0};
  s.restitution = 1;
  s.damping = 0;
  SoftBody* body = bullet.addSoft(pairNetwork(), s);
  if (withCrumb) {
    const double distance = double(body->point(0)->getCollisionShape()->getMargin()) + 0.006;
    const btVector3 position = body->point(0)->getWorldTransform().getOrigin() + vec(0, distance + 0.1, 0);
    addAwakeBox(bullet, 0.1, 1e-3, position)->setLinearVelocity(vec(0, -2, 0));
  }
  double largest = -2;
  for (int i = 0; i < 10 && largest < 0; ++i) {
    bullet.tick();
    largest = std::max(largest, body->velocity(0).y());
  }
  return largest;
}

/// The angular momentum and the rotational energy of a body without forces are constant. Alone, Bullet's box
/// loses a quarter of its energy at 1/60 s in ten seconds.
TEST(RigidNeighbours, thatTumbleOnASpringKeepEnergyAndAngularMomentum) {
  for (const double tick : {1.0 / 240, 1.0 / 60, 1.0 / 30}) {
    SoftWorld bullet;
    bullet.world->setGravity(vec(0, 0, 0));
    btRigidBody* box = bullet.addAwakeBox(vec(0.3, 0.6, 1.0), 3, vec(0, 0, 0));
    box->setAngularVelocity(vec(2, 1, 3));
    SpringSettings weak;
    weak.stiffness = 1e-6;
    ASSERT_TRUE(bullet.system.addSpring({box, vec(0.1, 0, 0)}, {nullptr, vec(3, 0, 0)}, weak));
    const auto momentum = [&] {
      const btMatrix3x3 inertia = box->getInvInertiaTensorWorld().inverse();
      return Eigen::Vector3d(eigen(inertia * box->getAngularVelocity()));
    };
    const Eigen::Vector3d start = momentum();
    const double energy = start.dot(eigen(box->getAngularVelocity()));
    for (double t = 0.0; t < 10.0; t += tick) bullet.world->stepSimulation(btScalar(tick), 0);
    // Bullet turns the body by one mean rotation a tick: an error of (w dt)^2 / 12
    EXPECT_NEAR((momentum() - start).norm() / start.norm(), 0.0, 0.005) << tick;
    EXPECT_NEAR(momentum().dot(eigen(box->getAngularVelocity())) / energy, 1.0, 0.01) << tick;
  }
}

TEST(RigidNeighbours, doNotTakeRestitutionFromWhatHitsTheFloorBesideThem) {
  EXPECT_NEAR(rebound(false), 2.0, 1e-5);
  EXPECT_NEAR(rebound(true), 2.0, 1e-2) << "the crumb of a thousandth of a body may be hit then";
}

/// A box of 10 kg on a plate on a cube. Another cube is farther away, in the same system or in a second one.
struct StackBesideACube {
  BulletWorld bullet;
  SoftBodySystem first{*bullet.world}, second{*bullet.world};
  SoftBody *carrier, *other;
  btRigidBody* box;

  explicit StackBesideACube(bool twoSystems) {
    bullet.addBoxFloor();
    SoftBodySettings s = settingsAt({0, 0.5 + kRadius, 0});
    setSprings(s, 1e4, 10);
    s.pointRadius = kRadius;
    carrier = *first.createBody(fullCubeNetwork(), s);
    s.position.x() = 5;
    other = *(twoSystems ? second : first).createBody(fullCubeNetwork(), s);
    const double top = 1 + 2 * kRadius;
    bullet.addBox(vec(0.7, 0.1, 0.7), 1.0, vec(0, top + 0.1, 0))->setActivationState(DISABLE_DEACTIVATION);
    box = addAwakeBox(bullet, 0.4, 10.0, vec(0, top + 0.6, 0));
    bullet.simulate(4.0);
  }
};

TEST(RigidNeighbours, standAlikeInWorldsOfOneAndOfTwoSystems) {
  const StackBesideACube one(false), two(true);
  EXPECT_NEAR(heightOf(*two.box), heightOf(*one.box), 1e-6) << "rounding";
  for (const SoftBody* body : {two.carrier, two.other}) {
    const std::vector<SoftContact>& contacts = body->contacts();
    for (std::size_t i = 0; i < contacts.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_FALSE(contacts[i].other == contacts[j].other &&
                     contacts[i].side.points == contacts[j].side.points)
            << "told twice";
  }
}

/// As BulletWorld, but with a pool of one manifold, so that sanitizers detect accesses to deleted ones.
struct WorldWithoutPool {
  static btDefaultCollisionConstructionInfo info() {
    btDefaultCollisionConstructionInfo info;
    info.m_defaultMaxPersistentManifoldPoolSize = 1;
    return info;
  }
  btDefaultCollisionConfiguration configuration{info()};
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

/// A tetrahedron 0.6 m high.
struct GImpactTetrahedron {
  btVector3 corners[4] = {vec(-.3, -.3, -.3), vec(.3, -.3, -.3), vec(0, -.3, .3), vec(0, .3, 0)};
  int triangles[12] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
  btTriangleIndexVertexArray mesh{4, triangles,      static_cast<int>(3 * sizeof(int)),
                                  4, &corners[0][0], static_cast<int>(sizeof(btVector3))};
  btGImpactMeshShape shape{&mesh};
  GImpactTetrahedron() { shape.updateBound(); }
};

/// A board of 5 kg on four springs from the world, which are slack while it is higher, and a box of 50 kg
/// `height` (m) above it.
struct BoxAboveBoard {
  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};
  btRigidBody *board, *box;
  std::vector<SpringConstraint*> springs;

  BoxAboveBoard(double slack, double height, double stiffness, double damping) {
    board = bullet.addBox(vec(0.5, 0.02, 0.5), 5.0, vec(0, 0, 0));
    box = bullet.addBox(vec(0.2, 0.1, 0.2), 50.0, vec(0, 0.12 + height, 0));
    for (btRigidBody* body : {board, box}) body->setActivationState(DISABLE_DEACTIVATION);
    SpringSettings s;
    s.restLength = 1.0;
    s.stiffness = stiffness;
    s.damping = damping;
    s.action = SpringAction::ExtensionOnly;
    for (int i = 0; i < 4; ++i) {
      const double x = i % 2 ? 0.45 : -0.45, z = i / 2 ? 0.45 : -0.45;
      springs.push_back(*system.addSpring({board, vec(x, 0, z)}, {nullptr, vec(x, 1.0 - slack, z)}, s));
    }
  }

  double energy() const {
    double sum = 0.0;
    for (const btRigidBody* body : {board, box}) sum += energyOf(*body, 9.81);
    for (const SpringConstraint* spring : springs)
      sum += 0.5 * spring->settings().stiffness * std::pow(std::max(0.0, spring->length() - 1.0), 2);
    return sum;
  }
};

/// Stiff springs turn the board around within a tick, while the box above it goes on.
TEST(RigidNeighbours, onABoardThatSpringsStopGainNoEnergy) {
  for (const double tick : {1.0 / 60.0, 1.0 / 120.0})
    for (const double stiffness : {12500.0, 1e5}) {
      BoxAboveBoard s(0.5, 0.0, stiffness, 5.0);
      const double start = s.energy();
      for (double time = 0.0; time < 0.9; time += tick) {
        s.bullet.tick(tick);
        // of 270 J of the fall; Bullet lets them fall half a tick too far
        ASSERT_LT(s.energy(), start + 1.0) << stiffness << " " << tick << " at " << time;
        ASSERT_GT(heightOf(*s.box) - heightOf(*s.board), 0.1) << stiffness << " " << tick << " at " << time;
      }
    }
}

/// What falls on the board is thrown back alike at any tick.
TEST(RigidNeighbours, fallingOnABoardOnSpringsReboundAlikeAtAnyTick) {
  for (const double tick : {1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0}) {
    BoxAboveBoard s(-5.0 * 9.81 / 4.0 / 12500.0, 0.5, 12500.0, 50.0);
    const double start = s.energy();
    double lowest = 0.0, rebound = -1.0;
    for (double time = 0.0; time < 0.9; time += tick) {
      s.bullet.tick(tick);
      ASSERT_LT(s.energy(), start + 1.0) << tick << " at " << time;
      const double height = heightOf(*s.box) - 0.12;
      lowest = std::min(lowest, height);
      if (lowest < -0.05) rebound = std::max(rebound, height);
    }
    // 0.26 m converged
    EXPECT_NEAR(rebound, 0.25, 0.03) << tick;
  }
}

/// The floor stops a box within the tick of the hit, and so the end of the rope on it.
TEST(RigidNeighbours, thatHitTheFloorKeepWhatIsAttachedToThem) {
  for (const bool plane : {true, false}) {
    SoftWorld bullet;
    plane ? bullet.addPlaneFloor() : bullet.addBoxFloor();
    btRigidBody* box = bullet.addBox(vec(0.2, 0.2, 0.2), 2.0, vec(0, 2, 0));
    box->setLinearVelocity(vec(0, -7, 0));
    SoftBodySettings s = settingsAt({0, 3.3, 0});
    s.linearVelocity = {0, -7, 0};
    s.totalMass = 0.2;
    SoftBody* rope = bullet.addSoft(chainNetwork(8), s);
    ASSERT_TRUE(bullet.system.attach(rope, 8, *box));
    const btVector3 pivot(0, btScalar(rope->position(8).y() - 2.0), 0);
    for (int i = 0; i < 40; ++i) {
      bullet.tick();
      const Eigen::Vector3d apart = rope->position(8) - eigen(box->getWorldTransform() * pivot);
      // 9 m/s are 0.15 m a tick
      ASSERT_LT(apart.norm(), 0.02) << plane << " tick " << i;
    }
  }
}

/// A plate that a constraint fixes to a kinematic palm, which speeds up, carries a soft cube. The limit of
/// the energy that joints add must not take the work of the palm.
TEST(RigidNeighbours, onAnAcceleratingPalmMoveAsFastAsTheirVelocitySays) {
  constexpr double kAcceleration = 0.5, kMass = 0.5;
  SoftWorld bullet;
  btRigidBody* palm = bullet.addBox(vec(0.02, 0.02, 0.02), 0.0, vec(0, -3, 0));
  makeKinematic(*palm);
  btRigidBody* plate = bullet.addAwakeBox(vec(1, 0.01, 1), 0.2, vec(0, 0, 0));
  btTransform atPlate = btTransform::getIdentity();
  btTransform atPalm(btQuaternion::getIdentity(), vec(0, 3, 0));
  btFixedConstraint grip(*palm, *plate, atPalm, atPlate);
  bullet.world->addConstraint(&grip, true);
  SoftBodySettings s = settingsAt({0, 0.51 + kRadius, 0});
  s.pointRadius = kRadius;
  s.totalMass = kMass;
  s.damping = 5.0;
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), s);
  double height = -3.0, speed = 0.0, last = 0.0, momentum = 0.0;
  for (int i = 0; i < 120; ++i) {
    if (i > 30) speed += kAcceleration * kTick;
    height += speed * kTick;
    palm->setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(0, height, 0)));
    bullet.tick();
    const double moved = heightOf(*plate) - last;
    last = heightOf(*plate);
    // heights of floats at 1 m, and the joint's correction of its error
    EXPECT_NEAR(double(plate->getLinearVelocity().y()), moved / kTick, 1e-4) << i;
    if (i >= 60) momentum += cube->linearMomentum().y();
  }
  // the mean of the last second
  EXPECT_NEAR(momentum / 60.0, kMass * kAcceleration * 1.0, 0.01);
  bullet.world->removeConstraint(&grip);
}

/// Bullet finds one corner of a box on a plane in a tick, so at first the others sink in and must be pushed
/// out, as slowly as Bullet would.
TEST(RigidNeighbours, madeOnAPlaneUnderASoftBodyStayThere) {
  for (const double stiffness : {1e3, 1e6})
    for (const double half : {1.0, 5.0}) {
      SoftWorld bullet;
      bullet.addPlaneFloor();
      btRigidBody* plank = bullet.addBox(vec(half, 0.1, half), 50.0, vec(0, 0.1, 0));
      SoftBodySettings s = settingsAt({0, 0.7 + kRadius, 0});
      s.pointRadius = kRadius;
      setSprings(s, stiffness, 0.02 * std::sqrt(stiffness));
      ASSERT_TRUE(bullet.system.createBody(closedCubeNetwork(), s));
      double highest = 0.0;
      for (int i = 0; i < 120; ++i) {
        bullet.tick();
        highest = std::max(highest, heightOf(*plank));
      }
      EXPECT_LT(highest, 0.1 + 1e-4) << stiffness << " " << half;
    }
}

TEST(RigidNeighbours, ofGImpactShapesMayCarrySoftBodies) {
  // the collision algorithm of GImpact shapes frees the manifold at each of its calls
  WorldWithoutPool bullet;
  bullet.world.setGravity(vec(0, -9.81, 0));
  btGImpactCollisionAlgorithm::registerAlgorithm(&bullet.dispatcher);
  btBoxShape ground(vec(10, 1, 10));
  btRigidBody floor(0, nullptr, &ground, btVector3(0, 0, 0));
  floor.setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(0, -1, 0)));
  bullet.world.addRigidBody(&floor);
  btBoxShape brick(vec(0.2, 0.2, 0.2));
  btRigidBody first(1, nullptr, &brick, vec(0.1, 0.1, 0.1));
  first.setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(5, 0.2, 0)));
  bullet.world.addRigidBody(&first);
  bullet.world.stepSimulation(btScalar(kTick), 0);
  GImpactTetrahedron tetrahedron;
  btVector3 inertia;
  tetrahedron.shape.calculateLocalInertia(1, inertia);
  btRigidBody rigid(1, nullptr, &tetrahedron.shape, inertia);
  rigid.setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(0, 0.3, 0)));
  bullet.world.addRigidBody(&rigid);
  {
    SoftBodySystem system(bullet.world);
    SoftBodySettings s = settingsAt({0, 1.2, 0});
    s.collisionMask = 0;
    SoftBody* cube = *system.createBody(cubeNetwork(), s);
    ASSERT_TRUE(system.attach(cube, 0, rigid));
    for (int i = 0; i < 60; ++i) bullet.world.stepSimulation(btScalar(kTick), 0);
    EXPECT_GT(heightOf(rigid), 0.05) << "on the floor, upright or not";
  }
  for (btRigidBody* body : {&rigid, &first, &floor}) bullet.world.removeRigidBody(body);
}

}  // namespace
}  // namespace limber::test
