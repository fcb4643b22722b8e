// SPDX-License-Identifier: Zlib
#include "bullet_soft/body_start.h"
#include "results.h"
#include "scene/bodies.h"
#include "scene/rigid_bodies.h"
#include "stability/hard_case.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace limber::bench {
namespace {

constexpr double kMaxDrag = 2.0;                    // 1/s, so that a body with drag still falls
constexpr double kDragOfFalling = 2.0;              // 1/s: a body with drag must still fall
constexpr double kShortest = 2.0, kLongest = 60.0;  // s

}  // namespace

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

BodySetup hardCube(double stiffness, double damping, double size, double mass) {
  const double pointMass = mass / 8, critical = 2.0 * std::sqrt(stiffness * pointMass / 2.0);
  BodySetup body = bodyOf(closedCubeNetwork(), mass, stiffness, damping * critical);
  body.settings.scale.setConstant(size);
  return body;
}

Eigen::Matrix3Xd restPositions(const BodySetup& body) {
  const SoftBodySettings& s = body.settings;
  const auto& rest = body.network->restPoints;
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(rest.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = s.position + s.rotation * rest[static_cast<std::size_t>(i)].cwiseProduct(s.scale);
  return points;
}

double settleTime(const BodySetup& cube) {
  const auto& fractions = cube.network->massFractions;
  const double heaviest = cube.settings.totalMass * *std::max_element(fractions.begin(), fractions.end());
  const double k = cube.settings.extensionStiffness, c = cube.settings.damping;
  const double slowest = std::sqrt(k / heaviest);
  return 10.0 / std::min(0.5 * c / k * slowest * slowest, k / c);
}

HardCase caseOf(const std::string& group, const std::string& name, unsigned seed, const BodySetup& cube) {
  HardCase hard;
  hard.group = group;
  hard.name = group + " " + name;
  hard.seed = seed;
  hard.stiffness = cube.settings.extensionStiffness;
  hard.size = cube.settings.scale.x();
  hard.bodies = {cube};
  return hard;
}

void setFree(HardCase& hard, Dice& dice) {
  hard.freeFlight = true;
  const Eigen::Vector3d flight = 0.1 * hard.size * dice.direction();
  for (BodySetup& body : hard.bodies) {
    body.settings.linearVelocity += flight;
    if (body.velocities.cols()) body.velocities.colwise() += flight;
  }
}

void letSettle(HardCase& hard) {
  hard.recovers = true;
  BodySetup& body = hard.bodies[0];
  hard.seconds = wholeTicks(std::clamp(settleTime(body), kShortest, kLongest));
  body.drag = 20.0 / hard.seconds;
}

void letFall(HardCase& hard, double seconds) {
  hard.gravity.y() = -kGravity;
  hard.seconds = seconds;
  for (BodySetup& body : hard.bodies) body.drag = std::min(body.drag, kDragOfFalling);
}

std::string exponentName(const char* what, double value) { return format("%s %.0e", what, value); }

// --- obstacles and partners ---

namespace {

constexpr double kFriction = 1.0, kBoxExtent = 10.0, kMeshExtent = 6.0, kEdgeExtent = 100.0;
constexpr double kMaxDepth = 2.0;  // radii: largest depth at which a point may end

void addEdge(RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
  addBox(rigid, world, Eigen::Vector3d::Constant(kEdgeExtent), 0, {0, -kEdgeExtent * std::sqrt(2.0), 0},
         kFriction);
  btRigidBody& box = *rigid.bodies.back();
  const btVector3 centre = box.getWorldTransform().getOrigin();
  box.setWorldTransform(btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(std::atan(1.0))), centre));
  box.setInterpolationWorldTransform(box.getWorldTransform());
  world.updateSingleAabb(&box);
}

/// Adds triangles of half a metre, so that a cube touches several. With many more, btSoftBody takes too long
/// to remove them from its cache.
void addMesh(RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
  const int cells = 24;
  const double edge = 2.0 * kMeshExtent / cells;
  auto mesh = std::make_unique<btTriangleMesh>();
  const auto corner = [&](int i, int j) {
    return toBullet({i * edge - kMeshExtent + 0.1, 0, j * edge - kMeshExtent + 0.07});
  };
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      mesh->addTriangle(corner(i, j), corner(i, j + 1), corner(i + 1, j));
      mesh->addTriangle(corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1));
    }
  auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape.get());
  info.m_friction = btScalar(kFriction);
  rigid.bodies.push_back(std::make_unique<btRigidBody>(info));
  world.addRigidBody(rigid.bodies.back().get());
  rigid.shapes.push_back(std::move(shape));
  rigid.meshes.push_back(std::move(mesh));
}

void add(RigidBodies& rigid, btDiscreteDynamicsWorld& world, Obstacle obstacle, double scale) {
  switch (obstacle) {
    case Obstacle::Plane:
      return addFloor(rigid, world, Floor::Plane, kFriction);
    case Obstacle::Box:
      return addBox(rigid, world, scale * Eigen::Vector3d(kBoxExtent, 1, kBoxExtent), 0, {0, -scale, 0},
                    kFriction);
    case Obstacle::BoxEdge:
      return addEdge(rigid, world);
    case Obstacle::TriangleMesh:
      return addMesh(rigid, world);
  }
}

/// Returns the distance (m) of a position from the obstacle. It is below 0 inside, and where only a body that
/// passed through the obstacle can be.
double outside(Obstacle obstacle, double scale, const Eigen::Vector3d& x) {
  const double sideways = std::max(std::abs(x.x()), std::abs(x.z()));
  switch (obstacle) {
    case Obstacle::Plane:
      return x.y();
    case Obstacle::Box:
      return std::max(x.y(), sideways - scale * kBoxExtent);
    case Obstacle::BoxEdge:
      return std::max((x.y() + std::abs(x.z())) / std::sqrt(2.0), std::abs(x.x()) - kEdgeExtent);
    case Obstacle::TriangleMesh:
      return std::max(x.y(), sideways - kMeshExtent);
  }
  return 0.0;
}

void setCentre(btRigidBody& body, const Eigen::Vector3d& centre) {
  btTransform transform = btTransform::getIdentity();
  transform.setOrigin(toBullet(centre));
  body.setWorldTransform(transform);
}

}  // namespace

const char* nameOf(Obstacle obstacle) {
  const char* const names[] = {"plane", "box", "box edge", "triangle mesh"};
  return names[static_cast<int>(obstacle)];
}

void setObstacle(HardCase& hard, Obstacle obstacle, double scale) {
  hard.sees = obstacle != Obstacle::Plane;
  hard.lowest = obstacle == Obstacle::BoxEdge ? -kEdgeExtent : 0.0;
  hard.addRigidBodies = [=](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    add(rigid, world, obstacle, scale);
  };
  const double maxDepth = kMaxDepth * pointRadius(*hard.bodies[0].network, hard.bodies[0].settings);
  hard.allowed = [=](const Eigen::Vector3d& x) { return outside(obstacle, scale, x) >= -maxDepth; };
}

double Press::heightAt(double time) const {
  const double downHeight = std::max(gap, top - down * time);
  return downHeight + up * std::max(0.0, time - leaves());
}

void addPress(HardCase& hard, const Press& press) {
  const double half = 0.5;
  const auto centreAt = [=](double time) { return Eigen::Vector3d(0, press.heightAt(time) + half, 0); };
  const auto addFirst = hard.addRigidBodies;
  hard.addRigidBodies = [=](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFirst(rigid, world);
    addBox(rigid, world, {kBoxExtent, half, kBoxExtent}, 0, centreAt(0.0), kFriction);
    btRigidBody& plate = *rigid.bodies.back();
    world.removeRigidBody(&plate);
    plate.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    plate.setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(&plate);
  };
  hard.drive = [=](const RigidBodies& rigid, double time) {
    setCentre(*rigid.bodies.back(), centreAt(time));
  };
  hard.energyFrom = press.leaves();
}

void addFallingBox(HardCase& hard, double mass, double height) {
  const Eigen::Vector3d half(0.7, 0.2, 0.7);
  const auto addFirst = hard.addRigidBodies;
  hard.addRigidBodies = [=](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFirst(rigid, world);
    addBox(rigid, world, half, mass, {0.05, height + half.y(), -0.03}, kFriction);
  };
}

}  // namespace limber::bench
