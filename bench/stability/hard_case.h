// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

/// A spring between points, beside those of the bodies.
struct ExtraSpring {
  BodyPoint a, b;
  SpringSettings settings;
};

/// A situation that is hard to survive, for any engine, and what is asked of it.
struct HardCase {
  std::string group, name;  ///< no commas
  unsigned seed = 1;
  double stiffness = 0.0;  ///< N/m
  double size = 1.0;       ///< m, an edge of the cubes
  double seconds = 2.0;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  double lowest = 0.0;  ///< m, height at which the potential of gravity is 0: nothing should get below it
  std::vector<BodySetup> bodies;
  std::vector<ExtraSpring> springs;
  std::function<void(RigidBodies&, btDiscreteDynamicsWorld&)> addRigidBodies;  ///< or empty
  /// Puts kinematic bodies where they are at that time; or empty.
  std::function<void(const RigidBodies&, double time)> drive;
  double energyFrom = 0.0;       ///< s; from here on kinematic bodies only move away
  bool freeFlight = false;       ///< nothing acts from outside: its momentum must stay
  bool recovers = false;         ///< it is given what it takes to come to rest in its shape
  bool startsInBalance = false;  ///< some points are in one place: the exact motion never parts them
  bool sees = true;              ///< false: what it hits is a plane, which btSoftBody does not see
  std::function<bool(const Eigen::Vector3d&)> allowed;  ///< where points may end; empty: anywhere
};

/// All of them; `quick`: fewer of the same.
std::vector<HardCase> allHardCases(bool quick);

/// Each adds its groups.
void addFreeCases(std::vector<HardCase>& cases, bool quick);     // free_cases.cpp: hard numbers
void addShapeCases(std::vector<HardCase>& cases, bool quick);    // shape_cases.cpp: hard starts
void addContactCases(std::vector<HardCase>& cases, bool quick);  // contact_cases.cpp: hard hits and loads
void addRestCases(std::vector<HardCase>& cases, bool quick);     // rest_cases.cpp: sizes, stacks, long rest

}  // namespace limber::bench
