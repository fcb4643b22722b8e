// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engines.h"

#include <limber/spring_network.h>

#include <cmath>
#include <limits>
#include <random>

namespace limber::bench {

constexpr double kGravity = 9.81;  // m/s^2
constexpr double kLost = std::numeric_limits<double>::infinity();

// --- rigid bodies ---

/// The rigid bodies of a run, which outlive their world.
struct RigidBodies {
  btDiscreteDynamicsWorld* world = nullptr;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btStridingMeshInterface>> meshes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
};

/// Adds a body with this shape and centre; with mass 0 it is static.
btRigidBody& addBody(RigidBodies& rigid, std::unique_ptr<btCollisionShape> shape, double mass,
                     const Eigen::Vector3d& centre, double friction);

btRigidBody& addBox(RigidBodies& rigid, const Eigen::Vector3d& halfSize, double mass,
                    const Eigen::Vector3d& centre, double friction);

/// Adds a static mesh of nx x nz cells of `size` (m), two triangles each, from the corner (x, 0, z) on.
void addMesh(RigidBodies& rigid, double x, double z, int nx, int nz, double size, double friction);

/// Those from CoarseMesh on are cut into tiles of 1 m, FineMesh into ones of 0.1 m: triangles of a mesh,
/// cells of a height field, bodies side by side, children of one body.
enum class Floor : std::uint8_t {
  Plane,
  Box,
  Hull,
  TriangleMesh,
  CoarseMesh,
  FineMesh,
  HeightField,
  Boxes,
  Compound,
  Hulls
};

/// Adds a floor whose top is y = 0. It reaches at least 3 m from the origin, a tiled one 4 m, and 13 m along
/// x. btSoftBody does not collide with planes.
void addFloor(RigidBodies& rigid, Floor floor, double friction);

// --- soft bodies ---

SharedNetwork pairNetwork();            ///< two points 1 m apart along x, one spring
SharedNetwork chainNetwork(int links);  ///< 1 m down from the origin, equal links; point 0 is the top
/// Returns a chain whose last point has `ratio` times the mass of each of the others.
SharedNetwork loadedChainNetwork(int links, double ratio);
SharedNetwork barNetwork(int links);  ///< 1 m along x from the origin, equal links
SharedNetwork cubeNetwork();          ///< the unit cube about the origin, springs between all 28 pairs
SharedNetwork closedCubeNetwork();    ///< cubeNetwork() with a surface, for engines that collide faces
/// Returns a box of points along x, y, z from the origin, with springs to all neighbours within `reach` times
/// the spacing: 1.8 is between the diagonal of a cell and the next neighbour, so 26 of them.
SharedNetwork latticeNetwork(int nx, int ny, int nz, double spacing, double reach = 1.8);
SharedNetwork clothNetwork(int side);  ///< a square metre of side x side points, all springs equal

/// Returns a set-up of a body with these properties; both stiffnesses are `stiffness`.
BodySetup bodyOf(SharedNetwork network, double mass, double stiffness, double damping = 0.0);

// --- a cube at rest ---

constexpr double kCubeRadius = 0.02;  // m, of its points

/// Returns a closed unit cube of 1 kg that stands on y = 0, slightly damped.
BodySetup restingCube(double stiffness);

double topOf(const Eigen::Matrix3Xd& cube);  ///< m, mean height of its upper four points

/// Returns the height (m) of the cube's top at rest under a load (N), by statics alone. Its lower points can
/// slide on the floor but not leave it.
double restHeight(const BodySetup& cube, double load);

/// Random numbers that are the same with every standard library.
class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double within(double limit);  ///< -limit to limit
  Eigen::Vector3d vector(double limit);
  Eigen::Matrix3Xd vectors(Eigen::Index count, double limit);
  Eigen::Quaterniond rotation();
  Eigen::Vector3d direction();

 private:
  std::mt19937 engine_;
};

// --- scenes ---

/// Bodies, obstacles and forces: the part of a scene that all benches have.
struct Scenario {
  std::string name;
  Eigen::Vector3d gravity = {0, -kGravity, 0};
  std::vector<BodySetup> bodies;
  std::function<void(RigidBodies&)> addRigidBodies;  ///< or empty
};

/// Sets up a scenario in an engine. `rigid` must outlive the engine. Throws std::runtime_error with the
/// reason if the engine does not support it.
std::unique_ptr<Engine> open(const Scenario& scenario, const EngineChoice& choice, const EngineUse& use,
                             RigidBodies& rigid);

/// The points of all bodies at one time.
struct BodyStates {
  std::vector<Eigen::Matrix3Xd> positions, velocities;  ///< #bodies; m and m/s
};

BodyStates statesOf(const Scenario& scenario, const Engine& engine);

/// Returns whether a number is not finite, or a point is farther than this from the origin (m).
bool isLost(const BodyStates& states, double distance);

/// Adds numbers bit for bit (FNV-1a).
void addToHash(std::uint64_t& hash, const Eigen::Matrix3Xd& values);
constexpr std::uint64_t kHashStart = 14695981039346656037ull;

inline double relativeError(double value, double exact) {
  return std::isfinite(value) ? std::abs(value / exact - 1.0) : kLost;
}

/// Rounds to a whole number of 1/30 s, so that ticks of all lengths end there.
inline double wholeTicks(double seconds) { return std::round(seconds * 30.0) / 30.0; }

}  // namespace limber::bench
