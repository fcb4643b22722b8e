// SPDX-License-Identifier: Zlib
// Contacts that the user's filter changes or rejects before they act.
#include "support/allocation_counter.h"
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace limber::test {
namespace {

/// A cube of 1 m at a height (m) of its lowest surface.
SoftBody* addFilteredCube(SoftBodySystem& system, double height, double x = 0.0) {
  SoftBodySettings s = settingsAt({x, height + 0.5 + kRadius, 0});
  setSprings(s, 5000, 20);
  s.pointRadius = kRadius;
  return *system.createBody(closedCubeNetwork(), s);
}

double speedOf(const SoftBody& body) { return body.linearMomentum().x() / body.totalMass(); }

enum class Ground { Plane, Box, Triangles, Dynamic, Kinematic };

btRigidBody* addGround(BulletWorld& bullet, Ground ground) {
  if (ground == Ground::Plane) return bullet.addPlaneFloor();
  if (ground == Ground::Triangles) return bullet.addTriangleFloor();
  if (ground == Ground::Box) return bullet.addBoxFloor();
  if (ground == Ground::Dynamic) bullet.addBox(vec(20, 1, 20), 0, vec(0, -3, 0))->setFriction(1);
  btRigidBody* box = bullet.addAwakeBox(vec(4, 1, 4), ground == Ground::Dynamic ? 1e6 : 0, vec(0, -1, 0));
  box->setFriction(1);
  if (ground == Ground::Kinematic) box->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  return box;
}

constexpr Ground kGrounds[] = {Ground::Plane, Ground::Box, Ground::Triangles, Ground::Dynamic,
                               Ground::Kinematic};

// --- conveyor belts ----------------------------------------------------------------------------------------

TEST(ContactFilter, aBeltAcceleratesACubeByItsFrictionUpToItsSpeed) {
  constexpr double kFriction = 0.3, kBelt = 1.5;
  for (const Ground ground : kGrounds) {
    SCOPED_TRACE(static_cast<int>(ground));
    SoftWorld bullet;
    btRigidBody* belt = addGround(bullet, ground);
    bullet.system.setContactFilter([&](ContactCandidate& c) {
      if (c.other != belt) return;
      c.friction = kFriction;
      c.surfaceVelocity = vec(kBelt, 0.7, 0);  // the part along the normal does not act
    });
    SoftBody* cube = addFilteredCube(bullet.system, 0.0);
    bullet.simulate(0.3);
    EXPECT_NEAR(speedOf(*cube), kFriction * kGravity * 0.3, 0.04 * kFriction * kGravity * 0.3);
    bullet.simulate(1.0);
    EXPECT_NEAR(speedOf(*cube), kBelt, 0.01 * kBelt);
    EXPECT_NEAR(lowest(*cube), kRadius, 0.01);
  }
}

TEST(ContactFilter, aBallOnATurningDrumIsCarriedAlongItsSurface) {
  SoftWorld bullet;
  btRigidBody* drum = bullet.add(std::make_unique<btCylinderShapeZ>(vec(1, 1, 2)), 0, vec(0, -1, 0));
  bullet.system.setContactFilter([&](ContactCandidate& c) {
    c.friction = 1.0;
    const btVector3 arm = c.position - drum->getWorldTransform().getOrigin();
    c.surfaceVelocity = btVector3(0, 0, 1).cross(arm) * btScalar(-1);
  });
  SoftBodySettings s = settingsAt({0, 0.22, 0});
  setSprings(s, 2000, 10);
  s.scale = {0.2, 0.2, 0.2};
  SoftBody* ball = bullet.addSoft(bracedNetwork(small_meshes::icosphere(1)), s);
  bullet.simulate(0.6);
  EXPECT_GT(ball->centerOfMass().x(), 0.05) << "clockwise: to the right on top";
}

// --- rejected and reported contacts ------------------------------------------------------------------------

TEST(ContactFilter, rejectedContactsNeitherActNorAreReported) {
  for (const Ground ground : kGrounds) {
    SCOPED_TRACE(static_cast<int>(ground));
    SoftWorld bullet;
    addGround(bullet, ground);
    bullet.system.setContactFilter([](ContactCandidate& c) { c.response = ContactResponse::Ignore; });
    SoftBody* cube = addFilteredCube(bullet.system, 0.1);
    const double start = cube->centerOfMass().y();
    for (int i = 0; i < 30; ++i) {
      bullet.tick();
      EXPECT_TRUE(cube->contacts().empty());
    }
    EXPECT_NEAR(cube->centerOfMass().y(), start - 0.5 * kGravity * 0.25, 0.05);
  }
}

TEST(ContactFilter, reportedContactsDoNotAct) {
  for (const Ground ground : kGrounds) {
    SCOPED_TRACE(static_cast<int>(ground));
    SoftWorld bullet;
    btRigidBody* floor = addGround(bullet, ground);
    bullet.system.setContactFilter([](ContactCandidate& c) { c.response = ContactResponse::Report; });
    SoftBody* cube = addFilteredCube(bullet.system, 0.1);
    const double start = cube->centerOfMass().y();
    std::size_t reported = 0;
    for (int i = 0; i < 15; ++i) {
      bullet.tick();
      for (const SoftContact& c : cube->contacts()) {
        EXPECT_EQ(c.other, floor);
        EXPECT_EQ(c.normalImpulse, 0.0);
        EXPECT_LT(c.distance, 0.05 * kRadius);
        ++reported;
      }
    }
    EXPECT_GT(reported, 4u);
    EXPECT_NEAR(cube->centerOfMass().y(), start - 0.5 * kGravity * 0.0625, 0.02);
  }
}

TEST(ContactFilter, softBodiesPassThroughEachOtherAndThemselvesIfTheFilterSaysSo) {
  for (const ContactResponse response : {ContactResponse::Act, ContactResponse::Ignore}) {
    SoftWorld bullet(0.0);
    std::size_t asked = 0;
    bullet.system.setContactFilter([&](ContactCandidate& c) {
      asked += c.otherBody != nullptr;
      c.response = response;
    });
    SoftBody* left = addFilteredCube(bullet.system, 0.0);
    SoftBody* right = addFilteredCube(bullet.system, 0.0, 1.2);
    left->setVelocity(vec(2, 0, 0));
    bullet.simulate(0.5);
    EXPECT_GT(asked, 0u);
    if (response == ContactResponse::Act)
      EXPECT_GT(speedOf(*right), 0.5);
    else
      EXPECT_NEAR(speedOf(*right), 0.0, 1e-6);
  }
}

TEST(ContactFilter, massFactorsSayWhichSideGivesWay) {
  for (const double factor : {1.0, 1e6, 1e-6}) {
    SoftWorld bullet(0.0);
    bullet.system.setContactFilter([&](ContactCandidate& c) {
      c.massFactor = factor > 1 ? factor : 1;
      c.otherMassFactor = factor < 1 ? 1 / factor : 1;
      c.friction = 0;
    });
    btRigidBody* box = bullet.addBox(vec(0.5, 0.5, 0.5), 1.0, vec(1.2, 0, 0));
    box->setLinearVelocity(vec(-1, 0, 0));
    SoftBody* cube = addFilteredCube(bullet.system, -0.5 - kRadius);
    cube->setVelocity(vec(1, 0, 0));
    bullet.simulate(1.0);
    const double theirs = double(box->getLinearVelocity().x()), ours = speedOf(*cube);
    SCOPED_TRACE(factor);
    if (factor == 1.0) {
      EXPECT_NEAR(theirs + ours, 0.0, 1e-3) << "momentum is conserved";
    } else if (factor > 1.0) {
      EXPECT_GE(theirs, ours - 0.05) << "the box gives way";
      EXPECT_GT(ours, 0.9);
    } else {
      EXPECT_LE(ours, theirs + 0.05) << "the cube gives way";
      EXPECT_NEAR(theirs, -1.0, 0.05);
    }
  }
}

TEST(ContactFilter, aSoftBodyCanGiveWayToAnother) {
  SoftWorld bullet(0.0);
  SoftBody* left = addFilteredCube(bullet.system, 0.0);
  SoftBody* right = addFilteredCube(bullet.system, 0.0, 1.2);
  bullet.system.setContactFilter(
      [&](ContactCandidate& c) { (c.body == right ? c.massFactor : c.otherMassFactor) = 1e6; });
  left->setVelocity(vec(2, 0, 0));
  bullet.simulate(0.5);
  EXPECT_NEAR(speedOf(*right), 0.0, 0.01);
  EXPECT_LT(speedOf(*left), 0.1);
}

// Each point would have another mass in each of its contacts, and their solution could grow without limit.
TEST(ContactFilter, massFactorsDoNotMatterWithinABody) {
  std::uint64_t hashes[2];
  for (const bool differ : {false, true}) {
    SoftWorld bullet;
    bullet.addPlaneFloor();
    bullet.system.setContactFilter([&](ContactCandidate& c) {
      if (differ) c.massFactor = 5.0, c.otherMassFactor = 0.2;
    });
    SoftBodySettings s = settingsAt({0, 0.1, 0});
    s.collision = Collision::Surface;
    s.selfCollision = true;
    s.rotation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
    SoftBody* rope = bullet.addSoft(ropeNetwork(30), s);
    std::size_t selfContacts = 0;
    for (int i = 0; i < 90; ++i) {
      bullet.tick();
      for (const SoftContact& c : rope->contacts()) selfContacts += c.otherBody == rope;
    }
    EXPECT_GT(selfContacts, 0u);
    hashes[differ] = rope->stateHash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// --- fast bodies -------------------------------------------------------------------------------------------

TEST(ContactFilter, seesContactsThatAreFoundWithinTheTick) {
  for (const ContactResponse response : {ContactResponse::Act, ContactResponse::Ignore}) {
    SoftWorld bullet(0.0);
    btRigidBody* ball = bullet.add(std::make_unique<btSphereShape>(btScalar(0.2)), 0.3, vec(0.5, 3, 0.5));
    ball->setLinearVelocity(vec(0, -60, 0));
    bullet.system.setContactFilter([&](ContactCandidate& c) { c.response = response; });
    SoftBody* cube = addFilteredCube(bullet.system, -0.9);
    bullet.simulate(0.2);
    if (response == ContactResponse::Act) {
      EXPECT_GT(double(ball->getLinearVelocity().y()), -55.0) << "the cube brakes the ball";
    } else {
      EXPECT_NEAR(double(ball->getLinearVelocity().y()), -60.0, 1e-3);
      EXPECT_NEAR(cube->linearMomentum().norm(), 0.0, 1e-3);
    }
  }
}

// --- one side ----------------------------------------------------------------------------------------------

TEST(ContactFilter, aPlatformHoldsFromAboveOnly) {
  SoftWorld bullet;
  bullet.addBox(vec(3, 0.1, 3), 0, vec(0, 0, 0));
  bullet.system.setContactFilter([](ContactCandidate& c) { c.facing = vec(0, 1, 0); });
  SoftBody* cube = addFilteredCube(bullet.system, -1.5);
  cube->setVelocity(vec(0, 7, 0));
  double highest = -10;
  for (int i = 0; i < 180; ++i) {
    bullet.tick();
    highest = std::max(highest, lowest(*cube));
  }
  EXPECT_GT(highest, 0.5) << "the platform does not stop it from below";
  EXPECT_NEAR(lowest(*cube), 0.1 + kRadius, 0.02) << "it lies on it";
}

TEST(ContactFilter, aClothInsideACharacterLeavesToTheChosenSide) {
  for (const bool kinematic : {false, true}) {
    SCOPED_TRACE(kinematic);
    SoftWorld bullet;
    btRigidBody* character =
        bullet.add(std::make_unique<btCapsuleShape>(btScalar(0.3), btScalar(1.2)), 0, vec(0, 0, 0));
    if (kinematic) {
      makeKinematic(*character);
    }
    bullet.system.setContactFilter([](ContactCandidate& c) { c.facing = vec(0, 0, -1); });
    // a cape that hangs from the shoulders behind the character (-z), blown through it to the front
    SoftBodySettings s = settingsAt({0, 0.127, -0.1});
    s.pointRadius = 0.02;
    s.totalMass = 0.3;
    s.rotation = Eigen::AngleAxisd(0.31 * kPi, Eigen::Vector3d::UnitX());
    setSprings(s, 500, 1);
    s.flow.drag = 1.0;
    SoftBody* cloth = bullet.addSoft(clothNetwork(6, 10, 0.5, 0.9), s);
    for (std::uint32_t i = 0; i <= 6; ++i) cloth->pin(i);
    EXPECT_GT(cloth->position(cloth->pointCount() - 1).z(), 0.1);
    bullet.simulate(4.0);
    double innermost = 1.0;
    for (std::uint32_t i = 0; i < cloth->pointCount(); ++i) {
      const Eigen::Vector3d x = cloth->position(i);
      const double along = std::clamp(x.y(), -0.6, 0.6);
      innermost = std::min(innermost, (x - Eigen::Vector3d(0, along, 0)).norm());
      EXPECT_LT(x.z(), 0.0);
    }
    EXPECT_GT(innermost, 0.3) << "no point is still inside";
  }
}

// --- what a candidate knows --------------------------------------------------------------------------------

TEST(ContactFilter, knowsTheTriangleOfAMesh) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addTriangleFloor();
  std::size_t asked = 0;
  bullet.system.setContactFilter([&](ContactCandidate& c) {
    if (c.distance > 0.05) return;
    TriangleRay ray(c.position + vec(0.001, 1, 0.0007), c.position + vec(0.001, -1, 0.0007));
    const btTransform from(btQuaternion::getIdentity(), ray.m_rayFromWorld),
        to(btQuaternion::getIdentity(), ray.m_rayToWorld);
    btCollisionWorld::rayTestSingle(from, to, floor, floor->getCollisionShape(), floor->getWorldTransform(),
                                    ray);
    ASSERT_TRUE(ray.hasHit());
    EXPECT_EQ(c.otherPart, ray.part);
    EXPECT_EQ(c.otherTriangle, ray.triangle);
    ++asked;
  });
  SoftBody* cube = addFilteredCube(bullet.system, 0.0, 0.05);
  bullet.simulate(0.2);
  EXPECT_GT(asked, 20u);
  EXPECT_NEAR(lowest(*cube), kRadius, 0.01);
}

TEST(ContactFilter, bouncesWithTheRestitutionOfTheFilter) {
  SoftWorld bullet;
  bullet.addPlaneFloor();
  bullet.system.setContactFilter([](ContactCandidate& c) { c.restitution = 1.0; });
  SoftBodySettings s = settingsAt({0, 1.0 + kRadius, 0});
  s.pointRadius = kRadius;
  SoftBody* pair = bullet.addSoft(pairNetwork(), s);
  double highest = 0.0;
  for (int i = 0; i < 54; ++i) {
    bullet.tick();
    if (i > 35) highest = std::max(highest, lowest(*pair));
  }
  EXPECT_NEAR(highest, 1.0 + kRadius, 0.05);
}

TEST(ContactFilter, bulletsCombinedFrictionIsThatOfThePair) {
  const CalculateCombinedCallback before = gCalculateCombinedFrictionCallback;
  gCalculateCombinedFrictionCallback = [](const btCollisionObject* a, const btCollisionObject* b) {
    return (a->getUserIndex2() == 7 || b->getUserIndex2() == 7) ? btScalar(0) : btScalar(1);
  };
  for (const bool slippery : {true, false}) {
    SoftWorld bullet;
    bullet.addPlaneFloor()->setUserIndex2(slippery ? 7 : 1);
    SoftBody* cube = addFilteredCube(bullet.system, 0.0);
    cube->setVelocity(vec(1, 0, 0));
    bullet.simulate(0.5);
    EXPECT_NEAR(speedOf(*cube), slippery ? 1.0 : 0.0, 0.05);
  }
  gCalculateCombinedFrictionCallback = before;
}

// --- cost --------------------------------------------------------------------------------------------------

TEST(ContactFilter, aTickAllocatesNothing) {
  SoftWorld bullet;
  addGround(bullet, Ground::Triangles);
  bullet.addBox(vec(0.3, 0.3, 0.3), 1.0, vec(0, 1.4, 0));
  bullet.system.setContactFilter([](ContactCandidate& c) {
    if (c.otherTriangle >= 0) c.facing = vec(0, 1, 0);
    c.massFactor = 2.0;
    if (c.otherTriangle < 0 && c.side.points[0] == 7) c.response = ContactResponse::Report;
  });
  addFilteredCube(bullet.system, 0.0);
  // arrays of contacts grow until they have held the most that occur
  bullet.simulate(4.0);
  EXPECT_EQ(allocationsIn([&] { bullet.simulate(0.5); }), 0u);
}

// --- determinism -------------------------------------------------------------------------------------------

TEST(ContactFilter, givesTheSameBitsOnAnyNumberOfThreads) {
  std::vector<std::uint64_t> hashes;
  for (const unsigned threads : {1u, 2u}) {
    SoftWorld bullet;
    addGround(bullet, Ground::Triangles);
    ThreadPool pool(threads);
    bullet.system.setParallelFor(pool.parallelFor(), 0);
    bullet.system.setContactFilter([](ContactCandidate& c) {
      c.friction = c.otherTriangle % 2 ? 0.1 : 0.9;
      c.surfaceVelocity = vec(0.5, 0, 0);
    });
    for (int i = 0; i < 6; ++i) addFilteredCube(bullet.system, 0.3 * i, 0.9 * i)->setVelocity(vec(0, -4, 1));
    bullet.simulate(1.0);
    hashes.push_back(stateHashOf(bullet.system));
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(ContactFilter, aFilterThatChangesNothingChangesNoBit) {
  std::vector<std::uint64_t> hashes;
  for (const bool filtered : {false, true}) {
    SoftWorld bullet;
    addGround(bullet, kSurface ? Ground::Dynamic : Ground::Box);
    if (filtered) bullet.system.setContactFilter([](ContactCandidate&) {});
    SoftBody* cube = addFilteredCube(bullet.system, 0.3);
    cube->setVelocity(vec(1, -2, 0), vec(1, 2, 3));
    bullet.simulate(1.0);
    hashes.push_back(cube->stateHash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(ContactFilter, numbersThatAreNotFiniteAreIgnored) {
  constexpr btScalar kNaN = std::numeric_limits<btScalar>::quiet_NaN();
  constexpr btScalar kInfinite = std::numeric_limits<btScalar>::infinity();
  for (const Ground ground : kGrounds)
    for (const btScalar nonsense : {kNaN, kInfinite}) {
      SCOPED_TRACE(static_cast<int>(ground));
      SoftWorld bullet;
      addGround(bullet, ground);
      bullet.system.setContactFilter([&](ContactCandidate& c) {
        c.friction = double(nonsense);
        c.restitution = c.massFactor = c.otherMassFactor = double(nonsense);
        c.surfaceVelocity = c.facing = btVector3(nonsense, nonsense, nonsense);
      });
      SoftBody* cube = addFilteredCube(bullet.system, 0.01);
      bullet.simulate(1.0);
      // an infinite restitution counts as 1
      EXPECT_GT(lowest(*cube), 0.5 * kRadius);
      EXPECT_LT(lowest(*cube), 0.1);
      EXPECT_EQ(cube->restorations(), 0u);
    }
}

}  // namespace
}  // namespace limber::test
