// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

#include <cmath>
#include <limits>

namespace limber::bench {

/// Impacts make every scheme first order, so scenes with contacts are evaluated separately from free motion.
enum class Kind : std::uint8_t { Free, Contact };

constexpr double kGravity = 9.81;  // m/s^2
constexpr double kLost = std::numeric_limits<double>::infinity();

/// The state of all bodies after a tick (or before the first).
struct Frame {
  std::vector<Eigen::Matrix3Xd> positions, velocities;  ///< #bodies
  std::vector<Eigen::Vector3d> boxes;                   ///< centres of the scene's movable rigid bodies
  double contactImpulse = 0.0;                          ///< N s, of all contacts during the tick
};

/// The result of a run: its last frames, dt apart. The last one is at the scene's end.
struct Trace {
  double dt = 0.0;
  std::vector<Frame> frames;

  const Frame& last() const { return frames.back(); }
};

/// The rigid bodies of a run.
struct RigidBodies {
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btStridingMeshInterface>> meshes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
};

/// A situation with a known outcome, for any engine.
struct Scene {
  std::string name;
  Kind kind = Kind::Free;
  double seconds = 1.0;
  double keepSeconds = 1e9;  ///< length of the last part, which `judge` needs
  Eigen::Vector3d gravity = {0, -kGravity, 0};
  std::vector<BodySetup> bodies;
  std::function<void(RigidBodies&, btDiscreteDynamicsWorld&)> addRigidBodies;  ///< or empty
  std::vector<std::string> measures;                       ///< kinds of error, the main one first
  std::function<std::vector<double>(const Trace&)> judge;  ///< the error of each kind
  bool ordered = false;  ///< errors shrink with the step: an order is fitted, and finer substeps are run
  int finest = 8;        ///< Limber is run with 1, 2, 4 ... up to this many times the substeps that it needs;
                         ///< beyond 8 only at 60 ticks a second
  double periodTolerance = 0.0;  ///< above 0: Limber is also run with this value
  int copies = 1;                ///< of all bodies, far apart; times are per copy, the first copy is judged
  bool limberOnly = false;       ///< the other engines do not support it
  std::string remark;            ///< printed with the results, for orientation
};

inline double relativeError(double value, double exact) {
  return std::isfinite(value) ? std::abs(value / exact - 1.0) : kLost;
}

/// Rounds to a whole number of 1/30 s, so that ticks of all lengths end there.
inline double wholeTicks(double seconds) { return std::round(seconds * 30.0) / 30.0; }

/// Each function adds its scenes. With `quick` they are few and short.
void addOscillators(std::vector<Scene>& scenes, bool quick);  // oscillators.cpp: one spring
void addChains(std::vector<Scene>& scenes, bool quick);       // chains.cpp: hanging chains
void addWaves(std::vector<Scene>& scenes, bool quick);        // waves.cpp: waves along a bar
void addFreeShapes(std::vector<Scene>& scenes, bool quick);   // free_shapes.cpp: cube, block, cloth
void addImpacts(std::vector<Scene>& scenes, bool quick);      // impacts.cpp: bar against a wall, dropped cube
void addResting(std::vector<Scene>& scenes, bool quick);      // resting.cpp: on floors and an incline
void addRigidPartners(std::vector<Scene>& scenes,
                      bool quick);  // rigid_partners.cpp: boxes, stack

}  // namespace limber::bench
