// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

#include <cmath>
#include <limits>

namespace limber::bench {

/// Impacts make every scheme first order: what has them is told apart from free motion.
enum class Kind : std::uint8_t { Free, Contact };

constexpr double kGravity = 9.81;  // m/s^2
constexpr double kLost = std::numeric_limits<double>::infinity();

/// The state of everything after a tick (or before the first).
struct Frame {
  std::vector<Eigen::Matrix3Xd> positions, velocities;  ///< #bodies
  std::vector<Eigen::Vector3d> boxes;                   ///< centres of the scene's movable rigid bodies
  double contactImpulse = 0.0;                          ///< N s borne by contacts during the tick
};

/// What a run has left behind: its last frames, dt apart, the last at the scene's end.
struct Trace {
  double dt = 0.0;
  std::vector<Frame> frames;

  const Frame& last() const { return frames.back(); }
};

/// The rigid bodies of a run, in a world.
struct RigidBodies {
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btStridingMeshInterface>> meshes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
};

/// A situation whose outcome is known, for any engine.
struct Scene {
  std::string name;
  Kind kind = Kind::Free;
  double seconds = 1.0;
  double keepSeconds = 1e9;  ///< of the end, that the judge wants to see
  Eigen::Vector3d gravity = {0, -kGravity, 0};
  std::vector<BodySetup> bodies;
  std::function<void(RigidBodies&, btDiscreteDynamicsWorld&)> addRigidBodies;  ///< or empty
  std::vector<std::string> measures;                       ///< kinds of error, the main one first
  std::function<std::vector<double>(const Trace&)> judge;  ///< the error of each kind
  bool ordered = false;  ///< errors shrink with the step: fit an order, and try finer substeps
  int finest = 8;        ///< Limber is tried with 1, 2, 4 ... this many times the substeps it needs; beyond
                         ///< 8 only at 60 ticks a second
  double periodTolerance = 0.0;  ///< above 0: Limber is also asked for this one
  int copies = 1;                ///< of all bodies, far apart; times are told per copy, the first is judged
  bool limberOnly = false;       ///< the others cannot have it
  std::string remark;            ///< printed beside the results, for orientation
};

inline double relativeError(double value, double exact) {
  return std::isfinite(value) ? std::abs(value / exact - 1.0) : kLost;
}

/// All ticks end here, whatever their length: scenes last a whole number of 1/30 s.
inline double wholeTicks(double seconds) { return std::round(seconds * 30.0) / 30.0; }

}  // namespace limber::bench
