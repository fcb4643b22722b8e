// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/soft_body_settings.h>
#include <limber/spring_settings.h>

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

/// A body of point masses and springs, told in a way that every engine understands.
struct BodySetup {
  SharedNetwork network;
  SoftBodySettings settings;        ///< stiffness, mass, damping and place; stepping is each engine's own
  std::vector<std::uint32_t> pins;  ///< points that are held where they start
  Eigen::Matrix3Xd positions;       ///< 3 x #points, m, or empty: where the settings put the network
  Eigen::Matrix3Xd velocities;      ///< 3 x #points, m/s, or empty: from the settings
  double drag = 0.0;      ///< 1/s by which an engine without dampers along its springs slows everything down
  bool maySleep = false;  ///< as far as the engine knows how; else it is kept awake
};

/// A point of one of the bodies.
struct BodyPoint {
  std::size_t body = 0;
  std::uint32_t point = 0;
};

/// A physics engine with soft bodies in a world of Bullet's.
class Engine {
 public:
  virtual ~Engine() = default;

  /// For rigid bodies, which must outlive the engine, and for gravity, to be set before addBody().
  virtual btDiscreteDynamicsWorld& world() = 0;
  /// Returns its index. Throws std::runtime_error with the reason when the engine cannot have such a body.
  virtual std::size_t addBody(const BodySetup& setup) = 0;
  /// Advances the world by one tick of dt seconds.
  virtual void tick(double dt) = 0;
  /// The springs' part of the last tick; below 0: not told apart, so the whole tick.
  virtual double stepMicroseconds() const = 0;

  /// N s that soft bodies' contacts have borne in the last tick without Bullet's manifolds telling.
  virtual double untoldImpulse() const { return 0.0; }
  virtual Eigen::Matrix3Xd positions(std::size_t body) const = 0;   ///< 3 x #points, m
  virtual Eigen::Matrix3Xd velocities(std::size_t body) const = 0;  ///< 3 x #points, m/s
  /// Holds a point where it is, or lets go of it.
  virtual void setPinned(std::size_t body, std::uint32_t point, bool pinned) = 0;
  /// A spring beside those of the bodies. Throws std::runtime_error with the reason when there is no such
  /// thing.
  virtual void addSpring(BodyPoint, BodyPoint, const SpringSettings&) {
    throw std::runtime_error("single springs are Limber's alone");
  }
};

/// One way to simulate a scene. No commas in the names: they become cells of a CSV file.
struct EngineChoice {
  std::string engine, setting;
  /// A new engine for ticks of dt seconds: some are tuned to it.
  std::function<std::unique_ptr<Engine>(double dt)> make;
};

/// Share of what can move in a world that sleeps.
double asleepShare(btDiscreteDynamicsWorld& world);

/// Limber with each of its steppers, btSoftBody and btDeformable with each setting worth trying.
std::vector<EngineChoice> allEngines();

}  // namespace limber::bench
