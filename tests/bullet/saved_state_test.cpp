// SPDX-License-Identifier: Zlib
// Saved states continue to the bit: in the same world, in a new one, and through files.
#include "support/soft_world.h"
#include "support/variants.h"

#include <LinearMath/btSerializer.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace limber::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A floor, a static ball, and bodies of all kinds that fall on them and on each other.
struct Scene {
  explicit Scene(bool withBodies = true) : system(*bullet.world) {
    bullet.addBoxFloor();
    bullet.add(std::make_unique<btSphereShape>(btScalar(0.5)), 0.0, vec(3, 0.3, 0));
    if (!withBodies) return;
    const SharedNetwork cube = closedCubeNetwork();
    SoftBodySettings s = settingsAt({0, 0.8, 0});
    s.angularVelocity = {1, 2, 3};
    add(cube, s);
    s = settingsAt({0.3, 2.0, 0.2});
    s.pressure = 50.0;
    add(cube, s);
    add(cube, settingsAt({3, 2.0, 0.1}));
    s = settingsAt({-3, 1.0, 0});
    s.elasticLimit.yieldStrain = 0.01;
    s.elasticLimit.breakStrain = 0.1;
    s.linearVelocity = {0, -8, 0};
    add(cube, s);
    s = settingsAt({-6, 1.0, 0});
    s.extensionStiffness = s.compressionStiffness = 1e6;
    s.stepping.maxSubsteps = 10;
    add(tetrahedralCubeNetwork(), s);
    s = settingsAt({6, 3.0, 0});
    s.extensionStiffness = s.compressionStiffness = 1e7;
    s.stepping.stepper = Stepper::Newton;
    add(*buildRope({2.0, 10, 0.1}), s);
    system.body(5)->pin(0);
    s = settingsAt({0, 4.0, 3});
    s.flow = FlowCoefficients();
    s.elasticLimit.yieldStrain = 0.02;
    s.elasticLimit.breakStrain = 0.2;
    add(*buildCloth({2.0, 2.0, 12, 12, 0.5, 0.1}), s);
    for (const std::uint32_t corner : {0u, 12u}) system.body(6)->pin(corner);
    EXPECT_TRUE(system.setAir({1.2, {1, 0, 0}, gusts({2, 0, 0}, 1.0, 0.5)}));
    // far from contacts, calm from the start
    s = settingsAt({20, 20, 20});
    s.gravityFactor = 0.0;
    add(cube, s);
    SpringSettings spring;
    spring.stiffness = 30.0;
    EXPECT_TRUE(system.addSpring({system.body(0)->point(0)}, {system.body(1)->point(3)}, spring));
  }
  void add(const SharedNetwork& network, const SoftBodySettings& s) {
    const auto body = system.createBody(network, s);
    ASSERT_TRUE(body) << body.error();
  }
  void tick(int i) {
    if (system.bodyCount() > 5) system.body(5)->movePin(0, vec(6 + 0.005 * i, 3, 0));
    bullet.tick();
  }
  std::vector<std::uint64_t> hashes() const {
    std::vector<std::uint64_t> all;
    for (std::size_t i = 0; i < system.bodyCount(); ++i) all.push_back(system.body(i)->stateHash());
    return all;
  }

  BulletWorld bullet;
  SoftBodySystem system;
};

constexpr int kSavedAt = 40, kEnd = 140, kLate = 260;

TEST(SavedState, rollingBackRepeatsTheSameMotion) {
  Scene scene;
  for (int i = 0; i < kSavedAt; ++i) scene.tick(i);
  const Bytes state = scene.system.saveState();
  std::vector<std::vector<std::uint64_t>> first;
  for (int i = kSavedAt; i < kLate; ++i) {
    scene.tick(i);
    first.push_back(scene.hashes());
  }
  EXPECT_TRUE(scene.system.body(7)->sleeping());
  for (int run = 0; run < 2; ++run) {
    const Result<void> restored = scene.system.restoreState(state);
    ASSERT_TRUE(restored) << restored.error();
    for (int i = kSavedAt; i < kLate; ++i) {
      scene.tick(i);
      ASSERT_EQ(scene.hashes(), first[static_cast<std::size_t>(i - kSavedAt)])
          << "tick " << i << ", run " << run;
    }
  }
}

TEST(SavedState, aNewWorldContinues) {
  Scene old, fresh;
  for (int i = 0; i < kSavedAt; ++i) old.tick(i);
  const Bytes state = old.system.saveState();
  ASSERT_TRUE(fresh.system.restoreState(state));
  EXPECT_EQ(fresh.hashes(), old.hashes());
  EXPECT_EQ(fresh.system.saveState(), state);
  for (int i = kSavedAt; i < kEnd; ++i) {
    old.tick(i);
    fresh.tick(i);
    ASSERT_EQ(fresh.hashes(), old.hashes()) << "tick " << i;
  }
}

/// Four bodies that fall onto a plane at random places, beside and onto each other.
struct RandomScene {
  explicit RandomScene(unsigned seed) : system(*bullet.world), random(seed) {
    bullet.addPlaneFloor();
    const SharedNetwork networks[] = {closedCubeNetwork(), *buildCloth({1.5, 1.5, 6, 6}),
                                      *buildRope({2.0, 12})};
    for (int i = 0; i < 4; ++i) {
      const std::size_t kind = seed % 4 < 3 ? seed % 4 : random() % 3;
      SoftBodySettings s = settingsAt({between(-1, 1), between(0.7, 3), between(-1, 1)});
      s.angularVelocity = {between(-3, 3), between(-3, 3), 0};
      setSprings(s, std::pow(10.0, between(1.5, 3.5)), between(0.1, 3));
      s.totalMass = between(0.3, 5);
      if (kind > 0) s.pointRadius = 0.02;
      EXPECT_TRUE(system.createBody(networks[kind], s));
    }
  }
  double between(double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; }
  std::vector<std::uint64_t> continuation(int ticks) {
    std::vector<std::uint64_t> all;
    for (int i = 0; i < ticks; ++i) {
      bullet.tick();
      for (std::size_t k = 0; k < system.bodyCount(); ++k) all.push_back(system.body(k)->stateHash());
    }
    return all;
  }

  BulletWorld bullet;
  SoftBodySystem system;
  std::mt19937 random;
};

// The boxes in Bullet's broadphase have room for some ticks, and its tree depends on how they have moved.
// Neither may decide which bodies are stepped together.
TEST(SavedState, worldsWithAnyPastContinueAlike) {
  for (const unsigned seed : variants({0u, 2u, 4u, 6u}, {1u, 3u, 5u, 7u, 8u})) {
    RandomScene old(seed), fresh(seed), used(seed);
    old.continuation(20 + static_cast<int>(seed * 37 % 70));
    const Bytes state = old.system.saveState();
    const std::vector<std::uint64_t> expected = old.continuation(25);
    ASSERT_TRUE(old.system.restoreState(state));
    EXPECT_EQ(old.continuation(25), expected) << "in place, seed " << seed;
    ASSERT_TRUE(fresh.system.restoreState(state));
    EXPECT_EQ(fresh.continuation(25), expected) << "in a new world, seed " << seed;
    used.continuation(20);
    ASSERT_TRUE(used.system.restoreState(state));
    EXPECT_EQ(used.continuation(25), expected) << "in a world that was stepped, seed " << seed;
  }
}

// A sleeping body has no ticks in which its box in the broadphase could follow it.
TEST(SavedState, whatFallsOnASleepingBodyTouchesItInANewWorld) {
  if (!kSurface) GTEST_SKIP() << "the points of two cubes pass each other";
  const auto add = [](RandomScene& scene) {
    SoftBodySettings s = settingsAt({8, 0.6, 0});
    s.damping = 5.0;
    SoftBody* below = *scene.system.createBody(closedCubeNetwork(), s);
    s.position = {8.2, 25, 0};
    SoftBody* above = *scene.system.createBody(closedCubeNetwork(), s);
    return std::pair(below, above);
  };
  RandomScene old(0), fresh(0);
  SoftBody* below = add(old).first;
  ASSERT_TRUE(add(fresh).first->setVelocity(vec(30, 30, 0), vec(0, 0, 0)));
  fresh.continuation(20);
  int ticks = 0;
  for (; !below->sleeping() && ticks < 600; ++ticks) old.continuation(1);
  ASSERT_TRUE(below->sleeping());
  ASSERT_TRUE(old.system.body(5)->reset(btTransform(btQuaternion::getIdentity(), vec(8.2, 3, 0))));
  const Bytes state = old.system.saveState();
  ASSERT_TRUE(fresh.system.restoreState(state));
  const std::vector<std::uint64_t> expected = old.continuation(90);
  EXPECT_FALSE(below->sleeping());
  EXPECT_EQ(fresh.continuation(90), expected);
}

TEST(SavedState, sleepYieldAndBreaksAreKept) {
  Scene old, fresh;
  for (int i = 0; i < kLate; ++i) old.tick(i);
  ASSERT_TRUE(old.system.body(7)->sleeping());
  ASSERT_TRUE(fresh.system.restoreState(old.system.saveState()));
  for (std::size_t i = 0; i < old.system.bodyCount(); ++i) {
    EXPECT_EQ(fresh.system.body(i)->sleeping(), old.system.body(i)->sleeping()) << i;
    EXPECT_EQ(fresh.system.body(i)->elasticEnergy(), old.system.body(i)->elasticEnergy()) << i;
    EXPECT_EQ(fresh.system.body(i)->softening(), old.system.body(i)->softening()) << i;
  }
  EXPECT_LT(fresh.system.body(4)->softening(), 1.0);
}

/// Returns the contacts of all bodies as text, with the numbers of bodies and objects instead of addresses.
std::string contactsOf(const Scene& scene) {
  std::ostringstream text;
  text.precision(17);
  const btCollisionObjectArray& objects = scene.bullet.world->getCollisionObjectArray();
  const auto write = [&](const btVector3& v) { text << v.x() << ' ' << v.y() << ' ' << v.z() << ' '; };
  for (std::size_t i = 0; i < scene.system.bodyCount(); ++i)
    for (const SoftContact& c : scene.system.body(i)->contacts()) {
      text << i << ' ' << objects.findLinearSearch(const_cast<btCollisionObject*>(c.other)) << ' '
           << (c.otherBody != nullptr) << ' ' << c.side.triangle << ' ' << c.side.weights.transpose() << ' '
           << c.otherSide.triangle << ' ' << c.otherSide.points[0] << ' ';
      for (const btVector3& v : {c.position, c.normal, c.impulse, c.frictionImpulse}) write(v);
      text << c.distance << ' ' << c.normalImpulse << '\n';
    }
  return text.str();
}

TEST(SavedState, contactsAreThoseOfTheSavedTick) {
  Scene old, fresh;
  for (int i = 0; i < kLate; ++i) old.tick(i);
  const Bytes saved = old.system.saveState();
  const std::string expected = contactsOf(old);
  EXPECT_GT(std::count(expected.begin(), expected.end(), '\n'), 5);
  ASSERT_TRUE(fresh.system.restoreState(saved));
  EXPECT_EQ(contactsOf(fresh), expected);
  for (int i = 0; i < 20; ++i) old.tick(kLate + i);
  ASSERT_TRUE(old.system.restoreState(saved));
  EXPECT_EQ(contactsOf(old), expected);
}

TEST(SavedState, hasThePlacesOfSpringEndsInTheWorldAndTheirForces) {
  SoftWorld bullet;
  SoftBody* cube = bullet.addSoft(closedCubeNetwork(), settingsAt({0, 2, 0}));
  SpringConstraint* spring = *bullet.system.addSpring({cube->point(0)}, {nullptr, vec(0, 4, 0)});
  bullet.simulate(0.5);
  const Bytes saved = bullet.system.saveState();
  const double force = spring->force();
  EXPECT_NE(force, 0.0);
  std::vector<std::uint64_t> hashes;
  const auto play = [&](auto visit) {
    for (int i = 0; i < 30; ++i) {
      if (i == 10) {
        EXPECT_TRUE(bullet.system.moveSpring(spring, vec(1, 4, 0)));
      }
      bullet.tick();
      visit(i);
    }
  };
  play([&](int) { hashes.push_back(cube->stateHash()); });
  ASSERT_TRUE(bullet.system.restoreState(saved));
  EXPECT_EQ(spring->endB().pivot, vec(0, 4, 0));
  EXPECT_EQ(spring->force(), force);
  play([&](int i) { EXPECT_EQ(cube->stateHash(), hashes[static_cast<std::size_t>(i)]) << i; });
}

TEST(SavedState, leavesGrabsAlone) {
  SoftWorld bullet(0.0);
  SoftBody* a = bullet.addSoft(closedCubeNetwork(), settingsAt({0, 0, 0}));
  SoftBody* b = bullet.addSoft(closedCubeNetwork(), settingsAt({3, 0, 0}));
  Result<Grab> held = grab(bullet.system, a, 0);
  SpringSettings settings;
  settings.stiffness = 70.0;
  SpringConstraint* spring = *bullet.system.addSpring({a->point(1)}, {b->point(0)}, settings);
  bullet.simulate(0.2);
  const Bytes saved = bullet.system.saveState();
  const double length = *spring->settings().restLength;
  held->release();
  held = grab(bullet.system, a, 7);
  const Result<Grab> another = grab(bullet.system, b, 3);
  bullet.simulate(0.2);
  const Result<void> restored = bullet.system.restoreState(saved);
  ASSERT_TRUE(restored) << restored.error();
  EXPECT_EQ(spring->settings().stiffness, 70.0);
  EXPECT_EQ(*spring->settings().restLength, length);
  EXPECT_TRUE(held->holds());
  EXPECT_TRUE(another->holds());
  // what the grabs hold has moved by less than a millimetre: they hardly pull
  bullet.simulate(0.2);
  EXPECT_LT(a->kineticEnergy() + b->kineticEnergy(), 0.01);
}

TEST(SavedState, ofOneBodyLeavesTheOthersAlone) {
  Scene scene;
  const Bytes start = scene.system.body(2)->saveState();
  const std::vector<std::uint64_t> atStart = scene.hashes();
  for (int i = 0; i < kSavedAt; ++i) scene.tick(i);
  const std::vector<std::uint64_t> later = scene.hashes();
  ASSERT_TRUE(scene.system.body(2)->restoreState(start));
  for (std::size_t i = 0; i < later.size(); ++i)
    EXPECT_EQ(scene.system.body(i)->stateHash(), i == 2 ? atStart[i] : later[i]) << i;
}

TEST(SavedState, changedSettingsAndMassesAreRestored) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(closedCubeNetwork());
  body->point(3)->setMassProps(btScalar(2), btVector3(0, 0, 0));
  body->pin(1);
  SoftBodySettings s = body->settings();
  s.extensionStiffness = 77.0;
  s.friction = 0.25;
  ASSERT_TRUE(body->change(s));
  const double mass = body->totalMass();
  const Bytes state = body->saveState();
  ASSERT_TRUE(body->unpin(1));
  ASSERT_TRUE(body->change(testedSettings()));
  body->point(3)->setMassProps(btScalar(1), btVector3(0, 0, 0));
  ASSERT_TRUE(body->restoreState(state));
  EXPECT_DOUBLE_EQ(body->settings().extensionStiffness, 77.0);
  EXPECT_TRUE(body->pinned(1));
  EXPECT_DOUBLE_EQ(body->totalMass(), mass);
  EXPECT_FLOAT_EQ(float(body->point(0)->getFriction()), 0.25f);
}

/// A point's Bullet body has its forces in Bullet's precision.
TEST(SavedState, forcesOnTheBodyActAlikeAfterItsPointsWereLookedAt) {
  Scene scene;
  scene.bullet.simulate(0.2);
  const Bytes saved = scene.system.saveState();
  const auto hash = [&] {
    SoftBody& body = *scene.system.body(3);
    EXPECT_TRUE(body.applyForce(vec(0.3, 0.7, 0.1)));
    EXPECT_TRUE(body.applyTorque(vec(0.1, 0, 0.3)));
    scene.bullet.tick();
    return body.stateHash();
  };
  const std::uint64_t before = hash();
  scene.system.body(3)->point(0);
  ASSERT_TRUE(scene.system.restoreState(saved));
  EXPECT_EQ(hash(), before);
}

TEST(SavedState, damagedBytesAreRefusedAndChangeNothing) {
  Scene scene;
  for (int i = 0; i < 10; ++i) scene.tick(i);
  SoftBody* body = scene.system.body(3);
  const Bytes state = body->saveState();
  const std::uint64_t hash = body->stateHash();
  for (std::size_t size = 0; size < state.size(); size += 7)
    EXPECT_FALSE(body->restoreState(Bytes(state.begin(), state.begin() + std::ptrdiff_t(size)))) << size;
  for (std::size_t i = 0; i < state.size(); i += 3) {
    Bytes damaged = state;
    damaged[i] ^= 0x40;
    EXPECT_FALSE(body->restoreState(damaged)) << i;
  }
  EXPECT_EQ(body->stateHash(), hash);
  EXPECT_EQ(scene.system.body(4)->restoreState(state).error(),
            "the saved state is of a body of another network");
  EXPECT_EQ(scene.system.restoreState(state).error(),
            "not a saved state of a system: it does not begin with the bytes of one");
  BulletWorld other;
  SoftBodySystem empty(*other.world);
  EXPECT_EQ(empty.restoreState(scene.system.saveState()).error(),
            "the saved state has 8 bodies, the system 0");
}

/// A ball on a cube. The broadphase has the ball where it was before it was put back.
TEST(SavedState, rigidBodiesMayBePutBackBeforeAndAfterIt) {
  const auto addBall = [](BulletWorld& bullet, const btVector3& position) {
    return bullet.add(std::make_unique<btSphereShape>(btScalar(0.3)), 1.0, position);
  };
  BulletWorld old;
  old.addBoxFloor();
  SoftBodySystem system(*old.world);
  SoftBodySettings s = settingsAt({0, 0.6, 0});
  SoftBody* cube = *system.createBody(closedCubeNetwork(), s);
  btRigidBody* ball = addBall(old, btVector3(btScalar(0.1), btScalar(1.6), 0));
  old.simulate(1.0);
  const Bytes state = system.saveState();
  const btTransform pose = ball->getWorldTransform();
  const btVector3 velocity = ball->getLinearVelocity(), spin = ball->getAngularVelocity();
  old.tick();
  for (const bool stateFirst : {true, false}) {
    BulletWorld bullet;
    bullet.addBoxFloor();
    SoftBodySystem restored(*bullet.world);
    s.position = {0, 3, 4};
    SoftBody* copy = *restored.createBody(closedCubeNetwork(), s);
    btRigidBody* other = addBall(bullet, btVector3(5, 5, 5));
    const auto restore = [&] { EXPECT_TRUE(restored.restoreState(state)); };
    if (stateFirst) restore();
    other->setWorldTransform(pose);
    other->setInterpolationWorldTransform(pose);
    other->setLinearVelocity(velocity);
    other->setAngularVelocity(spin);
    if (!stateFirst) restore();
    bullet.tick();
    EXPECT_EQ(copy->stateHash(), cube->stateHash()) << stateFirst;
  }
}

/// A body that is not alive keeps others from being saved as little as from being stepped.
TEST(SavedState, isSavedOfDeadBodiesButNotRestored) {
  auto bullet = std::make_unique<BulletWorld>();
  SoftBodySystem system(*bullet->world);
  SoftBody* body = *system.createBody(cubeNetwork(), testedSettings());
  bullet->tick();
  btRigidBody* point = body->point(2);
  if (point->isInWorld()) bullet->world->removeRigidBody(point);
  delete point;
  ASSERT_FALSE(body->alive());
  const Bytes state = body->saveState();
  EXPECT_FALSE(state.empty());
  EXPECT_FALSE(system.saveState().empty());
  EXPECT_EQ(body->restoreState(state).error(), "the soft body is disabled, see alive()");
  bullet.reset();
  EXPECT_FALSE(body->saveState().empty()) << "the world has gone";
}

TEST(SavedState, aCloneMovesLikeTheOriginal) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.elasticLimit.yieldStrain = 0.05;
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), s);
  ASSERT_TRUE(body->setVelocity(vec(0, 0, 0), vec(3, 0, 0)));
  bullet.simulate(0.2);
  btTransform there = body->transform();
  there.setOrigin(there.getOrigin() + vec(8, 0, 0));
  const auto copy = bullet.system.clone(body, there);
  ASSERT_TRUE(copy) << copy.error();
  bullet.simulate(0.5);
  for (std::uint32_t i = 0; i < body->pointCount(); ++i)
    // the floats of Bullet round more 8 m away
    EXPECT_LT(((*copy)->position(i) - body->position(i) - Eigen::Vector3d(8, 0, 0)).norm(), 1e-5) << i;
  EXPECT_NEAR((*copy)->elasticEnergy(), body->elasticEnergy(), 1e-4 * body->elasticEnergy());
}

TEST(SavedState, aCloneHasNoContactsBeforeItsFirstTick) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), settingsAt({0, 0.53, 0}));
  bullet.simulate(0.5);
  ASSERT_FALSE(body->contacts().empty());
  const auto copy = bullet.system.clone(body, btTransform(btQuaternion::getIdentity(), vec(5, 4, 0)));
  ASSERT_TRUE(copy) << copy.error();
  EXPECT_TRUE((*copy)->contacts().empty());
  EXPECT_FALSE(body->contacts().empty());
}

// --- files -------------------------------------------------------------------------------------------------

/// Bodies without springs between them: these are not part of a file.
void expectEqualContinuation(Scene& old, Scene& loaded) {
  // wind is not part of a file either
  for (Scene* scene : {&old, &loaded}) EXPECT_TRUE(scene->system.setAir({1.2, {1, 0, 0}, {}}));
  ASSERT_EQ(loaded.hashes(), old.hashes());
  for (int i = kSavedAt; i < kEnd; ++i) {
    old.tick(i);
    loaded.tick(i);
    ASSERT_EQ(loaded.hashes(), old.hashes()) << "tick " << i;
  }
}

struct Unlinked : Scene {
  Unlinked() {
    system.forget(*system.body(0)->point(0));
    system.body(2)->setName("on the ball");
  }
};

TEST(SavedBodies, continueInAnotherWorld) {
  Unlinked old;
  Scene loaded(false);
  for (int i = 0; i < kSavedAt; ++i) old.tick(i);
  const auto bodies = loaded.system.loadBodies(old.system.saveBodies());
  ASSERT_TRUE(bodies) << bodies.error();
  ASSERT_EQ(bodies->size(), old.system.bodyCount());
  EXPECT_EQ((*bodies)[2]->name(), "on the ball");
  EXPECT_EQ((*bodies)[0]->sharedNetwork(), (*bodies)[1]->sharedNetwork());
  expectEqualContinuation(old, loaded);
}

TEST(SavedBodies, cutOnesContinueToTheBit) {
  BulletWorld bullet, other;
  SoftBodySystem system(*bullet.world), loaded(*other.world);
  for (BulletWorld* world : {&bullet, &other}) world->addPlaneFloor();
  SoftBody* cube = *system.createBody(tetrahedralCubeNetwork(), settingsAt({0, 0.7, 0}));
  bullet.simulate(0.5);
  const Result<std::uint32_t> points = cube->cut(vec(0, 0, 0), vec(1, 0, 0));
  ASSERT_TRUE(points) << points.error();
  ASSERT_GT(*points, 0u);
  bullet.simulate(0.1);
  const Bytes saved = system.saveBodies();
  const Result<std::vector<SoftBody*>> copies = loaded.loadBodies(saved);
  ASSERT_TRUE(copies) << copies.error();
  for (int i = 0; i < 60; ++i) {
    bullet.tick();
    other.tick();
    ASSERT_EQ(cube->stateHash(), (*copies)[0]->stateHash()) << i;
  }
}

TEST(SavedBodies, areInBulletsFiles) {
  Unlinked old;
  for (int i = 0; i < kSavedAt; ++i) old.tick(i);
  btDefaultSerializer serializer;
  old.bullet.world->serialize(&serializer);
  const std::uint8_t* file = serializer.getBufferPointer();
  const Bytes bytes(file, file + serializer.getCurrentBufferSize());
  Scene loaded(false);
  const auto bodies = loaded.system.loadBodies(bytes);
  ASSERT_TRUE(bodies) << bodies.error();
  ASSERT_EQ(bodies->size(), old.system.bodyCount());
  EXPECT_EQ((*bodies)[2]->name(), "on the ball");
  expectEqualContinuation(old, loaded);
  for (std::size_t size = 12; size < bytes.size(); size += bytes.size() / 50) {
    BulletWorld bullet;
    SoftBodySystem none(*bullet.world);
    const auto cut = none.loadBodies(Bytes(bytes.begin(), bytes.begin() + std::ptrdiff_t(size)));
    EXPECT_EQ(cut.error(), "the .bullet file is damaged: it has no end (a chunk DNA1)") << size;
    EXPECT_EQ(none.bodyCount(), 0u);
  }
}

TEST(SavedBodies, damagedFilesAreRefusedAndCreateNothing) {
  Unlinked old;
  const Bytes bytes = old.system.saveBodies();
  Scene loaded(false);
  for (std::size_t size = 0; size < bytes.size(); size += 977)
    EXPECT_FALSE(loaded.system.loadBodies(Bytes(bytes.begin(), bytes.begin() + std::ptrdiff_t(size))));
  for (std::size_t i = 0; i < bytes.size(); i += 531) {
    Bytes damaged = bytes;
    damaged[i] ^= 1;
    EXPECT_FALSE(loaded.system.loadBodies(damaged)) << i;
  }
  EXPECT_EQ(loaded.system.loadBodies({}).error(), "not a file of soft bodies: it is empty");
  EXPECT_EQ(loaded.system.bodyCount(), 0u);
}

// --- export ------------------------------------------------------------------------------------------------

std::string contentOf(const std::string& file) {
  std::ifstream stream(file);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

std::size_t linesWith(const std::string& text, const std::string& start) {
  std::istringstream stream(text);
  std::size_t count = 0;
  for (std::string line; std::getline(stream, line);) count += line.rfind(start, 0) == 0;
  return count;
}

TEST(Export, writesThePresentSurfaceAndSprings) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), settingsAt({10, 0, 0}));
  const TriangleMesh mesh = body->surfaceMesh();
  ASSERT_EQ(mesh.triangles.size(), 12u);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const std::uint32_t point = body->network().render.vertexToPoint[i];
    EXPECT_LT((mesh.positions[i] - body->position(point)).norm(), 1e-6);
    // outward at a corner of a cube: along its diagonal, as far as the triangles around it are balanced
    EXPECT_GT(mesh.normals[i].cast<double>().dot((mesh.positions[i] - body->centerOfMass()).normalized()),
              0.9);
  }
  const std::string base = ::testing::TempDir() + "limber_export_" + (kSurface ? "s" : "p");
  for (const char* ending : {".obj", ".ply"}) {
    ASSERT_TRUE(body->exportMesh(base + ending));
    const std::string text = contentOf(base + ending);
    EXPECT_EQ(linesWith(text, ending == std::string(".obj") ? "f " : "3 "), 12u) << text;
    ASSERT_TRUE(body->exportSprings(base + ending));
  }
  EXPECT_EQ(linesWith(contentOf(base + ".obj"), "l "), body->network().springs.size());
  EXPECT_EQ(linesWith(contentOf(base + ".ply"), "element edge 24"), 1u);
  for (const char* ending : {".obj", ".ply"}) std::remove((base + ending).c_str());
  EXPECT_EQ(body->exportMesh("cube.stl").error(), "cube.stl: the name must end in .obj or .ply");
  SoftBody* rope = bullet.addSoft(*buildRope());
  EXPECT_EQ(rope->exportMesh("rope.obj").error(),
            "rope.obj: the body has no surface; exportSprings() writes ropes");
}

}  // namespace
}  // namespace limber::test
