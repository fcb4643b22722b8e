// SPDX-License-Identifier: Zlib
#include "scene/scene.h"

#include "scene/reference.h"
#include "support/networks.h"

#include <limber/network_builder.h>

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>

#include <cstring>
#include <utility>

namespace limber::bench {

// --- rigid bodies ---

btRigidBody& addBody(RigidBodies& rigid, std::unique_ptr<btCollisionShape> shape, double mass,
                     const Eigen::Vector3d& centre, double friction) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0) shape->calculateLocalInertia(static_cast<btScalar>(mass), inertia);
  btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, shape.get(), inertia);
  info.m_startWorldTransform.setIdentity();
  info.m_startWorldTransform.setOrigin(toBullet(centre));
  info.m_friction = static_cast<btScalar>(friction);
  btRigidBody& body = *rigid.bodies.emplace_back(std::make_unique<btRigidBody>(info));
  if (mass > 0) body.setActivationState(DISABLE_DEACTIVATION);
  rigid.world->addRigidBody(&body);
  rigid.shapes.push_back(std::move(shape));
  return body;
}

btRigidBody& addBox(RigidBodies& rigid, const Eigen::Vector3d& halfSize, double mass,
                    const Eigen::Vector3d& centre, double friction) {
  return addBody(rigid, std::make_unique<btBoxShape>(toBullet(halfSize)), mass, centre, friction);
}

void addMesh(RigidBodies& rigid, double x, double z, int nx, int nz, double size, double friction) {
  auto mesh = std::make_unique<btTriangleMesh>();
  const auto corner = [&](int i, int j) { return toBullet({x + i * size, 0, z + j * size}); };
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < nz; ++j) {
      mesh->addTriangle(corner(i, j), corner(i, j + 1), corner(i + 1, j));
      mesh->addTriangle(corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1));
    }
  addBody(rigid, std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true), 0, {0, 0, 0}, friction);
  rigid.meshes.push_back(std::move(mesh));
}

namespace {

std::unique_ptr<btConvexHullShape> hull(const Eigen::Vector3d& half) {
  auto shape = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < 8; ++i)
    shape->addPoint(
        toBullet({i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z()}));
  return shape;
}

// --- tiled floors ------------------------------------------------------------------------------------------

constexpr int kTilesAlong = 17, kTilesAcross = 8;  // of 1 m
constexpr double kFirstX = -4.0, kFirstZ = -4.0;   // m
const Eigen::Vector3d kHalfTile(0.5, 0.5, 0.5);

/// Calls visit(centre) for each tile; the tiles' tops are y = 0.
template <class Visit>
void forEachTile(Visit visit) {
  for (int i = 0; i < kTilesAlong; ++i)
    for (int j = 0; j < kTilesAcross; ++j)
      visit(Eigen::Vector3d(kFirstX + i + 0.5, -kHalfTile.y(), kFirstZ + j + 0.5));
}

std::unique_ptr<btCollisionShape> heightField() {
  static const std::vector<float> kFlat((kTilesAlong + 1) * (kTilesAcross + 1), 0.0f);
  return std::make_unique<btHeightfieldTerrainShape>(kTilesAlong + 1, kTilesAcross + 1, kFlat.data(),
                                                     btScalar(1), btScalar(-1), btScalar(1), 1, PHY_FLOAT,
                                                     false);
}

std::unique_ptr<btCollisionShape> compound(RigidBodies& rigid) {
  auto tile = std::make_unique<btBoxShape>(toBullet(kHalfTile));
  auto shape = std::make_unique<btCompoundShape>();
  forEachTile([&](const Eigen::Vector3d& centre) {
    shape->addChildShape(btTransform(btQuaternion::getIdentity(), toBullet(centre)), tile.get());
  });
  rigid.shapes.push_back(std::move(tile));
  return shape;
}

}  // namespace

void addFloor(RigidBodies& rigid, Floor floor, double friction) {
  const auto add = [&](std::unique_ptr<btCollisionShape> shape, const Eigen::Vector3d& centre) {
    addBody(rigid, std::move(shape), 0, centre, friction);
  };
  switch (floor) {
    case Floor::Plane:
      return add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)), {0, 0, 0});
    case Floor::Box:
      return add(std::make_unique<btBoxShape>(btVector3(10, 1, 10)), {0, -1, 0});
    case Floor::Hull: {
      auto shape = hull({10, 1, 10});
      const double margin = double(shape->getMargin());
      return add(std::move(shape), {0, -1 - margin, 0});
    }
    case Floor::TriangleMesh:
      // the points of a cube stand on different triangles
      return addMesh(rigid, -3.7, -3.7, 20, 20, 0.37, friction);
    case Floor::CoarseMesh:
      return addMesh(rigid, kFirstX, kFirstZ, kTilesAlong, kTilesAcross, 1.0, friction);
    case Floor::FineMesh:
      return addMesh(rigid, kFirstX, kFirstZ, 10 * kTilesAlong, 10 * kTilesAcross, 0.1, friction);
    case Floor::HeightField:
      return add(heightField(), {kFirstX + 0.5 * kTilesAlong, 0, kFirstZ + 0.5 * kTilesAcross});
    case Floor::Boxes:
      return forEachTile(
          [&](const Eigen::Vector3d& centre) { addBox(rigid, kHalfTile, 0, centre, friction); });
    case Floor::Compound:
      return add(compound(rigid), {0, 0, 0});
    case Floor::Hulls:
      return forEachTile([&](const Eigen::Vector3d& centre) {
        auto shape = hull(kHalfTile);
        shape->setMargin(0);
        add(std::move(shape), centre);
      });
  }
}

// --- soft bodies ---

namespace {

std::shared_ptr<SpringNetwork> withPoints(NetworkKind kind, std::vector<Eigen::Vector3d> points) {
  auto network = std::make_shared<SpringNetwork>();
  network->kind = kind;
  network->massFractions.assign(points.size(), 1.0 / static_cast<double>(points.size()));
  network->restPoints = std::move(points);
  return network;
}

std::shared_ptr<SpringNetwork> line(int links, const Eigen::Vector3d& direction) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= links; ++i) points.push_back(direction * i / links);
  auto network = withPoints(NetworkKind::Rope, std::move(points));
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(links); ++i)
    network->springs.push_back({i, i + 1, SpringKind::Structural, 1.0});
  return network;
}

/// Adds springs between all points nearer than `maxLength`.
void connect(SpringNetwork& network, double maxLength) {
  const auto count = static_cast<std::uint32_t>(network.restPoints.size());
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      if ((network.restPoints[a] - network.restPoints[b]).norm() < maxLength)
        network.springs.push_back({a, b, SpringKind::Structural, 1.0});
}

bool isUpper(Eigen::Index point) { return (point & 2) != 0; }  // in the order of cubeNetwork()

}  // namespace

SharedNetwork pairNetwork() { return line(1, Eigen::Vector3d::UnitX()); }
SharedNetwork chainNetwork(int links) { return line(links, -Eigen::Vector3d::UnitY()); }
SharedNetwork barNetwork(int links) { return line(links, Eigen::Vector3d::UnitX()); }

SharedNetwork loadedChainNetwork(int links, double ratio) {
  auto network = line(links, -Eigen::Vector3d::UnitY());
  const double sum = links + ratio;
  for (double& share : network->massFractions) share = 1.0 / sum;
  network->massFractions.back() = ratio / sum;
  return network;
}

SharedNetwork cubeNetwork() { return test::fullCubeNetwork(); }

SharedNetwork closedCubeNetwork() {
  auto network = std::make_shared<SpringNetwork>(*cubeNetwork());
  // two triangles per face, oriented outward
  network->surface = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return network;
}

SharedNetwork latticeNetwork(int nx, int ny, int nz, double spacing, double reach) {
  std::vector<Eigen::Vector3d> points;
  for (int x = 0; x < nx; ++x)
    for (int y = 0; y < ny; ++y)
      for (int z = 0; z < nz; ++z) points.push_back(spacing * Eigen::Vector3d(x, y, z));
  auto network = withPoints(NetworkKind::Solid, std::move(points));
  connect(*network, reach * spacing);
  return network;
}

SharedNetwork clothNetwork(int side) {
  ClothSettings settings;
  settings.columns = settings.rows = static_cast<std::uint32_t>(side - 1);
  settings.shearScale = settings.bendingScale = 1.0;
  return *buildCloth(settings);
}

BodySetup bodyOf(SharedNetwork network, double mass, double stiffness, double damping) {
  BodySetup body;
  body.network = std::move(network);
  body.settings.totalMass = mass;
  body.settings.extensionStiffness = body.settings.compressionStiffness = stiffness;
  body.settings.damping = damping;
  return body;
}

// --- a cube at rest ---

BodySetup restingCube(double stiffness) {
  BodySetup body = bodyOf(closedCubeNetwork(), 1.0, stiffness, 0.2 * std::sqrt(stiffness / 8));
  body.settings.pointRadius = kCubeRadius;
  body.settings.position = {0.1, 0.5 + kCubeRadius, 0.05};
  body.drag = 2.0;
  return body;
}

double topOf(const Eigen::Matrix3Xd& cube) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < 8; ++i)
    if (isUpper(i)) sum += cube(1, i);
  return sum / 4;
}

double restHeight(const BodySetup& cube, double load) {
  SpringSystem system = systemOf(cube, {0, -kGravity, 0});
  for (Eigen::Index i = 0; i < 8; ++i) {
    if (isUpper(i)) {
      system.load(1, i) -= load / 4;
    } else {
      system.free(1, i) = 0.0;
      system.start.positions(1, i) = kCubeRadius;
    }
  }
  return topOf(equilibrium(system));
}

// --- random numbers ---

double Dice::within(double limit) { return limit * (2.0 * (double(engine_()) / 4294967296.0) - 1.0); }

Eigen::Vector3d Dice::vector(double limit) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = within(limit);
  return v;
}

Eigen::Matrix3Xd Dice::vectors(Eigen::Index count, double limit) {
  Eigen::Matrix3Xd all(3, count);
  for (Eigen::Index i = 0; i < count; ++i) all.col(i) = vector(limit);
  return all;
}

Eigen::Vector3d Dice::direction() {
  Eigen::Vector3d v = vector(1.0);
  while (v.squaredNorm() > 1.0 || v.squaredNorm() < 0.01) v = vector(1.0);
  return v.normalized();
}

Eigen::Quaterniond Dice::rotation() {
  const double angle = within(3.1);
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, direction()));
}

// --- scenes ---

std::unique_ptr<Engine> open(const Scenario& scenario, const EngineChoice& choice, const EngineUse& use,
                             RigidBodies& rigid) {
  std::unique_ptr<Engine> engine = choice.make(use);
  engine->world().setGravity(toBullet(scenario.gravity));
  rigid.world = &engine->world();
  if (scenario.addRigidBodies) scenario.addRigidBodies(rigid);
  for (const BodySetup& body : scenario.bodies) engine->addBody(body);
  return engine;
}

BodyStates statesOf(const Scenario& scenario, const Engine& engine) {
  BodyStates states;
  for (std::size_t i = 0; i < scenario.bodies.size(); ++i) {
    states.positions.push_back(engine.positions(i));
    states.velocities.push_back(engine.velocities(i));
  }
  return states;
}

bool isLost(const BodyStates& states, double distance) {
  for (std::size_t i = 0; i < states.positions.size(); ++i) {
    const Eigen::Matrix3Xd& x = states.positions[i];
    if (!x.allFinite() || !states.velocities[i].allFinite() || x.cwiseAbs().maxCoeff() > distance)
      return true;
  }
  return false;
}

void addToHash(std::uint64_t& hash, const Eigen::Matrix3Xd& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, values.data() + i, sizeof bits);
    hash = (hash ^ bits) * 1099511628211ull;
  }
}

}  // namespace limber::bench
