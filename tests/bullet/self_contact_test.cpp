// SPDX-License-Identifier: Zlib
// Contacts of ropes and cloths with themselves.
#include "support/soft_world.h"
#include "support/tiled_floors.h"

#include <cmath>

namespace limber::test {
namespace {

using Eigen::Vector3d;

/// Returns the smallest distance (m) between two segments of a rope whose indices differ by at least
/// `minIndexGap`.
double nearestSegments(const SoftBody& rope, std::uint32_t minIndexGap) {
  double nearest = 1e9;
  const std::uint32_t steps = 8;  // points checked on each segment
  const auto pointOn = [&](std::uint32_t i, std::uint32_t step) {
    const double t = static_cast<double>(step) / steps;
    return Vector3d((1 - t) * rope.position(i) + t * rope.position(i + 1));
  };
  for (std::uint32_t i = 0; i + 1 < rope.pointCount(); ++i)
    for (std::uint32_t j = i + minIndexGap; j + 1 < rope.pointCount(); ++j)
      for (std::uint32_t a = 0; a < steps; ++a)
        for (std::uint32_t b = 0; b < steps; ++b)
          nearest = std::min(nearest, (pointOn(i, a) - pointOn(j, b)).norm());
  return nearest;
}

TEST(SurfaceOnItself, aRopeCoilsUpWhenAsked) {
  for (const bool self : {false, true}) {
    SoftWorld bullet;
    bullet.addBoxFloor()->setFriction(1);
    SoftBodySettings s = testedSettings();
    // hangs over one point of the floor, slightly tilted, and lands on its end
    s.position = {0, 2.1, 0};
    s.rotation = Eigen::AngleAxisd(0.05, Vector3d(1, 0, 0.3).normalized());
    s.pointRadius = 0.008;
    s.totalMass = 1.0;
    setSprings(s, 4e3, 2.0);
    s.selfCollision = self;
    SoftBody* rope = bullet.addSoft(chainNetwork(40), s);
    for (std::uint32_t i = 0; i < rope->pointCount(); ++i) rope->point(i)->setDamping(btScalar(0.5), 0);
    bullet.simulate(6.0);
    EXPECT_FALSE(rope->surfaceObject()->isActive()) << "it has come to rest";
    if (self) {
      EXPECT_GT(nearestSegments(*rope, 2), 1.98 * *s.pointRadius) << "of two radii";
      std::size_t own = 0;
      for (const SoftContact& c : rope->contacts()) {
        own += c.otherBody == rope;
        EXPECT_GT(c.distance, -0.02 * *s.pointRadius);
      }
      EXPECT_GT(own, 0u);
    } else {
      EXPECT_LT(nearestSegments(*rope, 2), 0.7 * *s.pointRadius) << "else this test would prove nothing";
    }
  }
}

/// Returns the number of pairs of an edge and a triangle that intersect and have no common vertex.
int piercings(const SoftBody& cloth) {
  int count = 0;
  const auto& surface = cloth.network().surface;
  const auto isCorner = [](std::uint32_t v, const Triangle& t) {
    return v == t[0] || v == t[1] || v == t[2];
  };
  for (const Triangle& t : surface) {
    const Vector3d a = cloth.position(t[0]), u = cloth.position(t[1]) - a, v = cloth.position(t[2]) - a;
    const Vector3d normal = u.cross(v);
    for (const Triangle& other : surface)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t p = other[k], q = other[(k + 1) % 3];
        if (p > q || isCorner(p, t) || isCorner(q, t)) continue;
        const Vector3d from = cloth.position(p) - a, to = cloth.position(q) - a;
        const double above = normal.dot(from), below = normal.dot(to);
        if (above * below >= 0.0) continue;
        const Vector3d x = from + (to - from) * (above / (above - below));
        const double second = normal.dot(u.cross(x)), third = normal.dot(x.cross(v));
        count += second >= 0.0 && third >= 0.0 && second + third <= normal.squaredNorm();
      }
  }
  return count;
}

SoftBodySettings clothSettings(bool self) {
  SoftBodySettings s = testedSettings();
  s.pointRadius = 0.01;
  s.totalMass = 0.2;
  setSprings(s, 200.0, 0.2);
  s.selfCollision = self;
  return s;
}

TEST(SurfaceOnItself, aClothFoldsWithoutPassingThrough) {
  for (const bool self : {false, true}) {
    SoftWorld bullet;
    bullet.addBoxFloor()->setFriction(1);
    SoftBodySettings s = clothSettings(self);
    // stands on an edge, tilted, and crumples
    s.position = {0, 0.7, 0};
    s.rotation = Eigen::AngleAxisd(M_PI / 2 - 0.1, Vector3d(1, 0, 0.1).normalized());
    SoftBody* cloth = bullet.addSoft(squareCloth(10, 1.0), s);
    int maxPiercings = 0;
    for (int i = 0; i < 180; ++i) {
      bullet.tick();
      if (i % 6 == 0) maxPiercings = std::max(maxPiercings, piercings(*cloth));
    }
    if (self)
      EXPECT_EQ(maxPiercings, 0);
    else
      EXPECT_GT(maxPiercings, 0) << "else this test would prove nothing";
  }
}

/// With one substep per tick it is crushed by the falling part above. With compliant contacts it would sink
/// by more than its radius.
TEST(SurfaceOnItself, aChainThatFallsOnItsEndDoesNotSinkIntoTheFloor) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBodySettings s = settingsAt({0, 0.9, 0});
  s.scale = {1, 0.7, 1};
  s.extensionStiffness = s.compressionStiffness = 160.0;
  s.selfCollision = true;
  s.stepping.maxSubsteps = 1;
  SoftBody* chain = bullet.addSoft(chainNetwork(12), s);
  double least = 1.0;
  for (int tick = 0; tick < 20; ++tick) {
    bullet.tick();
    least = std::min(least, lowest(*chain));
  }
  EXPECT_GT(least, 0.8 * double(chain->point(0)->getCollisionShape()->getMargin()));
}

/// The chain falls on its end and crumples: its set of self-contacts changes many times per tick.
TEST(SurfaceOnItself, aChainCrumplesAlikeInHalfTicks) {
  const double seconds = 31.0 / 60.0;
  const auto crumpled = [&](double tick) {
    SoftWorld bullet(-10.0);
    bullet.addPlaneFloor()->setFriction(0.5);
    SoftBodySettings s = settingsAt({0, 2, 0});
    s.linearVelocity = {0, 0, 0.7};
    s.extensionStiffness = 1000.0;
    s.compressionStiffness = 9730.0;
    s.damping = 1.0;
    s.totalMass = 1.0;
    s.selfCollision = true;
    s.stepping.periodTolerance = 2e-3;
    SoftBody* chain = bullet.addSoft(chainNetwork(12), s);
    bullet.simulate(seconds, tick);
    return placesOf(*chain);
  };
  EXPECT_LT((crumpled(1.0 / 60.0) - crumpled(1.0 / 120.0)).cwiseAbs().maxCoeff(), 1e-3);
}

/// A static box of half size 0.3 on the floor, and a cloth that falls over it.
struct Drape {
  btBoxShape part{vec(0.3, 0.3, 0.3)};
  BulletWorld bullet;
  SoftBodySystem system;
  SoftBody* cloth = nullptr;
  int maxPiercings = 0;  ///< largest number of intersections at one time

  Drape(const SoftBodySettings& s, std::uint32_t cells, bool compound = false) : system(*bullet.world) {
    bullet.addBoxFloor()->setFriction(1);
    addBox(compound)->setFriction(2);
    cloth = *system.createBody(squareCloth(cells, 1.2), s);
    for (std::uint32_t i = 0; i < cloth->pointCount(); ++i) cloth->point(i)->setDamping(btScalar(0.3), 0);
  }
  btRigidBody* addBox(bool compound) {
    if (!compound) return bullet.addBox(vec(0.3, 0.3, 0.3), 0, vec(0.3, 0.3, 0.3));
    auto shape = std::make_unique<btCompoundShape>();
    shape->addChildShape(btTransform(btQuaternion::getIdentity(), vec(0.3, 0, 0)), &part);
    return bullet.add(std::move(shape), 0, vec(0, 0.3, 0.3));
  }
  bool sleeps() const { return !cloth->surfaceObject()->isActive(); }

  /// Simulates until the cloth sleeps, at most `seconds`.
  void run(double seconds) {
    for (int i = 0; i < std::lround(seconds * 60) && !sleeps(); ++i) {
      bullet.tick();
      if (i % 12 == 0) maxPiercings = std::max(maxPiercings, piercings(*cloth));
    }
  }
};

/// Returns the smallest distance (m) from the box of Drape of points on the cloth's triangles; 0 inside.
double nearestToBox(const SoftBody& cloth) {
  const int steps = 8;
  double nearest = 1e9;
  for (const Triangle& t : cloth.network().surface)
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; i + j <= steps; ++j) {
        const Vector3d x =
            (i * cloth.position(t[0]) + j * cloth.position(t[1]) + (steps - i - j) * cloth.position(t[2])) /
            steps;
        const Vector3d outside = ((x - Vector3d::Constant(0.3)).cwiseAbs().array() - 0.3).max(0.0);
        nearest = std::min(nearest, outside.norm());
      }
  return nearest;
}

/// Two corners of a cloth's edge may touch two sides of a sharp edge whose normals differ by up to acos 0.9.
/// The contact of the edge between them is then left out, and its distance can be as small as 0.9 radii.
constexpr double kNearest = 0.9;

/// It falls by 5 radii per tick when it hits the box's corners.
TEST(SurfaceOnItself, aClothDrapedOverABallFallsOverABoxesCorner) {
  for (int start = 0; start < 6; ++start) {
    SCOPED_TRACE(start);
    SoftBodySettings s = clothSettings(true);
    s.position = {0.02 + 0.001 * start, 1.6, 0.01};
    Drape drape(s, 14);
    btRigidBody* ball = drape.bullet.add(std::make_unique<btSphereShape>(btScalar(0.35)), 0, vec(0, 1.2, 0));
    ball->setFriction(2);
    drape.run(4.0);
    EXPECT_GT(drape.cloth->centerOfMass().y(), 1.0) << "it hangs over the ball";
    drape.bullet.world->removeRigidBody(ball);
    drape.cloth->wake();
    drape.run(15.0);
    EXPECT_TRUE(drape.sleeps());
    EXPECT_EQ(drape.maxPiercings, 0);
    EXPECT_GT(nearestToBox(*drape.cloth), kNearest * *s.pointRadius);
    double high = 0.0;
    for (std::uint32_t i = 0; i < drape.cloth->pointCount(); ++i) {
      high = std::max(high, drape.cloth->position(i).y());
      EXPECT_GT(drape.cloth->position(i).y(), 0.9 * *s.pointRadius) << i;
    }
    EXPECT_GT(high, 0.6) << "and lies over the box";
  }
}

/// The initial pose of a cloth, relative to the box's centre.
struct DrapePose {
  double x, z, angle;
  std::uint32_t cells;
  double radius;
  bool compound;  ///< the box is a child of a compound shape
};

TEST(SurfaceOnItself, aClothComesToRestOverABoxesEdgesAndCorners) {
  for (const DrapePose& p : {DrapePose{0.3, 0.3, 0.4, 14, 0.01, false},
                             {0.3, 0.0, 0.0, 10, 0.01, false},
                             {0.0, 0.0, 0.0, 14, 0.01, false},
                             {0.05, 0.3, 0.0, 12, 0.01, true},
                             {0.3, 0.3, 0.2, 14, 0.02, false}}) {
    SCOPED_TRACE(testing::Message() << p.x << ' ' << p.z << ' ' << p.angle << ' ' << p.cells << ' '
                                    << p.radius);
    SoftBodySettings s = clothSettings(false);
    s.pointRadius = p.radius;
    s.position = {0.3 + p.x, 0.7, 0.3 + p.z};
    s.rotation = Eigen::AngleAxisd(p.angle, Vector3d::UnitY());
    Drape drape(s, p.cells, p.compound);
    drape.run(16.0);
    EXPECT_TRUE(drape.sleeps()) << drape.cloth->kineticEnergy();
    EXPECT_GT(nearestToBox(*drape.cloth), kNearest * p.radius);
    EXPECT_GT(drape.cloth->centerOfMass().y(), 0.2) << "it has not slid off";
  }
}

/// Returns the smallest height (m) of a point's centre during two seconds in which a cloth falls and crumples
/// on a floor at z = 0.
double lowestOfFallingCloth(FloorKind floor, double angle) {
  SoftWorld bullet;
  addTiledFloor(bullet, floor, 0.0);
  SoftBodySettings s = settingsAt({1, 2, 0});
  s.rotation = Eigen::AngleAxisd(1.0, Vector3d(0.8, angle, 0.6).normalized());
  s.extensionStiffness = 86.3;
  s.compressionStiffness = 8.63;
  s.damping = 0.019;
  s.totalMass = 2.52;
  s.friction = 1.0;
  s.pointRadius = 0.0022;
  s.selfCollision = true;
  SoftBody* body = bullet.addSoft(clothNetwork(9, 7), s);
  double least = HUGE_VAL;
  for (int i = 0; i < 30; ++i) {
    bullet.tick(1.0 / 15);
    least = std::min(least, lowest(*body));
  }
  return least;
}

TEST(SurfaceOnItself, whatTouchesWithinATickDoesNotPushIntoTheFloor) {
  for (const FloorKind floor : {FloorKind::Plane, FloorKind::CoarseMesh})
    for (const double angle : {0.0, 0.1})
      // the solver's tolerance of velocities, 1e-4 m/s, over a tick
      EXPECT_GT(lowestOfFallingCloth(floor, angle), 0.0022 - 1e-5)
          << nameOf(floor) << ", turned by " << angle;
}

TEST(SurfaceOnItself, wantsASurface) {
  SoftBodySettings s;
  s.collision = Collision::Points;
  s.selfCollision = true;
  EXPECT_NE(validate(s).error(), "");
  s.collision = Collision::Surface;
  EXPECT_EQ(validate(s).error(), "");
}

}  // namespace
}  // namespace limber::test
