// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

/// A spring between points in addition to those of the bodies.
struct ExtraSpring {
  BodyPoint a, b;
  SpringSettings settings;
};

/// A case that is difficult for any engine, and its requirements.
struct HardCase {
  std::string group, name;  ///< no commas
  unsigned seed = 1;
  double stiffness = 0.0;  ///< N/m
  double size = 1.0;       ///< m, an edge of the cubes
  double seconds = 2.0;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  double lowest = 0.0;  ///< m, height at which the potential energy of gravity is 0: no body should be lower
  std::vector<BodySetup> bodies;
  std::vector<ExtraSpring> springs;
  std::function<void(RigidBodies&, btDiscreteDynamicsWorld&)> addRigidBodies;  ///< or empty
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

/// Each function adds its groups.
void addFreeCases(std::vector<HardCase>& cases, bool quick);     // free_cases.cpp: extreme parameters
void addShapeCases(std::vector<HardCase>& cases, bool quick);    // shape_cases.cpp: extreme initial shapes
void addContactCases(std::vector<HardCase>& cases, bool quick);  // contact_cases.cpp: extreme hits and loads
void addRestCases(std::vector<HardCase>& cases, bool quick);     // rest_cases.cpp: sizes, stacks, long rest

}  // namespace limber::bench
