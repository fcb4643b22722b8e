// SPDX-License-Identifier: Zlib
#pragma once

#include "bench.h"
#include "bullet_soft/body_start.h"

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
  virtual void set(const std::string& key, const std::string& value) = 0;
  /// Returns its index. Throws std::runtime_error with the reason if the engine does not support the body.
  virtual std::size_t addBody(const BodySetup& setup) = 0;
  /// Advances the world by one tick of dt seconds.
  virtual void tick(double dt) = 0;
  /// Returns the springs' part of the last tick; negative: not measured separately, the whole tick counts.
  virtual double stepMicroseconds() const = 0;

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

/// Returns the share of a world's movable objects that sleep.
double asleepShare(btDiscreteDynamicsWorld& world);

/// Returns Limber with each of its steppers, and btSoftBody and btDeformable with all useful settings.
std::vector<EngineChoice> allEngines();

/// Returns the engines that the options ask for, with the values of --set that they know.
std::vector<EngineChoice> wantedEngines(const std::vector<EngineChoice>& engines, const Options& options);

/// The keys of --set that Engine::set() knows, followed by those of the bench.
std::vector<Key> withEngineKeys(std::vector<Key> keys);

}  // namespace limber::bench
