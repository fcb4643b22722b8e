// SPDX-License-Identifier: Zlib
#pragma once

#include "scene/scene.h"

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

}  // namespace limber::bench
