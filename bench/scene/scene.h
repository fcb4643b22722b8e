// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

#include <cmath>
#include <limits>

namespace limber::bench {

constexpr double kGravity = 9.81;  // m/s^2
constexpr double kLost = std::numeric_limits<double>::infinity();

/// The rigid bodies of a run.
struct RigidBodies {
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btStridingMeshInterface>> meshes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
};

/// Bodies, obstacles and forces: the part of a scene that all benches have.
struct Scenario {
  std::string name;
  Eigen::Vector3d gravity = {0, -kGravity, 0};
  std::vector<BodySetup> bodies;
  std::function<void(RigidBodies&, btDiscreteDynamicsWorld&)> addRigidBodies;  ///< or empty
};

/// Sets up a scenario in an engine. `rigid` must outlive the engine. Throws std::runtime_error with the
/// reason if the engine does not support it.
std::unique_ptr<Engine> open(const Scenario& scenario, const EngineChoice& choice, const EngineUse& use,
                             RigidBodies& rigid);

/// Adds numbers bit for bit (FNV-1a).
void addToHash(std::uint64_t& hash, const Eigen::Matrix3Xd& values);
constexpr std::uint64_t kHashStart = 14695981039346656037ull;

inline double relativeError(double value, double exact) {
  return std::isfinite(value) ? std::abs(value / exact - 1.0) : kLost;
}

/// Rounds to a whole number of 1/30 s, so that ticks of all lengths end there.
inline double wholeTicks(double seconds) { return std::round(seconds * 30.0) / 30.0; }

}  // namespace limber::bench
