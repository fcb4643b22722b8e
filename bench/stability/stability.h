// SPDX-License-Identifier: Zlib
#pragma once

#include "scene/scene.h"

#include <cstdio>
#include <optional>
#include <string>

namespace limber::bench {

// --- cases ---

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

// --- obstacles and partners ---

/// Static obstacles with their top at y = 0.
enum class Obstacle : std::uint8_t { Plane, Box, BoxEdge, TriangleMesh };

const char* nameOf(Obstacle obstacle);

/// Adds the obstacle to the case. The points must end outside it, or at most twice their radius deep in it.
/// Boxes extend by 10 times `scale` to all sides, the mesh by 6 m. The edge of the box is along x; its faces
/// slope down at 45 degrees on both sides.
void setObstacle(HardCase& hard, Obstacle obstacle, double scale = 1.0);

/// Adds a kinematic plate to a case whose only rigid body is its obstacle. It moves down from above the floor
/// to a distance of `gap` (m), stays, and moves up faster than it came down; from then on energy is balanced.
void addPress(HardCase& hard, double gap);

/// Adds a box of this mass that falls onto the case's body. `height` is the initial height of its lower face.
void addFallingBox(HardCase& hard, double mass, double height);

// --- energy and momentum ---

/// An energy (J) and a bound of its rounding error.
struct Energy {
  double value = 0.0, rounding = 0.0;
};

/// Computes energy and momentum of a case, by the same formulas for every engine, from positions and
/// velocities only.
///
///   E = sum m v^2 / 2                      points; movable rigid bodies: m v^2 / 2 + w I w / 2
///     + sum k (|xb - xa| - L)^2 / 2        springs
///     + sum m g (height above `lowest`)    points and movable rigid bodies
///
/// Work of other objects: static ones do no work. Kinematic bodies do while they press. So the balance starts
/// when they begin to leave (HardCase::energyFrom). From then on they can only push and move away: their work
/// is negative, and counts as 0. So E must never exceed its value at the start of the balance.
///
/// Bullet's positions and velocities have a relative rounding error of u (2^-24 in single precision). So the
/// error of a point at x is u |x|, that of a spring's length is d = u (|xa| + |xb|), and that of its energy,
/// for an elongation of e, is k (|e| d + d^2 / 2). The relative error of kinetic energies is 2 u; the error
/// of heights is u |x|.
class EnergyBalance {
 public:
  explicit EnergyBalance(const HardCase& hard);

  Energy energy(const BodyStates& states, const RigidBodies& rigid) const;
  Eigen::Vector3d momentum(const BodyStates& states) const;  ///< kg m/s, of the bodies' points
  double momentumScale(const BodyStates& states) const;      ///< kg m/s, sum m |v|
  const BodyStart& start(std::size_t body) const { return starts_[body]; }

 private:
  void addBody(const BodyStates& states, std::size_t body, Energy& sum) const;
  void addRigid(const btRigidBody& body, Energy& sum) const;
  void addPotential(double mass, const Eigen::Vector3d& x, Energy& sum) const;

  const HardCase& hard_;
  std::vector<BodyStart> starts_;  // #bodies
};

// --- shape ---

/// The final shape of a body.
enum class Shape : std::uint8_t {
  Rest,      ///< the rest shape, moved and rotated
  Mirrored,  ///< its mirror image, which is equivalent for the springs
  Other,     ///< another shape in stable equilibrium
  Saddle,    ///< a shape in unstable equilibrium: the exact motion stays there only if it starts there
  Spinning,  ///< it rotates so fast that the springs must be longer
  Lost       ///< none of these
};

const char* nameOf(Shape shape);

struct ShapeCheck {
  Shape shape = Shape::Lost;
  double error = 0.0;  ///< largest change of the distance of two points, as a fraction of `size`
};

constexpr double kShapeTolerance = 1e-3;

/// Input of checkShape.
struct ShapeQuestion {
  const BodySetup& setup;
  const BodyStart& start;
  const Eigen::Matrix3Xd &positions, &velocities;
  double size;  ///< m
  bool alone;   ///< no forces except those of its own springs
};

/// Compares all distances between two points with those of the rest shape. If they differ, finds the reason
/// for the other shape.
ShapeCheck checkShape(const ShapeQuestion& question);

/// Angular momentum (kg m^2/s) about the centre of mass, and the sum of m |r| |v| relative to the centre.
struct Spin {
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  double scale = 0.0;
};
Spin spinOf(const Eigen::VectorXd& masses, const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& v);

// --- results ---

/// The result of one engine for one case and tick. Empty members: the case does not require this value, or
/// the engine does not support the case.
struct CaseResult {
  std::string reason;               ///< why the engine does not support the case; empty: it has run
  bool finite = true;               ///< no value is NaN, and no point is farther away than a million sizes
  double energyRatio = 0.0;         ///< largest energy over that at the start
  double rounding = 0.0;            ///< largest part of the ratio that may be rounding of Bullet's numbers
  std::optional<double> drift;      ///< largest change of momentum over the sum of m |v|
  std::optional<double> spinDrift;  ///< largest change of angular momentum over the largest possible value
  std::optional<ShapeCheck> shape;  ///< of the worst body
  std::optional<double> wrongSide;  ///< number of points that ended inside or behind an obstacle
};

/// Returns whether the engine has run and has met all targets.
bool passes(const CaseResult& result);

/// Plays the case with an engine in ticks of dt. Writes a line per tick to `trace`, if given: time, energy
/// divided by that at the start, drift of momentum, largest speed, height of the lowest point.
CaseResult playCase(const HardCase& hard, const EngineChoice& choice, double dt, std::FILE* trace = nullptr);

}  // namespace limber::bench
