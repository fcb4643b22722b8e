// SPDX-License-Identifier: Zlib
#pragma once

#include "bench.h"
#include "bullet_soft/body_start.h"

#include <limber/parallel.h>
#include <limber/soft_body_settings.h>

#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace limber::bench {

using namespace bullet_soft;  // BodySetup, BodyStart and their functions

/// A point of one of the bodies.
struct BodyPoint {
  std::size_t body = 0;
  std::uint32_t point = 0;
};

/// A physics engine with soft bodies in a Bullet world.
class Engine {
 public:
  virtual ~Engine() = default;

  /// Returns the world, for rigid bodies, which must outlive the engine, and to set gravity before addBody().
  virtual btDiscreteDynamicsWorld& world() = 0;
  /// Changes a setting of the bodies that are added from now on. Ignores keys of other engines.
  virtual void set(const std::string& /*key*/, const std::string& /*value*/) {}
  /// Returns its index. Throws std::runtime_error with the reason if the engine does not support the body.
  virtual std::size_t addBody(const BodySetup& setup) = 0;
  /// Advances the world by one tick of dt seconds.
  virtual void tick(double dt) = 0;
  /// Returns the springs' part of the last tick; negative: not measured separately, the whole tick counts.
  virtual double stepMicroseconds() const { return -1.0; }

  /// Returns the contact impulses (N s) of soft bodies in the last tick that Bullet's manifolds do not
  /// contain.
  virtual double untoldImpulse() const { return 0.0; }
  virtual Eigen::Matrix3Xd positions(std::size_t body) const = 0;   ///< 3 x #points, m
  virtual Eigen::Matrix3Xd velocities(std::size_t body) const = 0;  ///< 3 x #points, m/s
  /// Holds a point at its position, or releases it.
  virtual void setPinned(std::size_t body, std::uint32_t point, bool pinned) = 0;
  /// Adds a separate spring. Throws std::runtime_error with the reason if this is not supported.
  virtual void addSpring(BodyPoint, BodyPoint, const SpringSettings&) {
    throw std::runtime_error("single springs are Limber's alone");
  }
};

/// What an engine is made for: some are tuned to the tick, or to whether soft bodies touch each other.
struct EngineUse {
  EngineUse(double tick, bool touch = true) : dt(tick), bodiesTouch(touch) {}
  double dt;  ///< s
  bool bodiesTouch;
};

/// An engine with a setting: the plug-in of a bench.
struct EngineChoice {
  std::string engine, setting;
  std::function<std::unique_ptr<Engine>(const EngineUse&)> make;

  bool isLimber() const { return engine == "Limber"; }
};

// --- the list ---

/// Returns the share of a world's movable objects that sleep.
double asleepShare(btDiscreteDynamicsWorld& world);

/// Returns Limber with each of its steppers, and btSoftBody and btDeformable with all useful settings.
std::vector<EngineChoice> allEngines();

/// Returns the engines that the options ask for, with the values of --set that they know.
std::vector<EngineChoice> wantedEngines(const std::vector<EngineChoice>& engines, const Options& options);

/// The keys of --set that Engine::set() knows, followed by those of the bench.
std::vector<Key> withEngineKeys(std::vector<Key> keys);

// --- Limber ---

/// Changes a scene's settings before Limber's body is made, for example to force a stepper.
using TuneSettings = std::function<void(SoftBodySettings&)>;

/// Its soft bodies are stepped by `parallelFor`, if given; see SoftBodySystem::setParallelFor().
std::unique_ptr<Engine> makeLimberEngine(TuneSettings tune = {}, ParallelFor parallelFor = {});

EngineChoice limberChoice(const std::string& setting, const TuneSettings& tune = {},
                          const ParallelFor& parallelFor = {});

/// Returns the number of Verlet substeps that the body takes in a tick of dt seconds with its own settings.
int stableSubsteps(const BodySetup& setup, double dt);

// --- Bullet's soft bodies ---

/// The stiffness of btSoftBody's links.
enum class LinkStiffness : std::uint8_t {
  Full,       ///< kLST = 1, Bullet's default: the stiffness depends on the iterations
  Calibrated  ///< kLST for which the iterations of a tick act like implicit Euler on a single spring
};

/// The colliding parts of a btSoftBody: its points with rigid bodies through their distance fields and with
/// the faces of other soft bodies, or convex clusters of points with either.
enum class SoftContacts : std::uint8_t {
  Points,             ///< SDF_RS
  PointsAndFaces,     ///< SDF_RS | VF_SS
  PointsAndClusters,  ///< SDF_RS | CL_SS, at most 8 clusters
  Clusters            ///< CL_RS | CL_SS, at most 8 clusters
};

/// kKHR of the bodies: the share of the overlap with a static or kinematic object that an iteration removes.
/// With Bullet's default of 0.1 bodies sink in; 1 costs the same. It made one scene worse, a stack of soft
/// cubes.
constexpr double kHardContacts = 1.0, kBulletsHardness = 0.1;

/// Returns "1 iteration" or "4 iterations".
std::string iterationsText(int count);

/// Creates Bullet's position-based soft body. Bodies without faces collide with their points.
std::unique_ptr<Engine> makeSoftBodyEngine(double dt, int iterations, LinkStiffness stiffness,
                                           SoftContacts contacts = SoftContacts::PointsAndFaces,
                                           double hardness = kHardContacts);

/// Creates Bullet's deformable body with btDeformableMassSpringForce. It supports two spring constants: that
/// of the body, and that of its bending springs.
std::unique_ptr<Engine> makeDeformableEngine(bool implicit);

// --- loose spheres ---

/// Plain Bullet with a separate sphere for each point, of its mass, radius and friction and without rotation:
/// Bullet's own cost of so many bodies. There are no springs.
std::unique_ptr<Engine> makeBareEngine();

}  // namespace limber::bench
