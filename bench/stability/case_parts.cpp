// SPDX-License-Identifier: Zlib
#include "results.h"
#include "stability/stability.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace limber::bench {
namespace {

constexpr double kDragOfFalling = 2.0;              // 1/s: a body with drag must still fall
constexpr double kShortest = 2.0, kLongest = 60.0;  // s

}  // namespace

BodySetup hardCube(double stiffness, double damping, double size, double mass) {
  const double pointMass = mass / 8, critical = 2.0 * std::sqrt(stiffness * pointMass / 2.0);
  BodySetup body = bodyOf(closedCubeNetwork(), mass, stiffness, damping * critical);
  body.settings.scale.setConstant(size);
  return body;
}

Eigen::Matrix3Xd restPositions(const BodySetup& body) {
  BodySetup atRest = body;
  atRest.positions.resize(3, 0);
  return startOf(atRest).positions;
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

// --- obstacles and partners ---

namespace {

constexpr double kFriction = 1.0, kBoxExtent = 10.0, kMeshExtent = 6.0, kEdgeExtent = 100.0;
constexpr double kMaxDepth = 2.0;  // radii: largest depth at which a point may end

void addEdge(RigidBodies& rigid) {
  const Eigen::Vector3d centre(0, -kEdgeExtent * std::sqrt(2.0), 0);
  btRigidBody& box = addBox(rigid, Eigen::Vector3d::Constant(kEdgeExtent), 0, centre, kFriction);
  const btQuaternion turn(btVector3(1, 0, 0), btScalar(std::atan(1.0)));
  box.setWorldTransform(btTransform(turn, toBullet(centre)));
  box.setInterpolationWorldTransform(box.getWorldTransform());
  rigid.world->updateSingleAabb(&box);
}

void add(RigidBodies& rigid, Obstacle obstacle, double scale) {
  if (obstacle == Obstacle::Plane) addFloor(rigid, Floor::Plane, kFriction);
  if (obstacle == Obstacle::Box)
    addBox(rigid, scale * Eigen::Vector3d(kBoxExtent, 1, kBoxExtent), 0, {0, -scale, 0}, kFriction);
  if (obstacle == Obstacle::BoxEdge) addEdge(rigid);
  // triangles of half a metre, so that a cube touches several; with many more, btSoftBody takes too long to
  // remove them from its cache
  if (obstacle == Obstacle::TriangleMesh)
    addMesh(rigid, 0.1 - kMeshExtent, 0.07 - kMeshExtent, 24, 24, kMeshExtent / 12, kFriction);
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

}  // namespace

const char* nameOf(Obstacle obstacle) {
  const char* const names[] = {"plane", "box", "box edge", "triangle mesh"};
  return names[static_cast<int>(obstacle)];
}

void setObstacle(HardCase& hard, Obstacle obstacle, double scale) {
  hard.sees = obstacle != Obstacle::Plane;
  hard.lowest = obstacle == Obstacle::BoxEdge ? -kEdgeExtent : 0.0;
  hard.addRigidBodies = [=](RigidBodies& rigid) { add(rigid, obstacle, scale); };
  const double maxDepth = kMaxDepth * pointRadius(*hard.bodies[0].network, hard.bodies[0].settings);
  hard.allowed = [=](const Eigen::Vector3d& x) { return outside(obstacle, scale, x) >= -maxDepth; };
}

void addPress(HardCase& hard, double gap) {
  constexpr double kTop = 1.3;              // m, initial height of its lower face
  constexpr double kDown = 1.0, kUp = 4.0;  // m/s
  constexpr double kHalf = 0.5;             // m, half its thickness
  const double leaves = (kTop - gap) / kDown + 0.5;
  const auto centreAt = [=](double time) {
    const double lower = std::max(gap, kTop - kDown * time) + kUp * std::max(0.0, time - leaves);
    return Eigen::Vector3d(0, lower + kHalf, 0);
  };
  const auto addFirst = hard.addRigidBodies;
  hard.addRigidBodies = [=](RigidBodies& rigid) {
    addFirst(rigid);
    btRigidBody& plate = addBox(rigid, {kBoxExtent, kHalf, kBoxExtent}, 0, centreAt(0.0), kFriction);
    rigid.world->removeRigidBody(&plate);
    plate.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    plate.setActivationState(DISABLE_DEACTIVATION);
    rigid.world->addRigidBody(&plate);
  };
  hard.drive = [=](const RigidBodies& rigid, double time) {
    rigid.bodies.back()->setWorldTransform(
        btTransform(btQuaternion::getIdentity(), toBullet(centreAt(time))));
  };
  hard.energyFrom = leaves;
}

void addFallingBox(HardCase& hard, double mass, double height) {
  const Eigen::Vector3d half(0.7, 0.2, 0.7);
  const auto addFirst = hard.addRigidBodies;
  hard.addRigidBodies = [=](RigidBodies& rigid) {
    addFirst(rigid);
    addBox(rigid, half, mass, {0.05, height + half.y(), -0.03}, kFriction);
  };
}

}  // namespace limber::bench
