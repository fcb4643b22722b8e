// SPDX-License-Identifier: Zlib
// Bodies that slide over a static curved surface follow it without losing speed, at any tick.
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <algorithm>
#include <cmath>

namespace limber::test {
namespace {

using Eigen::Vector3d;

/// Adds a static cylinder along z through the origin, without friction.
void addCylinder(BulletWorld& bullet, double radius) {
  const auto r = static_cast<btScalar>(radius);
  bullet.add(std::make_unique<btCylinderShapeZ>(btVector3(r, r, 1)), 0, btVector3(0, 0, 0))->setFriction(0);
}

/// Returns the point at the arc length `along` of a curve over the top of a circle, which hangs down on both
/// sides. The top is at 0.
Vector3d hangingPath(double radius, double along) {
  const double quarter = radius * M_PI / 2;
  const double angle = std::clamp(along, -quarter, quarter) / radius;
  return {radius * std::sin(angle), radius * std::cos(angle) - std::max(0.0, std::abs(along) - quarter), 0};
}

struct Hanging {
  double radius;       ///< m, of the cylinder
  double left, right;  ///< kg, at the rope's ends
  double speed;        ///< m/s, towards the right
};

constexpr double kRopeMass = 0.02;  // kg
constexpr double kStiffness = 2e4;  // N/m, of a segment of 5 cm, which 2 kg extend by 2 %
constexpr double kSegment = 0.05;   // m
constexpr double kSide = 0.9;       // m, length of each hanging part

/// Adds a rope over the cylinder, with the length that it has under the lighter load.
SoftBody* addRope(SoftBodySystem& system, const Hanging& h) {
  const double around = h.radius + kRadius;
  const int half = static_cast<int>(std::ceil((around * M_PI / 2 + kSide) / kSegment));
  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Rope;
  const double total = h.left + h.right + kRopeMass;
  for (int i = -half; i <= half; ++i) {
    network->restPoints.push_back({i * kSegment, 0, 0});
    network->massFractions.push_back(kRopeMass / (2 * half - 1) / total);
  }
  network->massFractions.front() = h.left / total;
  network->massFractions.back() = h.right / total;
  const auto count = static_cast<std::uint32_t>(network->restPoints.size());
  for (std::uint32_t i = 0; i + 1 < count; ++i)
    network->springs.push_back({i, i + 1, SpringKind::Structural, 1.0});
  SoftBodySettings s = testedSettings();
  s.totalMass = total;
  setSprings(s, kStiffness, 1.0);
  s.friction = 0.0;
  s.pointRadius = kRadius;
  SoftBody* rope = *system.createBody(network, s);
  const double stretched = kSegment + std::min(h.left, h.right) * kGravity / kStiffness;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double along = (static_cast<int>(i) - half) * stretched;
    const Vector3d x = hangingPath(around, along);
    const Vector3d direction =
        (hangingPath(around, along + 1e-6) - hangingPath(around, along - 1e-6)).normalized();
    btRigidBody* point = rope->point(i);
    point->setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(x.x(), x.y(), x.z())));
    point->setLinearVelocity(vec(h.speed * direction.x(), h.speed * direction.y(), h.speed * direction.z()));
  }
  return rope;
}

/// Returns the speed (m/s) of the ends towards the right. Bouncing of both in phase cancels.
double speedOf(const SoftBody& rope) {
  return 0.5 * (rope.velocity(0).y() - rope.velocity(rope.pointCount() - 1).y());
}

TEST(SurfaceCurves, aTautRopeRunsFreelyOverACylinder) {
  for (const double radius : {0.5, 0.1})
    for (const double rate : {60.0, 120.0, 240.0}) {
      SCOPED_TRACE(testing::Message() << radius << " m, " << rate << " Hz");
      SoftWorld bullet;
      addCylinder(bullet, radius);
      SoftBody* rope = addRope(bullet.system, {radius, 2.0, 2.0, 1.0});
      bullet.simulate(0.5, 1.0 / rate);
      // the part of the rope that has moved to the other side accelerates it: +0.3 %
      EXPECT_NEAR(speedOf(*rope), 1.003, 0.01);
    }
}

TEST(SurfaceCurves, anAtwoodMachineFallsAsItMust) {
  for (const double rate : {60.0, 240.0}) {
    SCOPED_TRACE(rate);
    SoftWorld bullet;
    addCylinder(bullet, 0.1);
    SoftBody* rope = addRope(bullet.system, {0.1, 1.0, 2.0, 0.0});
    bullet.simulate(0.5, 1.0 / rate);
    // the heavier side's extension and the rope's own weight change it by less than 1 %
    EXPECT_NEAR(speedOf(*rope) / (kGravity / (3.0 + kRopeMass) * 0.5), 1.0, 0.015);
  }
}

/// Adds two points side by side on the top of a round object, moving towards x.
SoftBody* addBead(SoftBodySystem& system, double height, double speed) {
  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Rope;
  network->restPoints = {{0, 0, -0.02}, {0, 0, 0.02}};
  network->massFractions = {0.5, 0.5};
  network->springs = {{0, 1, SpringKind::Structural, 1.0}};
  SoftBodySettings s = settingsAt({0, height, 0});
  s.linearVelocity = {speed, 0, 0};
  s.friction = 0.0;
  s.pointRadius = kRadius;
  return *system.createBody(network, s);
}

TEST(SurfaceCurves, aBeadThatSlidesOffGainsWhatItFalls) {
  constexpr double kRound = 0.5;  // m
  for (const bool sphere : {true, false})
    for (const double rate : {60.0, 240.0}) {
      SCOPED_TRACE(testing::Message() << (sphere ? "sphere" : "cylinder") << ", " << rate << " Hz");
      SoftWorld bullet;
      if (sphere)
        bullet.add(std::make_unique<btSphereShape>(btScalar(kRound)), 0, btVector3(0, 0, 0))->setFriction(0);
      else
        addCylinder(bullet, kRound);
      const double around = kRound + kRadius, top = sphere ? std::sqrt(around * around - 0.0004) : around;
      SoftBody* bead = addBead(bullet.system, top, 0.5);
      while (bead->position(0).y() > top * std::cos(0.7)) {
        bullet.tick(1.0 / rate);
        ASSERT_LT(bead->position(0).x(), 2.0);
        // it leaves the surface only at 46 degrees, after this loop
        EXPECT_NEAR(bead->position(0).norm() / around, 1.0, 1e-3);
      }
      const double squared = 0.25 + 2.0 * kGravity * (top - bead->position(0).y());
      EXPECT_NEAR(bead->velocity(0).squaredNorm() / squared, 1.0, 2e-3);
    }
}

double distance(const Vector3d& from, const Vector3d& to, const Vector3d& x) {
  const double fraction = std::clamp((x - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
  return (from + fraction * (to - from) - x).norm();
}

TEST(SurfaceCurves, theEdgeOfABoxDoesNotCutIntoARope) {
  SoftWorld bullet;
  bullet.addBox(vec(1, 0.5, 1), 0, vec(-1, -0.5, 0));  // its edge is the z axis
  SoftBodySettings s = settingsAt({-1.03, 0.3, 0.01});
  s.totalMass = 0.2;
  s.extensionStiffness = s.compressionStiffness = 2000.0;
  s.pointRadius = kRadius;
  SoftBody* rope = bullet.addSoft(ropeNetwork(14, 2.0), s);
  double nearest = 1.0;
  for (int i = 0; i < 60; ++i) {
    bullet.tick();
    for (std::uint32_t p = 0; p + 1 < rope->pointCount(); ++p) {
      const double z = rope->position(p).z();
      nearest = std::min(nearest, distance(rope->position(p), rope->position(p + 1), {0, 0, z}));
    }
  }
  // edge contacts are slightly soft
  EXPECT_GT(nearest, 0.8 * kRadius);
}

/// Returns how deep (m) the segments of a rope that falls across a box are inside it in the end.
double depthOfRope(const Vector3d& place) {
  SoftWorld bullet;
  const Vector3d half(0.3, 0.3, 1.0);
  bullet.addBox(toBullet(half), 0, toBullet(place));
  SoftBodySettings s = settingsAt(place + Vector3d(-0.9, 0.5, 0.03));
  s.totalMass = 0.2;
  setSprings(s, 500.0, 1.0);
  const SoftBody* rope = bullet.addSoft(ropeNetwork(17, 2.0), s);
  bullet.simulate(2.0);
  double depth = 0.0;
  for (std::uint32_t p = 0; p + 1 < rope->pointCount(); ++p)
    for (int i = 0; i <= 40; ++i) {
      const Vector3d x = rope->position(p) + i / 40.0 * (rope->position(p + 1) - rope->position(p)) - place;
      depth = std::max(depth, (half - x.cwiseAbs()).minCoeff());
    }
  return depth;
}

TEST(SurfaceCurves, theEdgesOfABoxFarAwayDoNotCutIntoARope) {
  // floats round its corners by up to 15 micrometres
  for (int i = 0; i < 12; ++i) {
    const Vector3d place(400.3 * std::cos(i), 7.7 * std::cos(2.0 * i), 400.3 * std::sin(i));
    EXPECT_LT(depthOfRope(place), 0.001) << i;
  }
}

/// Drops a cube of half a metre and 8 points onto what is in the world, so that a face hits it. Returns its
/// final height, m.
double heightOfCube(BulletWorld& bullet, double radius, double aside) {
  SoftBodySystem system(*bullet.world);
  SoftBodySettings s = settingsAt({aside, 0.45, 0.5 * aside});
  setSprings(s, 2e4, 20.0);
  s.friction = 1.0;
  s.pointRadius = radius;
  s.rotation = Eigen::AngleAxisd(0.3, Vector3d::UnitY());
  TriangleMesh mesh = small_meshes::cube();
  for (Vector3d& p : mesh.positions) p *= 0.5;
  const SoftBody* body = *system.createBody(bracedNetwork(mesh), s);
  bullet.simulate(0.5);
  return body->centerOfMass().y();
}

double heightOnShape(std::unique_ptr<btCollisionShape> shape, const Vector3d& center, double radius,
                     double aside) {
  BulletWorld bullet;
  bullet.add(std::move(shape), 0, vec(center.x(), center.y(), center.z()))->setFriction(1);
  return heightOfCube(bullet, radius, aside);
}

/// The margin lifts what lies on a mesh. Its triangles are then farther away than the body's radius.
TEST(SurfaceCurves, aMeshOfAnyMarginCarriesABodyAtIt) {
  for (const double margin : {0.0, 0.01, 0.04}) {
    BulletWorld bullet;
    bullet.addTriangleFloor()->getCollisionShape()->setMargin(static_cast<btScalar>(margin));
    EXPECT_NEAR(heightOfCube(bullet, 0.01, 0.0), 0.25 + 0.01 + margin, 0.002) << margin;
  }
}

/// Only edges and a face of the cube touch the hull. The margin, which makes the hull's edges round, is
/// Bullet's default or any other.
TEST(SurfaceCurves, aHullOfAnyMarginCarriesEdgesAndFaces) {
  for (const double radius : {0.005, 0.05})
    for (const double margin : {0.0, 0.15 * radius, radius, 0.04}) {
      auto hull = std::make_unique<btConvexHullShape>();
      for (int i = 0; i < 8; ++i)
        hull->addPoint(vec(i & 1 ? 0.08 : -0.08, i & 2 ? 0.1 : -0.1, i & 4 ? 0.08 : -0.08));
      hull->setMargin(static_cast<btScalar>(margin));
      EXPECT_NEAR(heightOnShape(std::move(hull), {0, -0.1, 0}, radius, 0.0), 0.25 + radius + margin, 0.002)
          << radius << ", " << margin;
    }
}

/// The ball's centre is under the edge between the two triangles of the face, where neither of them contains
/// it, or beside it and under both in turn.
TEST(SurfaceCurves, aBallUnderTheMiddleOfAFaceCarriesIt) {
  for (const double ball : {0.05, 0.1, 0.3, 0.5})
    for (const double radius : {0.005, 0.02})
      for (const double aside : {0.0, 1e-4}) {
        auto sphere = std::make_unique<btSphereShape>(static_cast<btScalar>(ball));
        EXPECT_NEAR(heightOnShape(std::move(sphere), {0, -ball, 0}, radius, aside), 0.25 + radius, 0.002)
            << ball << ", " << radius << ", " << aside;
      }
}

/// Between their corners the triangles may be in a ball to some depth. The contact of a triangle whose third
/// corner is lifted must not begin at that depth: it would throw the corner back in each tick.
TEST(SurfaceCurves, aCutClothOverABallComesToRest) {
  constexpr double kBall = 0.15;  // m
  for (const double aside : {0.0, 0.02, 0.04}) {
    SoftWorld bullet;
    bullet.addBoxFloor();
    bullet.add(std::make_unique<btSphereShape>(btScalar(kBall)), 0, vec(0, kBall, 0));
    SoftBodySettings s;
    s.position = {aside, 2.0 * kBall + 0.05, 0.01};
    s.totalMass = 0.2;
    s.pointRadius = 0.008;
    SoftBody* cloth = bullet.addSoft(squareCloth(6, 0.6), s);
    bullet.simulate(2.0);
    ASSERT_TRUE(cloth->cut(vec(0, 0, 0.11), vec(0.3, 0, 1)));
    bullet.simulate(8.0);
    EXPECT_TRUE(cloth->sleeping()) << aside << ": " << cloth->kineticEnergy() << " J";
  }
}

/// The rim of a cylinder is a polyhedron's, of 64 edges, just inside the cylinder. The cloth lies on the disc
/// around the rim of the inner radius; it sinks by a part of its own radius at most.
TEST(SurfaceCurves, theRimOfACylinderCarriesACloth) {
  constexpr double kRound = 0.4, kHalf = 0.3, kThin = 0.0015;  // m
  SoftWorld bullet;
  auto shape = std::make_unique<btCylinderShape>(vec(kRound, kHalf, kRound));
  shape->setMargin(btScalar(0.001));
  bullet.add(std::move(shape), 0, vec(0, 0, 0));
  SoftBodySettings s = settingsAt({0.01, kHalf + 0.05, 0.02});
  s.totalMass = 0.5;
  s.pointRadius = kThin;
  SoftBody* cloth = bullet.addSoft(squareCloth(16, 1.2), s);
  double deepest = -1.0;
  for (int i = 0; i < 60; ++i) {
    bullet.tick();
    for (const Triangle& t : cloth->network().surface)
      for (int a = 0; a <= 4; ++a)
        for (int b = 0; a + b <= 4; ++b) {
          const Vector3d p =
              (a * cloth->position(t[0]) + b * cloth->position(t[1]) + (4 - a - b) * cloth->position(t[2])) /
              4.0;
          const double inside =
              std::min(kRound * std::cos(kPi / 64) - std::hypot(p.x(), p.z()), kHalf - std::abs(p.y()));
          deepest = std::max(deepest, inside);
        }
  }
  EXPECT_LT(deepest, 0.0) << "m inside the polyhedron";
}

// --- a pipe ------------------------------------------------------------------------------------------------

/// Radius (m) of a pipe along x that narrows from 0.12 to 0.09 m between -0.1 and 0.1.
double pipeRadius(double x) { return 0.12 - 0.15 * (std::clamp(x, -0.1, 0.1) + 0.1); }

/// A pipe of triangles with 16 faces around.
void addPipe(BulletWorld& bullet) {
  constexpr int kFaces = 16;
  auto mesh = std::make_unique<btTriangleMesh>();
  const auto corner = [](double x, int face) {
    const double angle = 2.0 * kPi * face / kFaces;
    return vec(x, pipeRadius(x) * std::cos(angle), pipeRadius(x) * std::sin(angle));
  };
  const double rings[] = {-0.5, -0.1, 0.1, 1.2};
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < kFaces; ++i) {
      const btVector3 a = corner(rings[k], i), b = corner(rings[k + 1], i), c = corner(rings[k + 1], i + 1),
                      d = corner(rings[k], i + 1);
      mesh->addTriangle(a, b, c);
      mesh->addTriangle(a, c, d);
    }
  bullet.add(std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true), 0, vec(0, 0, 0));
  bullet.meshes.push_back(std::move(mesh));
}

/// Points that are pressed into the groove between two faces touch both, also where they touched one at the
/// start of the tick. They were pressed through the other one, by a quarter of the radius.
TEST(Pipe, aTightBallStaysInside) {
  if (!kSurface) GTEST_SKIP() << "the points of a ball are not its surface";
  TriangleMesh sphere = small_meshes::icosphere(2);
  for (Vector3d& x : sphere.positions) x *= 0.1;
  const SharedNetwork network = solidNetwork(sphere, 60);
  for (const double tick : {1.0 / 120.0, 1.0 / 30.0}) {
    SoftWorld bullet(0.0);
    addPipe(bullet);
    SoftBodySettings s = *withMaterial(*network, {1e5, 0.4, 1000.0, 0.005});
    s.position = {-0.3, 0, 0};
    s.friction = 0.0;
    SoftBody* ball = bullet.addSoft(network, s);
    double outside = 0.0, farthest = 0.0;
    for (int i = 0; i < static_cast<int>(1.2 / tick) && farthest < 0.5; ++i) {
      const double force = 200.0 - 60.0 * ball->linearMomentum().x();
      ASSERT_TRUE(ball->applyForce(vec(force, 0, 0)));
      bullet.tick(tick);
      farthest = ball->centerOfMass().x();
      for (std::uint32_t p = 0; p < ball->pointCount(); ++p) {
        const Vector3d x = ball->position(p);
        outside = std::max(outside, std::hypot(x.y(), x.z()) - pipeRadius(x.x()));
      }
    }
    EXPECT_GT(farthest, 0.2) << tick;
    EXPECT_LT(outside, 1e-4) << tick;
  }
}

}  // namespace
}  // namespace limber::test
