// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/hard_case.h"

namespace limber::bench {

/// What bodies hit in these cases: static, with the top at y = 0.
enum class Obstacle : std::uint8_t { Plane, Box, BoxEdge, TriangleMesh };

const char* nameOf(Obstacle obstacle);

/// Puts it under the case, and asks the points to end on its outside, or no deeper in it than twice their
/// radius. Boxes reach 10 `scale`s to all sides, the mesh 15. The edge of the box runs along x, its faces
/// fall off at 45 degrees to both sides.
void setObstacle(HardCase& hard, Obstacle obstacle, double scale = 1.0);

/// A kinematic plate above the floor. It comes down, stays, and leaves upwards faster than it came.
struct Press {
  double top = 1.3;             ///< m, height of its lower face at first
  double gap = 0.1;             ///< m, what it leaves above the floor
  double down = 1.0, up = 4.0;  ///< m/s
  double stay = 0.5;            ///< s

  double leaves() const { return (top - gap) / down + stay; }  ///< s
  double heightAt(double time) const;                          ///< m, of its lower face
};

/// Adds the press to a case that has no other rigid body yet but its obstacle.
void addPress(HardCase& hard, const Press& press);

/// A box of that mass that falls onto the case's body, its lower face at that height at first.
void addFallingBox(HardCase& hard, double mass, double height);

}  // namespace limber::bench
