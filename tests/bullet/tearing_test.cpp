// SPDX-License-Identifier: Zlib
// Bodies are cut and tear. Whatever happens, mass, momentum, area and volume stay.
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace limber::test::tearing {
namespace {

using Eigen::Vector3d;

/// What a cut must not change.
struct Totals {
  double mass, area, volume, energy;
  Vector3d momentum;
  std::size_t triangles, drawn, tetrahedra;
};

double areaOf(const SpringNetwork& n) {
  double sum = 0.0;
  for (const Triangle& t : n.surface)
    sum +=
        0.5 * (n.restPoints[t[1]] - n.restPoints[t[0]]).cross(n.restPoints[t[2]] - n.restPoints[t[0]]).norm();
  return sum;
}

double volumeOf(const SpringNetwork& n) {
  double sum = 0.0;
  for (const Tetrahedron& t : n.tetrahedra)
    sum +=
        (n.restPoints[t[1]] - n.restPoints[t[0]])
            .dot((n.restPoints[t[2]] - n.restPoints[t[0]]).cross(n.restPoints[t[3]] - n.restPoints[t[0]])) /
        6.0;
  return sum;
}

Totals totalsOf(const SoftBody& body) {
  const SpringNetwork& n = body.network();
  return {body.totalMass(),
          areaOf(n),
          volumeOf(n),
          body.kineticEnergy(),
          body.linearMomentum(),
          n.surface.size(),
          n.render.triangles.size(),
          n.tetrahedra.size()};
}

/// Relative rounding of masses, which Bullet holds as floats.
constexpr double kMassRounding = sizeof(btScalar) == 4 ? 3e-7 : 1e-12;

void expectSame(const Totals& before, const SoftBody& body, const std::string& what) {
  const Totals now = totalsOf(body);
  EXPECT_NEAR(now.mass, before.mass, kMassRounding * before.mass) << what;
  EXPECT_NEAR((now.momentum - before.momentum).norm(), 0.0, kMassRounding * (1.0 + before.momentum.norm()))
      << what;
  EXPECT_NEAR(now.energy, before.energy, 2.0 * kMassRounding * (1.0 + before.energy)) << what;
  EXPECT_EQ(now.tetrahedra, before.tetrahedra) << what;
  EXPECT_NEAR(now.volume, before.volume, 1e-12 * before.volume) << what;
  if (before.tetrahedra == 0) {
    EXPECT_EQ(now.triangles, before.triangles) << what;
    EXPECT_EQ(now.drawn, before.drawn) << what;
    EXPECT_NEAR(now.area, before.area, 1e-12 * before.area) << what;
  }
  const SpringNetwork& n = body.network();
  EXPECT_EQ(validate(n).error(), "") << what;
  EXPECT_NEAR(std::accumulate(n.massFractions.begin(), n.massFractions.end(), 0.0), 1.0, 1e-12) << what;
  EXPECT_EQ(n.restPoints.size(), body.pointCount()) << what;
}

/// Returns the number of pieces that springs hold together. Springs that have become much
/// longer are broken.
std::size_t piecesOf(const SoftBody& body) {
  const SpringNetwork& n = body.network();
  std::vector<std::uint32_t> root(n.restPoints.size());
  std::iota(root.begin(), root.end(), 0u);
  const auto rootOf = [&](std::uint32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const NetworkSpring& s : n.springs) {
    const double rest = (n.restPoints[s.b] - n.restPoints[s.a]).norm();
    if ((body.position(s.b) - body.position(s.a)).norm() < 1.3 * rest) root[rootOf(s.a)] = rootOf(s.b);
  }
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < root.size(); ++i)
    if (root[i] == i) ++count;
  return count;
}

SharedNetwork braced() {
  NetworkSettings s;
  s.braces = BraceRule::TwoRing;
  return *buildNetwork(small_meshes::cube(3), s);
}

SharedNetwork filled() { return solidNetwork(small_meshes::cube(3), 60); }

/// A world without gravity with one body.
struct World : SoftWorld {
  explicit World(const SharedNetwork& network, const SoftBodySettings& s = testedSettings())
      : SoftWorld(0.0), body(addSoft(network, s)) {}
  SoftBody* body;
};

/// Saves the body and loads it in another world of this gravity (m/s^2). Both must move alike for `seconds`.
void expectSameMotionWhenLoaded(World& world, double gravity, double seconds) {
  SoftWorld other(gravity);
  const auto loaded = other.system.loadBodies(world.system.saveBodies());
  ASSERT_TRUE(loaded) << loaded.error();
  EXPECT_EQ((*loaded)[0]->stateHash(), world.body->stateHash());
  world.simulate(seconds);
  other.simulate(seconds);
  EXPECT_EQ((*loaded)[0]->pointCount(), world.body->pointCount());
  EXPECT_EQ((*loaded)[0]->stateHash(), world.body->stateHash());
}

std::uint32_t cut(SoftBody* body, const btVector3& point, const btVector3& normal) {
  const auto result = body->cut(point, normal);
  EXPECT_TRUE(result) << result.error();
  return result ? *result : 0;
}

/// A network and its name, for all kinds.
const std::vector<std::pair<const char*, SharedNetwork (*)()>> kKinds = {
    {"cloth", [] { return squareCloth(8); }},
    {"rope", [] { return ropeNetwork(20); }},
    {"braced", braced},
    {"filled", filled}};

}  // namespace

// --- cuts --------------------------------------------------------------------------------------------------

TEST(Cut, twoHalvesOfEveryKindMoveApart) {
  for (const auto& [name, make] : kKinds) {
    World world(make());
    const double x = world.body->network().kind == NetworkKind::Rope ? 0.51 : 0.01;
    ASSERT_TRUE(world.body->setVelocity(vec(1, 2, 3), vec(0.5, 0, 0)));
    const Totals before = totalsOf(*world.body);
    EXPECT_EQ(piecesOf(*world.body), 1u) << name;
    const std::uint32_t oldCount = world.body->pointCount();
    const std::uint32_t made = cut(world.body, vec(x, 0, 0), vec(1, 0, 0));
    EXPECT_GT(made, 0u) << name;
    EXPECT_EQ(world.body->pointCount(), oldCount + made) << name;
    EXPECT_EQ(world.body->tears().size(), made) << name;
    expectSame(before, *world.body, name);
    EXPECT_EQ(piecesOf(*world.body), 2u) << name;
    // one half is pushed; the other does not notice
    for (std::uint32_t i = 0; i < world.body->pointCount(); ++i)
      if (world.body->network().restPoints[i].x() > x + 0.35) {
        ASSERT_TRUE(world.body->applyImpulse(vec(0.05, 0, 0), i));
      }
    const auto left = [&] {
      double least = 1e9;
      for (std::uint32_t i = 0; i < world.body->pointCount(); ++i)
        least = std::min(least, world.body->position(i).x());
      return least;
    };
    const double start = left();
    world.simulate(1.0);
    EXPECT_NEAR(left() - start, 1.0, 0.3) << name;
  }
}

TEST(Cut, anotherPlaceCutsNothing) {
  World world(squareCloth(8));
  const std::uint64_t hash = world.body->stateHash();
  const SharedNetwork network = world.body->sharedNetwork();
  EXPECT_EQ(cut(world.body, vec(5, 0, 0), vec(1, 0, 0)), 0u);
  EXPECT_EQ(world.body->sharedNetwork(), network);
  EXPECT_EQ(world.body->stateHash(), hash);
  EXPECT_TRUE(world.body->tears().empty());
  EXPECT_FALSE(world.body->cut(vec(0, 0, 0), vec(0, 0, 0)));
  EXPECT_FALSE(world.body->cut(vec(std::nan(""), 0, 0), vec(1, 0, 0)));
  EXPECT_FALSE(world.body->cut({vec(0, 0, 0), vec(0, 0, 0), vec(1, 0, 0), vec(1, 0, 0)}));
}

TEST(Cut, theSamePlaneCutsOnce) {
  for (const auto& [name, make] : kKinds) {
    World world(make());
    const double x = world.body->network().kind == NetworkKind::Rope ? 0.51 : 0.01;
    EXPECT_GT(cut(world.body, vec(x, 0, 0), vec(1, 0, 0)), 0u) << name;
    EXPECT_EQ(cut(world.body, vec(x, 0, 0), vec(1, 0, 0)), 0u) << name;
  }
}

TEST(Cut, aBladeOpensASlit) {
  World world(squareCloth(10));
  const Totals before = totalsOf(*world.body);
  // from the border at x = -0.5 to the middle
  const auto made =
      world.body->cut({vec(-0.6, 1, 0.01), vec(-0.6, -1, 0.01), vec(0.01, -1, 0.01), vec(0.01, 1, 0.01)});
  ASSERT_TRUE(made) << made.error();
  EXPECT_EQ(*made, 5u);
  expectSame(before, *world.body, "slit");
  EXPECT_EQ(piecesOf(*world.body), 1u);
  for (const Tear& tear : world.body->tears()) EXPECT_LT(tear.place.x(), 0.01);
}

TEST(Cut, pinnedAndAttachedPointsStay) {
  World world(squareCloth(4));
  for (std::uint32_t i = 0; i < 5; ++i) ASSERT_TRUE(world.body->pin(i));
  btRigidBody* box = world.addBox(vec(0.1, 0.1, 0.1), 1.0, vec(0, -1, 0.5));
  ASSERT_TRUE(world.system.attach(world.body, 22, *box));
  const Totals before = totalsOf(*world.body);
  cut(world.body, vec(0.01, 0, 0), vec(1, 0, 0));
  expectSame(before, *world.body, "pinned");
  for (const Tear& tear : world.body->tears())
    EXPECT_EQ(world.body->pinned(tear.copy), tear.point < 5) << tear.point;
  world.world->setGravity(vec(0, -9.81, 0));
  world.simulate(1.0);
  EXPECT_TRUE(world.body->position(0).allFinite());
  EXPECT_EQ(world.body->restorations(), 0u);
}

TEST(Cut, aFilledBodyStaysClosedAndGetsFaces) {
  World world(filled());
  const std::size_t triangles = world.body->network().surface.size();
  cut(world.body, vec(0.01, 0, 0), vec(1, 0, 0));
  const SpringNetwork& n = world.body->network();
  EXPECT_GT(n.surface.size(), triangles);
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const Triangle& t : n.surface)
    for (std::size_t c = 0; c < 3; ++c) edges.push_back({t[c], t[(c + 1) % 3]});
  std::sort(edges.begin(), edges.end());
  for (const auto& edge : edges) {
    const std::array<std::uint32_t, 2> back = {edge[1], edge[0]};
    EXPECT_EQ(std::count(edges.begin(), edges.end(), edge), std::count(edges.begin(), edges.end(), back));
  }
  EXPECT_GT(world.body->surfaceMesh().triangles.size(), 100u);
}

TEST(Cut, aPiercedBalloonLosesItsGas) {
  SoftBodySettings s = testedSettings();
  s.pressure = 50.0;
  World world(braced(), s);
  const Totals before = totalsOf(*world.body);
  cut(world.body, vec(0.01, 0, 0), vec(1, 0, 0));
  expectSame(before, *world.body, "balloon");
  EXPECT_EQ(world.body->settings().pressure, 0.0);
  world.simulate(0.5);
}

TEST(Cut, rayTestsFindBothHalves) {
  if (!kSurface) GTEST_SKIP() << "points are found as spheres";
  World world(squareCloth(8));
  cut(world.body, vec(0.01, 0, 0), vec(1, 0, 0));
  ASSERT_TRUE(world.body->applyImpulse(vec(0, 0.1, 0)));
  world.simulate(0.2);
  for (const double x : {-0.3, 0.3}) {
    const btVector3 from = vec(x, 2, 0.1), to = vec(x, -2, 0.1);
    btCollisionWorld::ClosestRayResultCallback hit(from, to);
    world.world->rayTest(from, to, hit);
    EXPECT_TRUE(hit.hasHit()) << x;
  }
}

TEST(Cut, withinATickItIsMadeAtItsEnd) {
  BulletWorld bullet(0.0);
  ActionOnce action;
  bullet.world->addAction(&action);
  SoftBodySystem system(*bullet.world);
  SoftBody* body = *system.createBody(squareCloth(8), testedSettings());
  action.act = [&] { EXPECT_EQ(cut(body, vec(0.01, 0, 0), vec(1, 0, 0)), 0u); };
  const std::uint32_t count = body->pointCount();
  bullet.tick();
  EXPECT_EQ(body->pointCount(), count);
  bullet.tick();
  EXPECT_GT(body->pointCount(), count);
  bullet.world->removeAction(&action);
}

TEST(Cut, savedBodiesAreTheSame) {
  World world(squareCloth(8));
  world.world->setGravity(vec(0, -9.81, 0));
  for (const std::uint32_t i : {0u, 8u}) ASSERT_TRUE(world.body->pin(i));
  world.simulate(0.3);
  cut(world.body, vec(0.01, 0, 0), vec(1, 0, 0.2));
  world.simulate(0.2);
  expectSameMotionWhenLoaded(world, -9.81, 0.3);
}

TEST(Cut, twoHundredRandomCutsKeepEverything) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (const auto& [name, make] : kKinds) {
    World world(make());
    world.world->setGravity(vec(0, -9.81, 0));
    world.addPlaneFloor()->getWorldTransform().setOrigin(vec(0, -1, 0));
    for (int i = 0; i < 50; ++i) {
      const Totals before = totalsOf(*world.body);
      const btVector3 center = world.body->transform().getOrigin();
      const btVector3 place = center + vec(0.4 * number(random), 0.1 * number(random), 0.4 * number(random));
      const btVector3 normal = vec(number(random), number(random), number(random));
      if (i % 2 == 0) {
        cut(world.body, place, normal);
      } else {
        const btVector3 u = vec(number(random), number(random), number(random));
        const btVector3 v = vec(number(random), number(random), number(random));
        EXPECT_TRUE(world.body->cut({place, place + u, place + u + v, place + v}));
      }
      expectSame(before, *world.body, name + std::to_string(i));
      world.tick();
      world.tick();
      for (std::uint32_t p = 0; p < world.body->pointCount(); ++p)
        ASSERT_TRUE(world.body->position(p).allFinite()) << name << i;
      ASSERT_EQ(world.body->restorations(), 0u) << name << i;
    }
    EXPECT_GT(piecesOf(*world.body), 4u) << name;
  }
}

// --- tears -------------------------------------------------------------------------------------------------

namespace {

SoftBodySettings tearing(double strain = 0.2) {
  SoftBodySettings s = testedSettings();
  s.elasticLimit.breakStrain = strain;
  s.elasticLimit.tear = true;
  return s;
}

/// Pins both ends of a body along x and pulls them apart at 1 m/s. Returns the number of tears.
std::size_t pullApart(World& world, double seconds) {
  std::vector<std::uint32_t> left, right;
  const std::vector<Vector3d> rest = world.body->network().restPoints;
  double low = 1e9, high = -1e9;
  for (const Vector3d& x : rest) low = std::min(low, x.x()), high = std::max(high, x.x());
  for (std::uint32_t i = 0; i < rest.size(); ++i) {
    if (rest[i].x() < low + 1e-6) left.push_back(i);
    if (rest[i].x() > high - 1e-6) right.push_back(i);
  }
  for (const auto* side : {&left, &right})
    for (const std::uint32_t i : *side) EXPECT_TRUE(world.body->pin(i));
  std::size_t tears = 0;
  const double dt = 1.0 / 60.0;
  for (int tick = 0; tick * dt < seconds; ++tick) {
    for (const std::uint32_t i : right) {
      const Vector3d to = rest[i] + Vector3d(tick * dt, 0, 0);
      EXPECT_TRUE(world.body->movePin(i, vec(to.x(), to.y(), to.z())));
    }
    const std::uint32_t before = world.body->pointCount();
    world.tick();
    tears += world.body->tears().size();
    EXPECT_EQ(world.body->pointCount() - before, world.body->tears().size());
    for (const Tear& tear : world.body->tears()) EXPECT_TRUE(tear.place.allFinite());
  }
  return tears;
}

}  // namespace

// braces keep the pieces of hollow bodies together for long
TEST(Tear, everyKindThatIsPulledApartTearsAndMostEndInPieces) {
  for (const auto& [name, make] : kKinds) {
    World world(make(), tearing());
    const Totals before = totalsOf(*world.body);
    const std::size_t tears = pullApart(world, 1.0);
    EXPECT_GT(tears, 0u) << name;
    if (name != std::string("braced")) {
      EXPECT_GT(piecesOf(*world.body), 1u) << name;
    }
    const Totals now = totalsOf(*world.body);
    EXPECT_EQ(now.tetrahedra, before.tetrahedra) << name;
    EXPECT_NEAR(now.volume, before.volume, 1e-12 * before.volume) << name;
    if (before.tetrahedra == 0) {
      EXPECT_NEAR(now.area, before.area, 1e-12 * before.area) << name;
    }
    EXPECT_EQ(validate(world.body->network()).error(), "") << name;
    EXPECT_EQ(world.body->restorations(), 0u) << name;
  }
}

TEST(Tear, aRopeTearsOnceAndKeepsItsSegments) {
  World world(ropeNetwork(20), tearing());
  pullApart(world, 1.0);
  std::size_t segments = 0;
  for (const NetworkSpring& s : world.body->network().springs)
    if (s.kind == SpringKind::Structural) ++segments;
  EXPECT_EQ(segments, 20u);
  EXPECT_LE(piecesOf(*world.body), 3u);
}

/// The springs at the ball break before the springs behind them are stretched.
TEST(Tear, aFastBallGoesThroughPaper) {
  constexpr std::uint32_t kCells = 20;
  for (const double tick : {1.0 / 60.0, 1.0 / 480.0}) {
    SoftWorld bullet(0.0);
    SoftBodySettings s = testedSettings();
    s.totalMass = 0.5;
    setSprings(s, 1000.0, 0.1);
    s.pointRadius = 0.01;
    s.elasticLimit.breakStrain = 0.2;
    s.elasticLimit.tear = true;
    SoftBody* paper = bullet.addSoft(squareCloth(kCells, 2.0), s);
    const std::uint32_t points = paper->pointCount();
    for (std::uint32_t i = 0; i < points; ++i) {
      const std::uint32_t x = i % (kCells + 1), z = i / (kCells + 1);
      if (x % kCells == 0 || z % kCells == 0) paper->pin(i);
    }
    btRigidBody* ball = bullet.add(std::make_unique<btSphereShape>(btScalar(0.1)), 1, vec(0.03, 0.4, 0.05));
    ball->setLinearVelocity(vec(0, -60, 0));
    bullet.simulate(0.3, tick);
    // the half of a metre of it that the ball takes along has 0.05 kg and costs 5 %; in long ticks it
    // stretches
    EXPECT_LT(double(ball->getLinearVelocity().y()), -0.8 * 60.0) << tick;
  }
}

TEST(Tear, nothingTearsBelowTheStrainOrWithoutTheSetting) {
  for (const bool tear : {false, true}) {
    SoftBodySettings s = tearing(5.0);
    s.elasticLimit.tear = tear;
    World world(squareCloth(8), s);
    EXPECT_EQ(pullApart(world, 0.3), 0u);
  }
}

TEST(Tear, aSavedTornBodyGoesOnTheSame) {
  World world(squareCloth(8), tearing());
  pullApart(world, 0.6);
  ASSERT_GT(world.body->pointCount(), 81u);
  expectSameMotionWhenLoaded(world, 0.0, 0.5);
}

TEST(Tear, equalRunsTearEqually) {
  std::vector<std::uint64_t> hashes;
  for (int run = 0; run < 2; ++run) {
    World world(squareCloth(8), tearing());
    pullApart(world, 0.8);
    hashes.push_back(world.body->stateHash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

namespace {

struct Listener final : ContactListener {};

/// Runs tasks on two threads.
void onTwoThreads(std::size_t count, const std::function<void(std::size_t)>& task) {
  std::thread other([&] {
    for (std::size_t i = 1; i < count; i += 2) task(i);
  });
  for (std::size_t i = 0; i < count; i += 2) task(i);
  other.join();
}

/// Bodies of all kinds collide with each other, themselves, a ball and a floor while they are cut and tear.
std::uint64_t hashOfCrowd(bool threads) {
  SoftWorld bullet(-9.81);
  bullet.addPlaneFloor();
  Listener listener;
  bullet.system.setContactListener(&listener);
  if (threads) bullet.system.setParallelFor(onTwoThreads, 0);
  std::vector<SoftBody*> bodies;
  for (const auto& [name, make] : kKinds) {
    SoftBodySettings s = tearing(0.15);
    s.selfCollision = kSurface;
    s.pointRadius = 0.01;
    s.position = Vector3d(0.1 * double(bodies.size()), 0.6 + 0.7 * double(bodies.size()), 0.05);
    bodies.push_back(bullet.addSoft(make(), s));
  }
  bullet.addBox(vec(0.2, 0.2, 0.2), 20.0, vec(0.1, 5, 0));
  btRigidBody* weight = bullet.addBox(vec(0.05, 0.05, 0.05), 1.0, vec(1.5, 3, 0));
  EXPECT_TRUE(
      bullet.system.addSpring({weight, btVector3(0, 0, 0)}, {bodies[0]->point(3), btVector3(0, 0, 0)}));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  std::uint64_t hash = 0;
  for (int tick = 0; tick < 60; ++tick) {
    SoftBody& body = *bodies[static_cast<std::size_t>(tick) % bodies.size()];
    const btVector3 normal = vec(number(random), number(random), number(random));
    if (tick % 6 == 0) cut(&body, body.transform().getOrigin(), normal);
    bullet.tick();
  }
  for (const SoftBody* body : bodies) {
    EXPECT_EQ(body->restorations(), 0u);
    EXPECT_EQ(validate(body->network()).error(), "");
    hash = 31 * hash + body->stateHash();
  }
  return hash;
}

}  // namespace

TEST(Tear, aCrowdIsTheSameOnThreads) { EXPECT_EQ(hashOfCrowd(false), hashOfCrowd(true)); }

}  // namespace limber::test::tearing
