// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "contact/box_surface.h"
#include "contact/contact_scene.h"

#include <algorithm>
#include <cmath>

namespace limber::bench {
namespace {

constexpr double kClothWidth = 2.4, kClothRadius = 0.01, kBallRadius = 0.75;  // m
constexpr double kGround = -2.0;                                              // m

/// Adds a ball at the origin, and a floor below for bodies that fall off.
void addBallAndFloor(RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
  addBox(rigid, world, {10, 1, 10}, 0, {0, kGround - 1, 0}, 0.5);
  auto shape = std::make_unique<btSphereShape>(static_cast<btScalar>(kBallRadius));
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape.get());
  info.m_friction = btScalar(1);
  rigid.bodies.push_back(std::make_unique<btRigidBody>(info));
  world.addRigidBody(rigid.bodies.back().get());
  rigid.shapes.push_back(std::move(shape));
}

/// Returns a cloth that falls onto a ball and hangs down from it, above the floor. The ratio of the dampers
/// to critical damping does not depend on the stiffness (N/m).
ContactScene clothScene(bool quick, const char* name, double stiffness, Crowd crowd) {
  const int side = quick ? 12 : 64;
  BodySetup cloth = bodyOf(clothNetwork(side), 0.6, stiffness, 0.5 * std::sqrt(stiffness / 500.0));
  cloth.settings.scale.setConstant(kClothWidth);
  cloth.settings.position = {0, kBallRadius + 2 * kClothRadius, 0};
  cloth.settings.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY());
  cloth.settings.pointRadius = kClothRadius;
  cloth.drag = 1.0;
  ContactScene scene;
  scene.name = name + std::to_string(side) + " x " + std::to_string(side);
  scene.role = Role::Cloth;
  scene.crowd = crowd;
  scene.bodies = {cloth};
  scene.addRigidBodies = addBallAndFloor;
  scene.distance = [](const Eigen::Vector3d& x) { return std::min(x.norm() - kBallRadius, x.y() - kGround); };
  scene.size = kClothWidth;
  scene.withBudgets = true;
  scene.settleTicks = quick ? 60 : 180;
  return scene;
}

/// Returns a cube of 1 m with many points and springs between all neighbours.
ContactScene denseScene(bool quick) {
  const int side = quick ? 4 : 17;  // 4913 points
  const double spacing = 1.0 / (side - 1);
  auto network = std::make_shared<SpringNetwork>(*latticeNetwork(side, side, side, spacing));
  network->surface = boxSurface(side);
  BodySetup body = bodyOf(network, 20.0, 500.0, 1.0);
  body.settings.pointRadius = 0.2 * spacing;
  body.settings.position = {-0.5, *body.settings.pointRadius + 1e-3, -0.5};
  body.drag = 1.0;
  ContactScene scene;
  scene.role = Role::Dense;
  scene.bodies = {body};
  scene.withBudgets = true;
  scene.name = "dense body of " + std::to_string(network->restPoints.size()) + " points";
  scene.addRigidBodies = [](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, Floor::Box, 0.5);
  };
  scene.distance = [](const Eigen::Vector3d& x) { return x.y(); };
  scene.settleTicks = 60;
  scene.measuredTicks = quick ? 20 : 40;
  return scene;
}

}  // namespace

void addLargeBodies(std::vector<ContactScene>& scenes, bool quick) {
  scenes.push_back(clothScene(quick, "cloth of ", 500.0, Crowd::Small));
  scenes.push_back(clothScene(quick, "soft cloth of ", 5.0, Crowd::Middle));
  scenes.push_back(clothScene(quick, "stiff cloth of ", 5e4, Crowd::Large));
  scenes.push_back(denseScene(quick));
}

}  // namespace limber::bench
