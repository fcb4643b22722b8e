// SPDX-License-Identifier: Zlib
// Physical laws of contacts between moving bodies: soft with rigid, soft with soft.
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace limber::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

SoftBodySettings pairBody(const Vector3d& position, const Vector3d& velocity, double stiffness = 1e3) {
  SoftBodySettings s = settingsAt(position);
  s.linearVelocity = velocity;
  setSprings(s, stiffness, 0.1 * std::sqrt(stiffness));
  return s;
}

/// Returns the momentum of a body of 1 kg.
Vector3d exactMomentumOf(const SoftBody& body) {
  Vector3d sum = Vector3d::Zero();
  for (std::uint32_t i = 0; i < body.pointCount(); ++i)
    sum += body.network().massFractions[i] * body.velocity(i);
  return sum;
}

// --- mirrored bodies ---------------------------------------------------------------------------------------

/// Return the mirror images in the plane x = 0.
Vector3d image(const Vector3d& v) { return {-v.x(), v.y(), v.z()}; }
Quaterniond image(const Quaterniond& q) { return {q.w(), q.x(), -q.y(), -q.z()}; }
SoftBodySettings image(SoftBodySettings s) {
  s.position = image(s.position);
  s.linearVelocity = image(s.linearVelocity);
  s.scale.x() = -s.scale.x();
  s.rotation = image(s.rotation);
  s.angularVelocity = -image(s.angularVelocity);
  return s;
}

/// A scene or its mirror image.
struct MirrorScene {
  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};
  bool mirrored;

  explicit MirrorScene(bool m, double gravity = 0.0) : bullet(gravity), mirrored(m) {}

  SoftBody* add(const SharedNetwork& network, const SoftBodySettings& settings) {
    return *system.createBody(network, mirrored ? image(settings) : settings);
  }
  btRigidBody* add(std::unique_ptr<btCollisionShape> shape, const Vector3d& position,
                   const Quaterniond& rotation, const Vector3d& velocity) {
    const Vector3d x = mirrored ? image(position) : position, v = mirrored ? image(velocity) : velocity;
    const Quaterniond q = mirrored ? image(rotation) : rotation;
    btRigidBody* body = bullet.add(std::move(shape), 1.0, vec(x.x(), x.y(), x.z()));
    btTransform pose = body->getWorldTransform();
    pose.setRotation(btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())));
    body->setCenterOfMassTransform(pose);
    body->setLinearVelocity(vec(v.x(), v.y(), v.z()));
    body->setActivationState(DISABLE_DEACTIVATION);
    return body;
  }
};

/// Returns the largest distance (m) of a point from the mirror image of the same point in the other scene.
double asymmetry(const MirrorScene& scene, const MirrorScene& mirrored) {
  double largest = 0.0;
  for (std::size_t b = 0; b < scene.system.bodyCount(); ++b)
    for (std::uint32_t i = 0; i < scene.system.body(b)->pointCount(); ++i)
      largest = std::max(
          largest, (scene.system.body(b)->position(i) - image(mirrored.system.body(b)->position(i))).norm());
  return largest;
}

using Build = std::function<void(MirrorScene&)>;

double asymmetryAfter(double seconds, double gravity, const Build& build) {
  MirrorScene scene(false, gravity), mirrored(true, gravity);
  build(scene);
  build(mirrored);
  scene.bullet.simulate(seconds);
  mirrored.bullet.simulate(seconds);
  return asymmetry(scene, mirrored);
}

const Quaterniond kTilted = Quaterniond(Eigen::AngleAxisd(0.4, Vector3d(1, 0.6, -0.3).normalized()));

std::unique_ptr<btCollisionShape> wedge() {
  auto hull = std::make_unique<btConvexHullShape>();
  for (const double z : {-0.4, 0.4})
    for (const auto& [x, y] : {std::pair(-0.4, -0.4), {0.4, -0.4}, {0.0, 0.4}}) hull->addPoint(vec(x, y, z));
  hull->setMargin(0);
  return hull;
}

// Bullet stores rigid bodies in floats and the solver stops at 1e-6 m/s: after an impact this makes some 1e-5
// m in half a second. A surface that is inside out makes 1 m.
constexpr double kMirrorTolerance = 1e-4;

TEST(MirroredBodies, mirroredScenesAreMirrorImagesWithRigidBodiesOfEveryShape) {
  using Shape = std::unique_ptr<btCollisionShape>;
  const std::pair<const char*, std::function<Shape()>> shapes[] = {
      {"box", [] { return Shape(new btBoxShape(vec(0.3, 0.4, 0.35))); }},
      {"sphere", [] { return Shape(new btSphereShape(btScalar(0.3))); }},
      {"capsule", [] { return Shape(new btCapsuleShape(btScalar(0.2), btScalar(0.5))); }},
      {"cylinder", [] { return Shape(new btCylinderShape(vec(0.3, 0.4, 0.3))); }},
      {"wedge", wedge}};
  for (const auto& [name, make] : shapes) {
    SCOPED_TRACE(name);
    const auto build = [&, shape = &make](MirrorScene& scene) {
      scene.add(closedCubeNetwork(), pairBody({-1, 0, 0}, {3, 0, 0}));
      scene.add((*shape)(), {0.1, 0.1, 0.05}, kTilted, {0, 0, 0});
    };
    EXPECT_LT(asymmetryAfter(0.6, 0.0, build), kMirrorTolerance);
  }
}

TEST(MirroredBodies, mirroredScenesAreMirrorImagesWithOtherSoftBodies) {
  EXPECT_LT(asymmetryAfter(0.6, 0.0,
                           [](MirrorScene& scene) {
                             scene.add(closedCubeNetwork(), pairBody({-1, 0, 0}, {3, 0, 0}));
                             SoftBodySettings ball = pairBody({0.9, 0.2, 0.1}, {0, 0, 0});
                             ball.scale = {0.5, 0.5, 0.5};
                             scene.add(bracedNetwork(small_meshes::icosphere(1)), ball);
                           }),
            kMirrorTolerance);
}

TEST(MirroredBodies, oneMirroredAxisOrThreeStandAsTheUnmirroredBodyDoes) {
  if (!kSurface) GTEST_SKIP() << "points alone do not bear each other";
  for (const Vector3d& scale : {Vector3d(-1, 1, 1), {1, -1, 1}, {1, 1, -1}, {-1, -1, 1}, {-1, -1, -1}}) {
    SCOPED_TRACE(scale.transpose());
    double heights[2];
    for (const bool mirrored : {false, true}) {
      SoftWorld bullet;
      bullet.addBoxFloor();
      SoftBody* top = nullptr;
      for (const double y : {0.53, 1.57}) {
        SoftBodySettings s = pairBody({0, y, 0}, {0, 0, 0}, 1e4);
        if (mirrored) s.scale = scale;
        s.damping = 20.0;
        top = bullet.addSoft(closedCubeNetwork(), s);
      }
      btRigidBody* box = bullet.addBox(vec(0.3, 0.1, 0.3), 1.0, vec(0, 2.2, 0));
      bullet.simulate(3.0);
      EXPECT_GT(heightOf(*box), 2.0);
      heights[mirrored] = top->centerOfMass().y();
    }
    // friction at the corners makes this difference as the bodies come to rest
    EXPECT_NEAR(heights[0], heights[1], 1e-3);
  }
}

// --- systems that share a world ----------------------------------------------------------------------------

struct HeadOn {
  BulletWorld bullet{0.0};
  std::vector<std::unique_ptr<SoftBodySystem>> systems;
  std::vector<SoftBody*> cubes;

  explicit HeadOn(std::size_t count, SoftBodySystem::Hook hook = SoftBodySystem::Hook::PreTick) {
    for (std::size_t i = 0; i < count; ++i)
      systems.push_back(std::make_unique<SoftBodySystem>(*bullet.world, hook));
    for (const double side : {-1.0, 1.0}) {
      SoftBodySettings s = pairBody({0.8 * side, 0.1 * side, 0.07 * side}, {-3 * side, 0, 0});
      SoftBodySystem& system = *systems[cubes.size() % count];
      cubes.push_back(*system.createBody(closedCubeNetwork(), s));
    }
  }
  double centreDistance() const { return cubes[1]->centerOfMass().x() - cubes[0]->centerOfMass().x(); }
};

TEST(SystemsOfOneWorld, bodiesOfTwoMeetAsThoseOfOneDo) {
  HeadOn one(1), two(2);
  for (int i = 0; i < 60; ++i) {
    one.bullet.tick();
    two.bullet.tick();
    for (std::size_t c : {0u, 1u}) ASSERT_EQ(one.cubes[c]->stateHash(), two.cubes[c]->stateHash()) << i;
  }
  // points alone pass between each other
  EXPECT_EQ(two.centreDistance() > 1.0, kSurface);
  EXPECT_LT((exactMomentumOf(*two.cubes[0]) + exactMomentumOf(*two.cubes[1])).norm(), 1e-12)
      << "doubles of 3 N s";
}

TEST(SystemsOfOneWorld, bodiesOfSystemsSteppedByHandMeetToo) {
  HeadOn one(1), two(2, SoftBodySystem::Hook::Manual);
  two.bullet.world->setInternalTickCallback(
      [](btDynamicsWorld* world, btScalar tick) {
        for (auto& system : static_cast<HeadOn*>(world->getWorldUserInfo())->systems)
          system->beforeTick(tick);
      },
      &two, true);
  for (int i = 0; i < 60; ++i) {
    one.bullet.tick();
    two.bullet.tick();
  }
  for (std::size_t c : {0u, 1u}) EXPECT_EQ(one.cubes[c]->stateHash(), two.cubes[c]->stateHash());
}

TEST(SystemsOfOneWorld, aSystemThatGoesEndsItsContactsAndLeavesTheOthersSteppingOn) {
  struct Ends final : ContactListener {
    int begun = 0, ended = 0;
    void contactBegins(const ContactPair&) override { ++begun; }
    void contactEnds(const ContactPair&) override { ++ended; }
  };
  BulletWorld bullet;
  bullet.addBoxFloor();
  Ends ends;
  SoftBodySystem stays(*bullet.world);
  auto goes = std::make_unique<SoftBodySystem>(*bullet.world);
  stays.setContactListener(&ends);
  (void)*goes->createBody(closedCubeNetwork(), pairBody({0, 0.53, 0}, {0, 0, 0}));
  SoftBody* upper = *stays.createBody(closedCubeNetwork(), pairBody({0, 1.6, 0}, {0, 0, 0}));
  bullet.simulate(1.0);
  EXPECT_EQ(ends.begun - ends.ended, 1);
  EXPECT_GT(upper->centerOfMass().y(), 1.2);
  goes.reset();
  bullet.simulate(2.0);
  EXPECT_LT(upper->centerOfMass().y(), 0.6);
  EXPECT_GT(upper->centerOfMass().y(), 0.3) << "it lies on the floor";
}

// --- order of bodies and points ----------------------------------------------------------------------------

/// Returns the same network with its points, triangles and, as far as possible, springs in another order.
SharedNetwork shuffled(const SharedNetwork& network, unsigned seed) {
  if (seed == 0) return network;
  auto other = std::make_shared<SpringNetwork>(*network);
  std::mt19937 random(seed);
  std::vector<std::uint32_t> newIndex(network->restPoints.size());
  std::iota(newIndex.begin(), newIndex.end(), 0u);
  for (std::size_t i = newIndex.size(); i-- > 1;) std::swap(newIndex[i], newIndex[random() % (i + 1)]);
  for (std::size_t i = 0; i < newIndex.size(); ++i) {
    other->restPoints[newIndex[i]] = network->restPoints[i];
    other->massFractions[newIndex[i]] = network->massFractions[i];
  }
  for (Triangle& t : other->surface) t = {newIndex[t[0]], newIndex[t[1]], newIndex[t[2]]};
  for (std::size_t i = other->surface.size(); i-- > 1;)
    std::swap(other->surface[i], other->surface[random() % (i + 1)]);
  for (NetworkSpring& s : other->springs) {
    const auto [a, b] = std::minmax(newIndex[s.a], newIndex[s.b]);
    s.a = a, s.b = b;
  }
  std::sort(other->springs.begin(), other->springs.end(), [](const NetworkSpring& x, const NetworkSpring& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  return other;
}

struct Order {
  bool swapped = false;
  unsigned seed = 0;
  double displacement = 0.0;  // m
};

/// Returns the centres of mass of both bodies, a second after the upper was thrown onto the lower.
std::array<Vector3d, 2> finalCentres(const Order& order, const SharedNetwork& upper,
                                     SoftBodySettings settings) {
  SoftWorld bullet(0.0);
  // damping acts on one spring after the other: its error depends on their order
  SoftBodySettings lower = pairBody({0, 0, 0}, {0, 0, 0});
  lower.damping = settings.damping = 0.0;
  settings.position.x() += order.displacement;
  SoftBody *a = nullptr, *b = nullptr;
  const auto addLower = [&] { a = bullet.addSoft(shuffled(closedCubeNetwork(), order.seed), lower); };
  if (!order.swapped) addLower();
  b = bullet.addSoft(shuffled(upper, order.seed), settings);
  if (order.swapped) addLower();
  bullet.simulate(1.0);
  return {a->centerOfMass(), b->centerOfMass()};
}

struct Thrown {
  const char* name;
  SharedNetwork network;
  SoftBodySettings settings;
};

std::vector<Thrown> thrownBodies() {
  std::vector<Thrown> all = {
      {"ball", bracedNetwork(small_meshes::icosphere(1)), pairBody({0.1, 1.4, 0.05}, {0, -2, 0})},
      {"rope", ropeNetwork(19), pairBody({-0.35, 0.9, 0.075}, {0, -2, 0})},
      {"cube", closedCubeNetwork(), pairBody({0.3, 1.3, 0.2}, {0, -2, 0})}};
  all[0].settings.scale = {0.5, 0.5, 0.5};
  all[2].settings.rotation = kTilted;
  return all;
}

double distance(const std::array<Vector3d, 2>& x, const std::array<Vector3d, 2>& y) {
  return std::max((x[0] - y[0]).norm(), (x[1] - y[1]).norm());
}

/// The tolerance is the effect of a displacement of 1e-6 m: rounding and the solver have similar effects.
TEST(OrderOfBodies, andOfTheirPointsDoesNotMatter) {
  for (const Thrown& thrown : thrownBodies()) {
    SCOPED_TRACE(thrown.name);
    const auto now = finalCentres({}, thrown.network, thrown.settings);
    const auto change = [&](const Order& order) {
      return distance(now, finalCentres(order, thrown.network, thrown.settings));
    };
    const double nudged = change({false, 0, 1e-6});
    EXPECT_LT(change({true}), nudged) << "who was created first";
    for (const unsigned seed : {1u, 2u, 3u}) EXPECT_LT(change({false, seed}), 10.0 * nudged);
  }
}

// --- a cloth on a ball -------------------------------------------------------------------------------------

/// Returns the positions of a cloth's points, in the order of the grid, `seconds` after it was dropped on a
/// static ball.
std::vector<Vector3d> drapeOnBall(double seconds, const Order& order, double rate = 60.0) {
  SoftWorld bullet;
  bullet.add(std::make_unique<btSphereShape>(btScalar(0.4)), 0, vec(0, 0, 0));
  SoftBodySettings s = pairBody({0.05 + order.displacement, 0.5, 0.02}, {0, 0, 0}, 500.0);
  s.damping = 0.0;
  const SharedNetwork cloth = *buildCloth(), made = shuffled(cloth, order.seed);
  SoftBody* body = bullet.addSoft(made, s);
  bullet.simulate(seconds, 1.0 / rate);
  std::vector<Vector3d> x;
  for (const Vector3d& rest : cloth->restPoints) {
    const auto it = std::find(made->restPoints.begin(), made->restPoints.end(), rest);
    x.push_back(body->position(static_cast<std::uint32_t>(it - made->restPoints.begin())));
  }
  return x;
}

double maxDistance(const std::vector<Vector3d>& x, const std::vector<Vector3d>& y) {
  double d = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) d = std::max(d, (x[i] - y[i]).norm());
  return d;
}

/// The wrinkles of the cloth are chaotic: if it starts with a displacement of 1e-6 m, its points differ by 5
/// cm after 0.6 s. The test therefore compares the sizes of such differences.
TEST(DrapeOnBall, neitherOrderNorTickMattersMoreThanANudge) {
  constexpr double kChaosFactor = 4.0, kSeconds = 0.6;
  const auto now = drapeOnBall(kSeconds, {});
  const auto nudged = [&](double nudge) {
    return std::max(maxDistance(now, drapeOnBall(kSeconds, {false, 0, nudge})),
                    maxDistance(now, drapeOnBall(kSeconds, {false, 0, -nudge})));
  };
  EXPECT_LT(maxDistance(now, drapeOnBall(kSeconds, {false, 1})), kChaosFactor * nudged(1e-6));
  // 0.9 mm is its fall during a substep when it lands
  EXPECT_LT(maxDistance(now, drapeOnBall(kSeconds, {}, 240.0)), kChaosFactor * nudged(9e-4));
}

// --- fast bodies -------------------------------------------------------------------------------------------

/// Returns whether two cubes that collide head-on, each at `speed`, pass through each other.
bool passThroughEachOther(double speed, unsigned pose, double searchDistance) {
  SoftWorld bullet(0.0);
  std::mt19937 random(pose);
  std::uniform_real_distribution<double> angle(0.0, 6.28);
  std::vector<SoftBody*> cubes;
  for (const double side : {-1.0, 1.0}) {
    SoftBodySettings s = pairBody({2.5 * side, 0.02 * pose * side, 0}, {-speed * side, 0, 0});
    s.stepping.searchDistance = searchDistance;
    for (int i = 0; pose > 0 && i < 3; ++i)
      s.rotation = s.rotation * Quaterniond(Eigen::AngleAxisd(angle(random), Vector3d::Unit(i)));
    cubes.push_back(bullet.addSoft(closedCubeNetwork(), s));
  }
  bullet.simulate(0.3);
  const Vector3d momentum = exactMomentumOf(*cubes[0]) + exactMomentumOf(*cubes[1]);
  EXPECT_LT(momentum.norm(), 1e-10) << "of 200 N s in doubles";
  return cubes[1]->centerOfMass().x() < cubes[0]->centerOfMass().x();
}

TEST(FastPairs, cubesThatMeetHeadOnDoNotPassThroughEachOther) {
  if (!kSurface) GTEST_SKIP() << "points alone pass between each other";
  for (const double searchDistance : {Stepping().searchDistance, Stepping::fast().searchDistance})
    for (const double speed : {10.0, 50.0, 100.0})
      for (unsigned pose = 0; pose < 8; ++pose)
        EXPECT_FALSE(passThroughEachOther(speed, pose, searchDistance))
            << speed << " m/s, pose " << pose << ", searches after " << searchDistance;
}

/// The boxes of Bullet's broadphase do not include velocities that were set since the last tick.
TEST(FastPairs, whatIsThrownHitsInItsFirstTick) {
  if (!kSurface) GTEST_SKIP() << "points alone pass between each other";
  for (const double pathPerTick : {1.7, 3.0, 30.0})
    for (const bool thrownFirst : {true, false})
      for (const bool bothMove : {false, true}) {
        SoftWorld bullet(0.0);
        const auto add = [&](bool thrown) {
          return bullet.addSoft(closedCubeNetwork(),
                                pairBody({0, 0, thrown ? 0.6 + 0.5 * pathPerTick : 0.0}, {0, 0, 0}));
        };
        SoftBody* first = add(thrownFirst);
        SoftBody* second = add(!thrownFirst);
        SoftBody *thrown = thrownFirst ? first : second, *other = thrownFirst ? second : first;
        bullet.simulate(0.1);
        const double speed = pathPerTick / kTick;
        thrown->surfaceObject()->setLinearVelocity(vec(0, 0, -speed));
        if (bothMove) other->surfaceObject()->setLinearVelocity(vec(0, 0, 0.3 * speed));
        bullet.tick();
        bullet.tick();
        // the other body must get a large part of the momentum, even if both are still flattened
        EXPECT_LT(exactMomentumOf(*other).z(), -0.2 * speed)
            << pathPerTick << " m a tick, thrown first " << thrownFirst << ", both move " << bothMove;
      }
}

/// Returns the energy (J, 8.88 before) after a rigid ball has hit a soft one, and the rigid one's velocity.
std::pair<double, Vector3d> leftAfterHit(double rate) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = pairBody({0, 0, 0}, {0, 0, 0});
  s.scale = {0.5, 0.5, 0.5};
  s.damping = 0.0;
  s.friction = 0.0;
  SoftBody* soft = bullet.addSoft(bracedNetwork(small_meshes::icosphere(1)), s);
  btRigidBody* rigid = bullet.add(std::make_unique<btSphereShape>(btScalar(0.2)), 1.0, vec(-1.2, 0.11, 0.07));
  rigid->setLinearVelocity(vec(std::sqrt(2.0 * 8.88), 0, 0));
  bullet.simulate(1.0, 1.0 / rate);
  const Vector3d velocity = eigen(rigid->getLinearVelocity());
  return {energyOf(*soft) + 0.5 * velocity.squaredNorm(), velocity};
}

/// Both fall by g dt^2 in the first tick, 44 mm at 1/15 s, until the floor stops the cube in it.
TEST(FastPairs, aBoxReleasedJustAboveACubeOnTheFloorIsStoppedInTheSameTick) {
  if (!kSurface) GTEST_SKIP() << "the points of the face leave gaps for the box";
  for (const double size : {0.02, 0.3})
    for (const double hertz : {15.0, 30.0}) {
      SCOPED_TRACE(testing::Message() << size << " m, " << hertz << " Hz");
      SoftWorld bullet;
      bullet.addBoxFloor();
      SoftBodySettings s = testedSettings();
      s.scale = Vector3d::Constant(size);
      s.totalMass = 1e3 * size * size * size;
      // each layer of springs sags by about a per cent
      s.extensionStiffness = s.compressionStiffness = 1e3 * s.totalMass / size;
      s.damping = 0.1 * std::sqrt(s.totalMass * s.extensionStiffness);
      const SharedNetwork network = bracedNetwork(small_meshes::cube(2));
      const double radius = pointRadius(*network, s), top = size + 2 * radius, half = 0.3 * size;
      s.position.y() = 0.5 * top;
      (void)bullet.addSoft(network, s);
      btRigidBody* box = bullet.addAwakeBox(vec(half, half, half), s.totalMass, vec(0, top + half + 5e-4, 0));
      double deepest = 0.0;
      for (int i = 0; i < hertz; ++i) {
        bullet.tick(1.0 / hertz);
        deepest = std::max(deepest, top + half - heightOf(*box));
      }
      EXPECT_LT(deepest, 0.03 * size);
    }
}

TEST(FastPairs, whatAHitLeavesDoesNotDependOnTheTick) {
  if (!kSurface) GTEST_SKIP() << "points alone pass by";
  const auto [energy, velocity] = leftAfterHit(960);
  for (const double rate : {60.0, 120.0, 240.0, 480.0}) {
    SCOPED_TRACE(rate);
    const auto [left, after] = leftAfterHit(rate);
    // It was once 4 % (a gain) and 0.22 m/s at 60 Hz. The remaining error is that of Verlet in some
    // oscillations after the impact, and of contacts that are found up to one search late.
    EXPECT_NEAR(left, energy, 0.01 * 8.88);
    EXPECT_LT((after - velocity).norm(), 0.02);
    EXPECT_LT(left, 8.88);
  }
}

// --- contacts between points -------------------------------------------------------------------------------

/// Returns settings of point masses in the world without friction and damping.
SoftBodySettings pointsBody(const Vector3d& position, const Vector3d& velocity, double radius) {
  SoftBodySettings s = pairBody(position, velocity, 1e4);
  s.collision = Collision::Points;
  s.pointRadius = radius;
  s.damping = s.friction = 0.0;
  return s;
}

/// Lets a pair of points fly at `speed` (m/s) along z towards another pair, which is at rest and `offset` (m)
/// higher. Returns the momenta (kg m/s) of both after one second.
std::pair<Vector3d, Vector3d> momentaAfterOneSecond(double speed, double offset) {
  SoftWorld bullet(0.0);
  SoftBody* left = bullet.addSoft(pairNetwork(), pointsBody({0, 0, -0.53}, {0, 0, speed}, 0.1));
  SoftBody* right = bullet.addSoft(pairNetwork(), pointsBody({0, offset, 0}, {0, 0, 0}, 0.1));
  bullet.simulate(1.0);
  return {exactMomentumOf(*left), exactMomentumOf(*right)};
}

TEST(PointPairs, whatPassesByIsNotHeldBack) {
  for (const double speed : {0.7, 3.0, 30.0, 300.0}) {
    SCOPED_TRACE(speed);
    const auto [left, right] = momentaAfterOneSecond(speed, 0.201);
    EXPECT_LT((left - Vector3d(0, 0, speed)).norm(), 1e-6 * speed) << "to Bullet's floats";
    EXPECT_LT(right.norm(), 1e-6 * speed);
  }
}

TEST(PointPairs, smoothPointsShareTheirSpeedAlongTheLineBetweenThem) {
  const auto [left, right] = momentaAfterOneSecond(1.0, 0.1);
  // the sine of the angle between velocity and normal is offset / (2 r); Newton's law at restitution 0
  const Vector3d normal(0, -0.5, -std::sqrt(0.75)), speed(0, 0, 1);
  const Vector3d change = -0.5 * normal.dot(speed) * normal;
  // in the substep of the impact they move on along the plane between them: 2 mm of 20 cm, four times
  EXPECT_LT((left - speed - change).norm(), 0.04);
  EXPECT_LT((right + change).norm(), 0.04);
  EXPECT_LT((left + right - speed).norm(), 1e-6);
}

/// Lets two stiff cubes collide at random rotations. Returns their largest energy as a fraction of the
/// initial one, and the change of momentum as a fraction of `speed`.
std::pair<double, double> collideStiffCubes(double speed, unsigned attitude) {
  std::mt19937 random(attitude);
  std::normal_distribution<double> normal;
  const auto randomVector = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  SoftWorld bullet(0.0);
  SoftBodySettings s = pointsBody({0, 0, 0}, {speed, 0, 0}, 0.15);
  s.rotation = Eigen::AngleAxisd(2.0, randomVector().normalized());
  s.angularVelocity = 3.0 * randomVector();
  SoftBody* left = bullet.addSoft(closedCubeNetwork(), s);
  s.position = 0.2 * randomVector();
  s.position.x() = 2.0;
  s.linearVelocity = {-speed, 0, 0};
  s.rotation = Eigen::AngleAxisd(2.0, randomVector().normalized());
  SoftBody* right = bullet.addSoft(closedCubeNetwork(), s);
  const double start = energyOf(*left) + energyOf(*right);
  const Vector3d momentum = exactMomentumOf(*left) + exactMomentumOf(*right);
  double largest = 0.0;
  for (int tick = 0; tick < 90; ++tick) {
    bullet.tick();
    largest = std::max(largest, (energyOf(*left) + energyOf(*right)) / start);
  }
  return {largest, (exactMomentumOf(*left) + exactMomentumOf(*right) - momentum).norm() / speed};
}

TEST(PointPairs, theirMeetingMakesNoEnergy) {
  for (const double speed : {1.0, 5.0, 20.0})
    for (unsigned attitude = 0; attitude < 8; ++attitude) {
      SCOPED_TRACE(testing::Message() << speed << " m/s, attitude " << attitude);
      const auto [energy, momentum] = collideStiffCubes(speed, attitude);
      EXPECT_LT(energy, 1.01) << "Verlet's energy swings by (omega dt)^2 / 8";
      EXPECT_LT(momentum, 1e-5) << "float positions of some metres";
    }
}

TEST(PointPairs, bothTellWhatTheyBear) {
  SoftWorld bullet(0.0);
  SoftBody* left = bullet.addSoft(pairNetwork(), pointsBody({0, 0, -0.21}, {0, 0, 1}, 0.1));
  SoftBody* right = bullet.addSoft(pairNetwork(), pointsBody({0, 0, 0}, {0, 0, 0}, 0.1));
  Vector3d impulseOnLeft = Vector3d::Zero(), impulseOnRight = Vector3d::Zero();
  double impulseInBullet = 0.0;
  for (int tick = 0; tick < 10; ++tick) {
    bullet.tick();
    for (const SoftContact& c : left->contacts()) {
      EXPECT_EQ(c.otherBody, right);
      impulseOnLeft += eigen(c.impulse);
    }
    for (const SoftContact& c : right->contacts()) {
      EXPECT_EQ(c.otherBody, left);
      impulseOnRight += eigen(c.impulse);
    }
    impulseInBullet += bullet.impulsesInManifolds();
  }
  EXPECT_LT((impulseOnLeft + impulseOnRight).norm(), 1e-9);
  EXPECT_NEAR(impulseOnRight.z(), exactMomentumOf(*right).z(), 1e-5) << "all that it has got it got there";
  EXPECT_GT(impulseOnRight.z(), 0.4);
  EXPECT_LE(impulseInBullet, impulseOnRight.z() + 1e-5) << "where Bullet sees a contact, it has its impulse";
}

}  // namespace
}  // namespace limber::test
