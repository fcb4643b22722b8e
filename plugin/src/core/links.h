// SPDX-License-Identifier: Zlib
#pragma once

#include "core/point_state.h"
#include "core/rigid_state.h"

#include <cstdint>
#include <vector>

namespace limber {

/// A place a link holds on to: a point mass of a soft body, a pivot on a rigid body, or a place in the world.
struct LinkEnd {
  enum class Kind : std::uint8_t { Point, Rigid, World } kind = Kind::World;
  std::uint32_t body = 0;                           ///< index into the group's points or rigids
  std::uint32_t point = 0;                          ///< of a Point
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();  ///< m; local to a Rigid, in world coordinates for World
};

/// A single spring between two ends, as SpringSettings describes it.
struct LinkSpring {
  LinkEnd a, b;
  double restLength = 0.0, extensionStiffness = 0.0, compressionStiffness = 0.0, damping = 0.0;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< from a to b, 0 while slack
  double force = 0.0;                                   ///< N, above 0 pulls
};

/// A point mass that moves with a pivot on a rigid body.
struct LinkAnchor {
  LinkEnd point;  ///< of kind Point
  LinkEnd pivot;  ///< of kind Rigid
};

/// Soft and rigid bodies that links join, stepped together.
struct LinkedBodies {
  std::vector<PointState*> points;
  std::vector<RigidState> rigids;
  std::vector<LinkSpring> springs;
  std::vector<LinkAnchor> anchors;
};

/// Adds the force of every link to both its ends and keeps its direction.
void addLinkForces(LinkedBodies& bodies);

/// Applies the link dampers for `dt` seconds, see spring_damping.h.
void dampLinks(LinkedBodies& bodies, double dt, bool forward);

/// rad^2/s^2: the links' share of the fastest oscillation (frequencyBoundSquared, with the inverse mass of a
/// rigid body at a pivot, 1/m + |r|^2 / smallest inertia).
double linkFrequencyBoundSquared(const LinkedBodies& bodies);

/// Gives the anchored points and their rigid bodies equal and opposite impulses so that after drifting for
/// `dt` each point is at its pivot (SHAKE); with dt = 0 only so that their velocities agree (RATTLE; Andersen
/// 1983).
void solveAnchors(LinkedBodies& bodies, double dt);

/// World position (m) of an end.
Eigen::Vector3d endPosition(const LinkedBodies& bodies, const LinkEnd& end);

/// J stored in the links.
double elasticEnergy(const LinkedBodies& bodies);

}  // namespace limber
