// SPDX-License-Identifier: Zlib
#pragma once

#include "scene/scene.h"

#include <random>

namespace limber::bench {

/// A spring between points in addition to those of the bodies.
struct ExtraSpring {
  BodyPoint a, b;
  SpringSettings settings;
};

/// A case that is difficult for any engine, and its requirements.
struct HardCase : Scenario {
  HardCase() { gravity.setZero(); }

  std::string group;
  unsigned seed = 1;
  double stiffness = 0.0;  ///< N/m
  double size = 1.0;       ///< m, an edge of the cubes
  double seconds = 2.0;
  double lowest = 0.0;  ///< m, height at which the potential energy of gravity is 0: no body should be lower
  std::vector<ExtraSpring> springs;
  /// Sets the poses of kinematic bodies at that time; or empty.
  std::function<void(const RigidBodies&, double time)> drive;
  double energyFrom = 0.0;       ///< s; from here on kinematic bodies only move away
  bool freeFlight = false;       ///< no external forces: the momentum must be constant
  bool recovers = false;         ///< the body has the time and damping to return to its rest shape
  bool startsInBalance = false;  ///< some points coincide: in the exact motion they stay together
  bool sees = true;              ///< false: the obstacle is a plane, with which btSoftBody does not collide
  std::function<bool(const Eigen::Vector3d&)> allowed;  ///< permitted final positions; empty: all
};

/// Returns all cases; `quick`: a smaller selection.
std::vector<HardCase> allHardCases(bool quick);

// --- parts of cases ---

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

/// Returns a fully connected cube of 28 springs with edges of `size`. `damping` is a fraction of the critical
/// damping of a single spring between two of its points, 2 sqrt(k m / 2).
BodySetup hardCube(double stiffness, double damping, double size = 1.0, double mass = 1.0);

/// Returns the rest positions after scale, rotation and translation by the settings.
Eigen::Matrix3Xd restPositions(const BodySetup& body);

/// Returns the time (s) in which the cube's slowest oscillation decays to about 1e-4 or less.
///
/// With springs of stiffness k and parallel dampers of c, a mode of frequency w decays at the rate c w^2 / (2
/// k) if that is below w, else at k / c. The slowest w of the cube is at least sqrt(k / m) of a single spring
/// and point. The result is ten times the longer time constant.
double settleTime(const BodySetup& cube);

/// Returns a case with this cube only.
HardCase caseOf(const std::string& group, const std::string& name, unsigned seed, const BodySetup& cube);

/// Sets free flight without contacts, at a slow speed of a tenth of the size per second.
void setFree(HardCase& hard, Dice& dice);

/// Requires a return to the rest shape, and sets the duration for it. Engines without dampers along the
/// springs get a drag that decays by e^-20 in that time.
void letSettle(HardCase& hard);

/// Sets gravity and the duration (s), and limits the drag so that bodies still fall.
void letFall(HardCase& hard, double seconds);

std::string exponentName(const char* what, double value);  ///< "k 1e+04"

// --- obstacles and partners ---

/// Static obstacles with their top at y = 0.
enum class Obstacle : std::uint8_t { Plane, Box, BoxEdge, TriangleMesh };

const char* nameOf(Obstacle obstacle);

/// Adds the obstacle to the case. The points must end outside it, or at most twice their radius deep in it.
/// Boxes extend by 10 times `scale` to all sides, the mesh by 15. The edge of the box is along x; its faces
/// slope down at 45 degrees on both sides.
void setObstacle(HardCase& hard, Obstacle obstacle, double scale = 1.0);

/// A kinematic plate above the floor. It moves down, stops, and moves up faster than it came down.
struct Press {
  double top = 1.3;             ///< m, initial height of its lower face
  double gap = 0.1;             ///< m, smallest distance from the floor
  double down = 1.0, up = 4.0;  ///< m/s
  double stay = 0.5;            ///< s

  double leaves() const { return (top - gap) / down + stay; }  ///< s
  double heightAt(double time) const;                          ///< m, of its lower face
};

/// Adds the press to a case whose only rigid body is its obstacle.
void addPress(HardCase& hard, const Press& press);

/// Adds a box of this mass that falls onto the case's body. `height` is the initial height of its lower face.
void addFallingBox(HardCase& hard, double mass, double height);

}  // namespace limber::bench
