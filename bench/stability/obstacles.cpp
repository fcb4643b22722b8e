// SPDX-License-Identifier: Zlib
#include "stability/obstacles.h"

#include "accuracy/rigid_bodies.h"
#include "engines/body_start.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace limber::bench {
namespace {

constexpr double kFriction = 1.0, kBoxReach = 10.0, kMeshReach = 6.0, kEdgeReach = 100.0;
constexpr double kDepths = 2.0;  // radii that a point may end inside

void addEdge(RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
  addBox(rigid, world, Eigen::Vector3d::Constant(kEdgeReach), 0, {0, -kEdgeReach * std::sqrt(2.0), 0},
         kFriction);
  btRigidBody& box = *rigid.bodies.back();
  const btVector3 centre = box.getWorldTransform().getOrigin();
  box.setWorldTransform(btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(std::atan(1.0))), centre));
  box.setInterpolationWorldTransform(box.getWorldTransform());
  world.updateSingleAabb(&box);
}

/// Triangles of half a metre, so that a cube meets several; many more, and btSoftBody forgets them too
/// slowly.
void addMesh(RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
  const int cells = 24;
  const double edge = 2.0 * kMeshReach / cells;
  auto mesh = std::make_unique<btTriangleMesh>();
  const auto corner = [&](int i, int j) {
    return toBullet({i * edge - kMeshReach + 0.1, 0, j * edge - kMeshReach + 0.07});
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
      return addBox(rigid, world, scale * Eigen::Vector3d(kBoxReach, 1, kBoxReach), 0, {0, -scale, 0},
                    kFriction);
    case Obstacle::BoxEdge:
      return addEdge(rigid, world);
    case Obstacle::TriangleMesh:
      return addMesh(rigid, world);
  }
}

/// m, how far outside the obstacle a place is; below 0: inside, or where only what has gone through can be.
double outside(Obstacle obstacle, double scale, const Eigen::Vector3d& x) {
  const double aside = std::max(std::abs(x.x()), std::abs(x.z()));
  switch (obstacle) {
    case Obstacle::Plane:
      return x.y();
    case Obstacle::Box:
      return std::max(x.y(), aside - scale * kBoxReach);
    case Obstacle::BoxEdge:
      return std::max((x.y() + std::abs(x.z())) / std::sqrt(2.0), std::abs(x.x()) - kEdgeReach);
    case Obstacle::TriangleMesh:
      return std::max(x.y(), aside - kMeshReach);
  }
  return 0.0;
}

void place(btRigidBody& body, const Eigen::Vector3d& centre) {
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
  hard.lowest = obstacle == Obstacle::BoxEdge ? -kEdgeReach : 0.0;
  hard.addRigidBodies = [=](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    add(rigid, world, obstacle, scale);
  };
  const double deepest = kDepths * pointRadius(*hard.bodies[0].network, hard.bodies[0].settings);
  hard.allowed = [=](const Eigen::Vector3d& x) { return outside(obstacle, scale, x) >= -deepest; };
}

double Press::heightAt(double time) const {
  const double lowered = std::max(gap, top - down * time);
  return lowered + up * std::max(0.0, time - leaves());
}

void addPress(HardCase& hard, const Press& press) {
  const double half = 0.5;
  const auto centreAt = [=](double time) { return Eigen::Vector3d(0, press.heightAt(time) + half, 0); };
  const auto addFirst = hard.addRigidBodies;
  hard.addRigidBodies = [=](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFirst(rigid, world);
    addBox(rigid, world, {kBoxReach, half, kBoxReach}, 0, centreAt(0.0), kFriction);
    btRigidBody& plate = *rigid.bodies.back();
    world.removeRigidBody(&plate);
    plate.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    plate.setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(&plate);
  };
  hard.drive = [=](const RigidBodies& rigid, double time) { place(*rigid.bodies.back(), centreAt(time)); };
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
