// SPDX-License-Identifier: Zlib
// The same build and input give the same bits: in every tick, and on several threads, where each task runs
// once, without allocation, with any parallel function.
#include "support/allocation_counter.h"
#include "support/soft_world.h"
#include "support/variants.h"

#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <LinearMath/btThreads.h>

#include <atomic>
#include <cfenv>
#include <chrono>
#include <cinttypes>
#include <mutex>
#include <set>
#include <thread>

namespace limber::test {
namespace {

// --- the pool ----------------------------------------------------------------------------------------------

TEST(ThreadPool, runsEachTaskOnce) {
  for (const unsigned threads : {1u, 2u, 3u, 8u}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (const std::size_t count : {0u, 1u, 2u, 7u, 64u, 1000u}) {
      std::vector<std::atomic<int>> calls(count);
      for (int round = 0; round < 20; ++round) pool.run(count, [&](std::size_t i) { ++calls[i]; });
      for (const std::atomic<int>& n : calls) EXPECT_EQ(n, 20);
    }
  }
}

TEST(ThreadPool, sleepingThreadsTakePartAgain) {
  ThreadPool pool(2);
  std::atomic<int> arrived{0};
  for (int round = 1; round <= 3; ++round) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    // each task waits for the other: both threads are needed
    pool.run(2, [&](std::size_t) {
      ++arrived;
      while (arrived < 2 * round) std::this_thread::yield();
    });
    EXPECT_EQ(arrived, 2 * round);
  }
}

TEST(ThreadPool, runsTasksOfTasksAndOfOtherThreads) {
  ThreadPool pool(2);
  std::atomic<int> calls{0};
  pool.run(10, [&](std::size_t) { pool.run(10, [&](std::size_t) { ++calls; }); });
  EXPECT_EQ(calls, 100);
  std::thread other([&] {
    for (int i = 0; i < 1000; ++i) pool.run(3, [&](std::size_t) { ++calls; });
  });
  for (int i = 0; i < 1000; ++i) pool.run(3, [&](std::size_t) { ++calls; });
  other.join();
  EXPECT_EQ(calls, 6100);
}

TEST(ThreadPool, worksAfterATaskHasThrown) {
  ThreadPool pool(2);
  const std::thread::id self = std::this_thread::get_id();
  std::atomic<bool> thrown{false};
  // the other thread waits, or it might do all tasks
  const auto throwsHere = [&](std::size_t) {
    if (std::this_thread::get_id() == self) {
      thrown = true;
      throw 1;
    }
    while (!thrown) std::this_thread::yield();
  };
  EXPECT_THROW(pool.run(1000, throwsHere), int);
  std::set<std::thread::id> seen;
  std::mutex mutex;
  std::atomic<int> arrived{0};
  pool.run(2, [&](std::size_t) {
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
    const std::lock_guard<std::mutex> lock(mutex);
    seen.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(seen.size(), 2u);
}

TEST(ThreadPool, hasAsManyThreadsAsTheMachine) {
  EXPECT_EQ(ThreadPool().threads(), std::max(1u, std::thread::hardware_concurrency()));
}

// --- worlds ------------------------------------------------------------------------------------------------

/// Cubes in the air and at rest, in contact with each other, on static, kinematic and dynamic objects of all
/// kinds of shapes, joined, fast, with tolerances, budgets and implicit steppers.
struct Fair {
  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};
  btRigidBody* mover = nullptr;

  Fair() {
    bullet.addBoxFloor();
    for (int i = 0; i < 60; ++i) addCube(i);
    addPile();
    addRigids();
    addLinked();
    addCloth();
  }

  void addCube(int i) {
    SoftBodySettings s = settingsAt({1.4 * (i % 10), 1.0 + 0.37 * (i % 7), 1.4 * (i / 10)});
    s.angularVelocity = {0.3 * i, 1.0, 0.0};
    if (i % 9 == 0) s.linearVelocity = {0, -20, 0};
    if (i % 11 == 0) s.extensionStiffness = s.compressionStiffness = 300;
    if (i % 13 == 0) s.stepping.relativeTolerance = 1e-4;
    if (i % 17 == 0) s.stepping.stepper = Stepper::ImplicitMidpoint;
    if (i % 5 == 1) s.stepping.maxSubsteps = 2;
    (void)*system.createBody(i % 3 ? closedCubeNetwork() : cubeNetwork(), s);
  }

  void addPile() {
    for (int i = 0; i < 12; ++i)
      (void)*system.createBody(closedCubeNetwork(), settingsAt({-3 + 0.1 * (i % 2), 0.6 + 1.05 * i, 0}));
  }

  /// A body that several threads step together. Without it there would be too little to do for several.
  void addCloth() {
    SoftBodySettings s = settingsAt({-14, 3, 0});
    s.extensionStiffness = s.compressionStiffness = 100;
    (*system.createBody(squareCloth(24), s))->pin(0);
  }

  void addRigids() {
    for (int i = 0; i < 8; ++i) bullet.addBox(vec(0.2, 0.2, 0.2), 0.5, vec(1.4 * i, 4, 0));
    bullet.add(std::make_unique<btSphereShape>(btScalar(0.8)), 0, vec(2, 0, 2));
    bullet.add(std::make_unique<btCylinderShape>(vec(0.5, 0.5, 0.5)), 0, vec(5, 0, 4));
    auto hull = std::make_unique<btConvexHullShape>();
    for (int i = 0; i < 8; ++i)
      hull->addPoint(vec(i & 1 ? 0.5 : -0.4, i & 2 ? 0.3 : -0.3, i & 4 ? 0.6 : -0.5));
    bullet.add(std::move(hull), 0, vec(8, 0.3, 5));
    addSharedMesh();
    mover = bullet.add(std::make_unique<btCapsuleShape>(btScalar(0.3), btScalar(6)), 0, vec(-1, 0.4, 3));
    makeKinematic(*mover);
  }

  /// Bullet counts the readers of such a mesh; several cubes fall on it.
  void addSharedMesh() {
    auto mesh = std::make_unique<btTriangleMesh>();
    for (int i = 0; i < 14; ++i) mesh->addTriangle(vec(i, 0.05, 6), vec(i, 0.1, 9), vec(i + 1, 0.1, 6));
    auto shape = std::make_unique<btGImpactMeshShape>(mesh.get());
    shape->updateBound();
    bullet.meshes.push_back(std::move(mesh));
    bullet.add(std::move(shape), 0, vec(0, 0, 0));
  }

  void addLinked() {
    SoftBody* a = *system.createBody(cubeNetwork(), settingsAt({-6, 3, 0}));
    SoftBody* b = *system.createBody(chainNetwork(12), settingsAt({-6, 5, 2}));
    b->pin(0);
    (void)*system.addSpring({a->point(1)}, {b->point(12)});
    btRigidBody* box = bullet.addBox(vec(0.2, 0.2, 0.2), 0.5, vec(-7, 2, 0));
    (void)system.attach(a, 3, *box);
  }

  void tick() {
    btTransform pose = mover->getWorldTransform();
    pose.setOrigin(pose.getOrigin() + vec(0.05, 0, 0));
    mover->setWorldTransform(pose);
    bullet.tick();
  }

  std::uint64_t hash() const {
    std::uint64_t h = 0;
    for (std::size_t i = 0; i < system.bodyCount(); ++i) {
      h = h * 31 + system.body(i)->stateHash();
      h = h * 31 + system.body(i)->contacts().size();
    }
    return h;
  }
};

std::vector<std::uint64_t> hashesOf(Fair& fair, int ticks) {
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < ticks; ++i) {
    fair.tick();
    hashes.push_back(fair.hash());
  }
  return hashes;
}

constexpr int kFairTicks = 30;

/// Returns the hashes on one thread.
const std::vector<std::uint64_t>& expectedHashes() {
  static const std::vector<std::uint64_t> hashes = [] {
    Fair alone;
    return hashesOf(alone, kFairTicks);
  }();
  return hashes;
}

TEST(ParallelTick, givesTheSameBitsOnAnyNumberOfThreads) {
  for (const unsigned threads : variants({3u}, {1u})) {
    Fair fair;
    ThreadPool pool(threads);
    fair.system.setParallelFor(pool.parallelFor(), 0);
    EXPECT_EQ(hashesOf(fair, kFairTicks), expectedHashes()) << threads << " threads";
  }
}

TEST(ParallelTick, takesTasksInAnyOrder) {
  Fair fair;
  std::size_t tasks = 0;
  fair.system.setParallelFor([&](std::size_t count, const std::function<void(std::size_t)>& task) {
    for (std::size_t i = count; i-- > 0;) task(i);
    tasks += count;
  });
  EXPECT_EQ(hashesOf(fair, kFairTicks), expectedHashes());
  EXPECT_GT(tasks, std::size_t{kFairTicks} * 100);
}

/// Bodies that all threads step together: a cloth over a ball, a cloth with boxes on it, and a pile.
enum class Together { Cloth, ClothWithBoxes, Pile };

struct TogetherScene {
  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};

  explicit TogetherScene(Together kind) {
    bullet.addBoxFloor();
    if (kind == Together::Pile)
      addPile();
    else
      addCloth(kind == Together::ClothWithBoxes);
  }

  void addCloth(bool withBoxes) {
    SoftBody* body = *system.createBody(squareCloth(24), settingsAt({0, 1.15, 0}));
    body->pin(0);
    bullet.add(std::make_unique<btSphereShape>(btScalar(0.4)), 0, vec(0, 0.7, 0));
    for (int i = 0; withBoxes && i < 3; ++i)
      bullet.addBox(vec(0.1, 0.05, 0.1), 0.05, vec(0.25 * (i - 1), 1.35 + 0.1 * i, 0.1));
  }

  /// Its cubes touch on all sides: about a thousand contacts, which the threads solve in slabs.
  void addPile() {
    for (int i = 0; i < 150; ++i) {
      SoftBodySettings s = settingsAt({1.035 * (i % 5), 0.53 + 1.035 * (i / 25), 1.035 * (i / 5 % 5)});
      (void)*system.createBody(closedCubeNetwork(), s);
    }
  }

  std::uint64_t hash() const {
    std::uint64_t h = stateHashOf(system);
    for (const auto& object : bullet.bodies) h = h * 31 + std::hash<double>()(heightOf(*object));
    return h;
  }
};

TEST(ParallelTick, largeBodiesAndPilesHaveTheSameBitsOnAnyNumberOfThreads) {
  for (const Together kind : {Together::Cloth, Together::ClothWithBoxes, Together::Pile}) {
    std::vector<std::uint64_t> expected;
    for (const unsigned threads : variants({0u, 3u}, {2u})) {
      SCOPED_TRACE(testing::Message() << "scene " << int(kind) << ", threads " << threads);
      TogetherScene scene(kind);
      ThreadPool pool(std::max(threads, 1u));
      if (threads > 0) scene.system.setParallelFor(pool.parallelFor(), 0);
      std::vector<std::uint64_t> hashes;
      for (int i = 0; i < (kind == Together::Pile ? 5 : 30); ++i) {
        scene.bullet.tick();
        hashes.push_back(scene.hash());
      }
      if (threads == 0) expected = hashes;
      ASSERT_EQ(hashes, expected);
    }
  }
}

TEST(ParallelTick, canBeSwitchedBetweenTicks) {
  Fair fair;
  ThreadPool pool(3);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < kFairTicks; ++i) {
    fair.system.setParallelFor(i % 2 ? pool.parallelFor() : nullptr, 0);
    fair.tick();
    hashes.push_back(fair.hash());
  }
  EXPECT_EQ(hashes, expectedHashes());
}

TEST(ParallelTick, holdsForAllSystemsOfTheWorld) {
  Fair fair;
  SoftBodySystem other(*fair.bullet.world);
  std::size_t calls = 0;
  other.setParallelFor([&](std::size_t count, const std::function<void(std::size_t)>& task) {
    ++calls;
    for (std::size_t i = 0; i < count; ++i) task(i);
  });
  fair.tick();
  EXPECT_GT(calls, 0u);
}

TEST(ParallelTick, leavesTheThreadsAloneInSmallWorlds) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  int calls = 0;
  bullet.system.setParallelFor([&](std::size_t count, const std::function<void(std::size_t)>& task) {
    ++calls;
    for (std::size_t i = 0; i < count; ++i) task(i);
  });
  const auto add = [&](int first, int end) {
    for (int i = first; i < end; ++i) {
      (void)bullet.addSoft(closedCubeNetwork(), settingsAt({1.5 * (i % 20), 1.0, 1.5 * (i / 20)}));
    }
  };
  add(0, 20);
  for (int i = 0; i < 5; ++i) bullet.tick();
  EXPECT_EQ(calls, 0);
  add(20, 320);
  bullet.tick();
  EXPECT_GT(calls, 0);
}

TEST(ParallelTick, allocatesNothingAfterWarmUp) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  ThreadPool pool(2);
  bullet.system.setParallelFor(pool.parallelFor());
  const auto add = [&](const SharedNetwork& network, double x) {
    SoftBody* body = bullet.addSoft(network, settingsAt({x, 1.0, 0}));
    body->point(0)->setActivationState(DISABLE_DEACTIVATION);
  };
  for (int i = 0; i < 12; ++i) add(cubeNetwork(), 1.5 * i);
  add(squareCloth(24), -3.0);
  bullet.simulate(3.0);
  // both threads must have had each kind of work once, and no one knows when
  std::size_t allocations = 1;
  for (int second = 0; second < 20 && allocations > 0; ++second) {
    allocations = allocationsIn([&] { bullet.simulate(1.0); });
  }
  EXPECT_EQ(allocations, 0u);
}

TEST(ParallelTick, takesOverRoundingAndDenormalNumbers) {
  ThreadPool pool(3);
  std::fenv_t usual;
  std::fegetenv(&usual);
  std::fesetround(FE_TOWARDZERO);
  Fair alone, fair;
  fair.system.setParallelFor(pool.parallelFor(), 0);
  EXPECT_EQ(hashesOf(fair, 30), hashesOf(alone, 30));
  std::fesetenv(&usual);
}

TEST(ParallelTick, theFunctionMayReplaceItself) {
  Fair fair;
  int calls = 0;
  fair.system.setParallelFor([&](std::size_t count, const std::function<void(std::size_t)>& task) {
    fair.system.setParallelFor(nullptr);
    for (std::size_t i = 0; i < count; ++i) task(i);
    ++calls;
  });
  EXPECT_EQ(hashesOf(fair, kFairTicks), expectedHashes());
  EXPECT_EQ(calls, 1);
}

// --- Bullet's schedulers -----------------------------------------------------------------------------------

/// A scheduler as a user may have one, on the threads of a pool.
struct Scheduler final : btITaskScheduler {
  Scheduler() : btITaskScheduler("test") {}
  ThreadPool pool{3};
  int calls = 0;

  int getMaxNumThreads() const override { return 3; }
  int getNumThreads() const override { return 3; }
  void setNumThreads(int) override {}
  void parallelFor(int begin, int end, int, const btIParallelForBody& body) override {
    ++calls;
    pool.run(static_cast<std::size_t>(end - begin), [&](std::size_t i) {
      const int at = begin + static_cast<int>(i);
      body.forLoop(at, at + 1);
    });
  }
  btScalar parallelSum(int begin, int end, int, const btIParallelSumBody& body) override {
    return body.sumLoop(begin, end);
  }
};

TEST(ParallelTick, runsOnBulletsSchedulers) {
  Fair sequential, own;
  Scheduler scheduler;
  sequential.system.setParallelFor(parallelForOf(*btGetSequentialTaskScheduler()));
  own.system.setParallelFor(parallelForOf(scheduler));
  EXPECT_EQ(hashesOf(sequential, kFairTicks), expectedHashes());
  EXPECT_EQ(hashesOf(own, kFairTicks), expectedHashes());
  EXPECT_GT(scheduler.calls, kFairTicks);
}

// --- two worlds --------------------------------------------------------------------------------------------

/// Six cubes tumbling onto a box floor, two of them joined by a spring, one dragging a rigid box.
struct Tumble : SoftWorld {
  Tumble() {
    addBoxFloor();
    for (int i = 0; i < 6; ++i) {
      SoftBodySettings s = settingsAt({1.3 * i, 1.5 + 0.3 * i, 0.2 * i});
      s.rotation = Eigen::Quaterniond(0.5, 0.5, i % 2 ? 0.5 : -0.5, 0.5);
      s.angularVelocity = {1.0 * i, 0.5, -1.0};
      addSoft(cubeNetwork(), s);
    }
    btRigidBody* box = addBox(vec(0.3, 0.3, 0.3), 0.5, vec(2.6, 4, 0));
    EXPECT_TRUE(system.addSpring({system.body(0)->point(1)}, {system.body(1)->point(2)}));
    EXPECT_TRUE(system.attach(system.body(2), 3, *box));
  }
};

TEST(Determinism, twoWorldsAgreeBitForBitEveryTick) {
  Tumble a, b;
  for (int i = 0; i < 300; ++i) {
    a.tick();
    b.tick();
    ASSERT_EQ(stateHashOf(a.system), stateHashOf(b.system)) << "tick " << i;
  }
}

TEST(Determinism, springsAloneGiveTheGoldenHash) {
  // Without contacts only the plugin's arithmetic and Bullet's transfer of velocities take part. The bits are
  // therefore the same on every x86-64 machine and in every build type. A change of the hash is a change of
  // the physics and needs an explanation.
  SoftWorld bullet;
  SoftBodySettings s = testedSettings();
  s.rotation = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5);
  s.angularVelocity = {1.0, 0.5, -1.0};
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  body->pin(3);
  bullet.simulate(5.0);
#ifdef BT_USE_DOUBLE_PRECISION
  const std::uint64_t golden = 0x623feb9d3aaba068;
#else
  const std::uint64_t golden = 0xdf3a2497735f2b1e;
#endif
  EXPECT_EQ(body->stateHash(), golden) << "new hash: 0x" << std::hex << body->stateHash();
}

}  // namespace
}  // namespace limber::test
