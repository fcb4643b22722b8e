// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/hard_case.h"

namespace limber::bench {

/// Static obstacles with their top at y = 0.
enum class Obstacle : std::uint8_t { Plane, Box, BoxEdge, TriangleMesh };

const char* nameOf(Obstacle obstacle);

/// Adds the obstacle to the case. The points must end outside it, or at most twice their radius deep in it.
/// Boxes extend by 10 times `scale` to all sides, the mesh by 15. The edge of the box is along x; its faces
/// slope down at 45 degrees on both sides.
void setObstacle(HardCase& hard, Obstacle obstacle, double scale = 1.0);

/// A kinematic plate above the floor. It moves down, stops, and moves up faster than it came down.
struct Press {
  double top = 1.3;             ///< m, initial height of its lower face
  double gap = 0.1;             ///< m, smallest distance from the floor
  double down = 1.0, up = 4.0;  ///< m/s
  double stay = 0.5;            ///< s

  double leaves() const { return (top - gap) / down + stay; }  ///< s
  double heightAt(double time) const;                          ///< m, of its lower face
};

/// Adds the press to a case whose only rigid body is its obstacle.
void addPress(HardCase& hard, const Press& press);

/// Adds a box of this mass that falls onto the case's body. `height` is the initial height of its lower face.
void addFallingBox(HardCase& hard, double mass, double height);

}  // namespace limber::bench
