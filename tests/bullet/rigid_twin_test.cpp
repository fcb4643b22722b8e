// SPDX-License-Identifier: Zlib
// A soft cube collides with every shape of Bullet. A rigid cube of the same size and mass in the same
// situation must behave alike.
#include "fuzz/bullet_shapes.h"
#include "support/soft_world.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>

namespace limber::test {
namespace {

using Eigen::Vector3d;
using fuzz::OwnedShape;

constexpr double kHalf = 0.15;        ///< m, of both cubes; includes the radius of the soft one's points
constexpr double kTwinRadius = 0.01;  ///< m, of the soft cube's points

struct ShapeCase {
  const char* name;
  Vector3d size;      ///< m
  Vector3d rotation;  ///< turns up a flat or broad side on which a cube can lie
  bool round;         ///< touches a cube in one point or along a line
};

const Vector3d kUpright(0, 0, 0), kUpsideDown(3.14159265358979, 0, 0);

std::vector<ShapeCase> convexCases() {
  const Vector3d half(0.5, 0.3, 0.5), ball(0.5, 0.5, 0.5);
  return {{"box", half, kUpright, false},
          {"sphere", ball, kUpright, true},
          {"capsule-x", ball, kUpright, true},
          {"capsule-y", ball, kUpright, true},
          {"capsule-z", ball, kUpright, true},
          {"cylinder-x", ball, kUpright, true},
          {"cylinder-y", half, kUpright, false},
          {"cylinder-z", ball, kUpright, true},
          {"cone-y", half, kUpsideDown, false},
          {"multi-sphere", Vector3d(1, 1, 1), kUpright, true},
          {"tetrahedron", half, kUpsideDown, false},
          {"triangle-hull", half, kUpright, false},
          {"scaled", half, kUpright, false},
          {"gimpact", half, kUpright, false}};
}

std::vector<ShapeCase> concaveCases() {
  const Vector3d flat(0.5, 0.3, 0.5);
  return {{"plane", flat, kUpright, false},
          {"mesh", flat, kUpright, false},
          {"scaled-mesh", flat, kUpright, false},
          {"height-field", flat, kUpright, false}};
}

/// A world with one object of the shape, and a rigid or a soft cube above it.
struct TwinWorld {
  explicit TwinWorld(double gravity) : bullet(gravity) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&bullet.dispatcher);
  }

  btRigidBody* addShape(const ShapeCase& shape, double mass, const btVector3& position) {
    owned = fuzz::makeShape(shape.name, shape.size, 0);
    btVector3 inertia(0, 0, 0);
    if (mass > 0) owned.shape->calculateLocalInertia(static_cast<btScalar>(mass), inertia);
    body = std::make_unique<btRigidBody>(static_cast<btScalar>(mass), nullptr, owned.shape.get(), inertia);
    body->setWorldTransform(btTransform(fuzz::rotationOf(shape.rotation), position));
    bullet.world->addRigidBody(body.get());
    return body.get();
  }
  ~TwinWorld() {
    system.removeAll();
    bullet.world->removeRigidBody(body.get());
  }

  /// Returns the height (m) at which a ray from above hits the object.
  double top() const {
    btCollisionWorld::ClosestRayResultCallback hit(vec(0.01, 5, 0.02), vec(0.01, -5, 0.02));
    bullet.world->rayTest(hit.m_rayFromWorld, hit.m_rayToWorld, hit);
    return double(hit.m_hitPointWorld.y());
  }

  btRigidBody* addRigidCube(const Vector3d& position) {
    return bullet.addBox(vec(kHalf, kHalf, kHalf), 1.0, fuzz::toBt(position));
  }
  SoftBody* addSoftCube(const Vector3d& position, double stiffness) {
    SoftBodySettings s;
    s.position = position;
    s.scale = Vector3d::Constant(2.0 * (kHalf - kTwinRadius));
    s.pointRadius = kTwinRadius;
    setSprings(s, stiffness, 20.0);
    return *system.createBody(closedCubeNetwork(), s);
  }

  BulletWorld bullet;
  OwnedShape owned;
  std::unique_ptr<btRigidBody> body;
  SoftBodySystem system{*bullet.world};
};

/// Returns the height (m) of a cube's centre above the shape's top, after a fall from 2 cm above.
double restOfRigidCube(const ShapeCase& shape) {
  TwinWorld twin(-9.81);
  twin.addShape(shape, 0, vec(0, 0, 0));
  const double top = twin.top();
  const btRigidBody* cube = twin.addRigidCube({0, top + kHalf + 0.02, 0});
  twin.bullet.simulate(1.0);
  return heightOf(*cube) - top;
}

double restOfSoftCube(const ShapeCase& shape) {
  TwinWorld twin(-9.81);
  twin.addShape(shape, 0, vec(0, 0, 0));
  const double top = twin.top();
  // round shapes press into the middle of a face, which yields until its springs are stretched
  const SoftBody* cube = twin.addSoftCube({0, top + kHalf + 0.02, 0}, shape.round ? 1e5 : 1e4);
  twin.bullet.simulate(1.0);
  return cube->centerOfMass().y() - top;
}

TEST(SurfaceTwin, restsOnEveryStaticShapeAsARigidCubeDoes) {
  std::vector<ShapeCase> cases = convexCases();
  for (const ShapeCase& shape : concaveCases()) cases.push_back(shape);
  for (const ShapeCase& shape : cases) {
    const double rigid = restOfRigidCube(shape), soft = restOfSoftCube(shape);
    // Bullet's cube sinks in by millimetres, or floats on a margin; a flat soft face sags by m g / k. A point
    // in the middle of a face of diagonal 0.4 m sinks in by (m g L^2 / k)^(1/3) = 1.6 cm
    EXPECT_GT(soft, 0.1) << shape.name;
    if (rigid < -1.0) continue;  // in double precision Bullet's cube falls through a hull of triangles
    EXPECT_NEAR(soft, rigid, shape.round ? 0.03 : 0.011) << shape.name;
  }
}

/// A shape of 3 kg flies at 3 m/s along x into a cube of 1 kg at rest.
struct HitResult {
  double cubeSpeed, partnerSpeed, distance;
};

HitResult hitRigidCube(const ShapeCase& shape) {
  TwinWorld twin(0.0);
  btRigidBody* partner = twin.addShape(shape, 3.0, vec(0, 0, 0));
  btRigidBody* cube = twin.addRigidCube({2.0, 0, 0});
  partner->setLinearVelocity(vec(3, 0, 0));
  twin.bullet.simulate(1.0);
  return {double(cube->getLinearVelocity().x()), double(partner->getLinearVelocity().x()),
          double(cube->getCenterOfMassPosition().x() - partner->getCenterOfMassPosition().x())};
}

HitResult hitSoftCube(const ShapeCase& shape) {
  TwinWorld twin(0.0);
  btRigidBody* partner = twin.addShape(shape, 3.0, vec(0, 0, 0));
  const SoftBody* cube = twin.addSoftCube({2.0, 0, 0}, 1e4);
  partner->setLinearVelocity(vec(3, 0, 0));
  twin.bullet.simulate(1.0);
  return {cube->linearMomentum().x() / cube->totalMass(), double(partner->getLinearVelocity().x()),
          cube->centerOfMass().x() - double(partner->getCenterOfMassPosition().x())};
}

TEST(SurfaceTwin, isHitByEveryDynamicShapeAsARigidCubeIs) {
  for (ShapeCase shape : convexCases()) {
    // these shapes would deflect the cube sideways
    if (std::string(shape.name) == "cone-y" || std::string(shape.name) == "tetrahedron") continue;
    const HitResult rigid = hitRigidCube(shape), soft = hitSoftCube(shape);
    EXPECT_NEAR(soft.cubeSpeed + 3.0 * soft.partnerSpeed, 9.0, 9e-3) << shape.name << ": momentum, floats";
    // plastic 2.25 m/s, elastic 4.5 m/s; an off-centre impact also rotates the cube
    EXPECT_GT(soft.cubeSpeed, 0.7 * rigid.cubeSpeed) << shape.name;
    EXPECT_LT(soft.cubeSpeed, 4.5 + 1e-3) << shape.name << ": no more than elastic";
    EXPECT_GT(soft.distance, kHalf) << shape.name << ": it has passed through";
  }
}

/// Returns the lowest height (m) in a second of an octahedron's centre that falls, a corner first, onto the
/// middle of a face of a soft cube.
double lowestOctahedron(bool gimpact) {
  constexpr double kCornerDistance = 0.3;  // m
  btTriangleMesh mesh;
  btConvexHullShape hull;
  for (int i = 0; i < 8; ++i) {
    const btVector3 x = vec(i & 1 ? kCornerDistance : -kCornerDistance, 0, 0),
                    y = vec(0, i & 2 ? kCornerDistance : -kCornerDistance, 0),
                    z = vec(0, 0, i & 4 ? kCornerDistance : -kCornerDistance);
    mesh.addTriangle(x, y, z);
    for (const btVector3& corner : {x, y, z}) hull.addPoint(corner);
  }
  btGImpactMeshShape shell(&mesh);
  shell.setMargin(btScalar(0.01));
  shell.updateBound();
  hull.setMargin(btScalar(0.01));
  btCollisionShape& shape = gimpact ? static_cast<btCollisionShape&>(shell) : hull;
  TwinWorld twin(-9.81);
  twin.bullet.addBoxFloor();
  SoftBodySettings s;
  s.position = {0, 0.55, 0};
  s.extensionStiffness = s.compressionStiffness = 5000.0;
  twin.system.createBody(cubeNetwork(), s);
  btVector3 inertia;
  hull.calculateLocalInertia(btScalar(0.5), inertia);
  twin.body = std::make_unique<btRigidBody>(btScalar(0.5), nullptr, &shape, inertia);
  twin.body->setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(0.1, 1.5, 0.05)));
  twin.bullet.world->addRigidBody(twin.body.get());
  double lowest = 1.5;
  for (int tick = 0; tick < 60; ++tick) {
    twin.bullet.tick();
    lowest = std::min(lowest, double(twin.body->getWorldTransform().getOrigin().y()));
  }
  return lowest;
}

TEST(SurfaceTwin, aGImpactMeshDoesNotFallThroughAFace) {
  const double hull = lowestOctahedron(false), mesh = lowestOctahedron(true);
  EXPECT_GT(mesh, 1.1) << "a corner first, it stays on the cube of 1 m until it topples";
  EXPECT_NEAR(mesh, hull, 0.05) << "a mesh is a sheet, a hull solid";
}

}  // namespace
}  // namespace limber::test
