// SPDX-License-Identifier: Zlib
#pragma once

// The forces of air and water on the triangles and segments of a body.

#include "solver/point_drag.h"
#include "solver/point_state.h"

#include <limber/mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

/// The parts of a body that a flow acts on. All lists but one are empty.
struct WettedParts {
  std::vector<Triangle> closed;                        ///< outward, of closed surfaces
  std::vector<Triangle> sheets;                        ///< of open ones
  std::vector<std::array<std::uint32_t, 2>> segments;  ///< of ropes

  bool empty() const { return closed.empty() && sheets.empty() && segments.empty(); }
};

/// A medium with the coefficients of a body in it.
struct Flow {
  double density = 0.0;           ///< kg/m^3
  double drag = 0.0, lift = 0.0;  ///< see FlowCoefficients
  double friction = 0.0;
  const Points* velocityAt = nullptr;                  ///< 3 x #points, m/s; nullptr: `velocity` everywhere
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s

  bool acts() const { return density > 0.0 && drag + friction > 0.0; }
};

/// The plane of the water: points x with  up . x < level  are below.
struct WaterPlane {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();  ///< unit vector against gravity; 0: no water
  double level = 0.0;                            ///< m
  double weight = 0.0;                           ///< N/m^3, of the water
  bool isThere() const { return weight > 0.0; }
  double depthOf(const Eigen::Vector3d& x) const { return level - up.dot(x); }
};

/// The points of a body in a flow.
struct MovingPoints {
  const Points& position;  ///< 3 x #points, m
  const Points& velocity;  ///< 3 x #points, m/s, for the speed of the flow past each part
};

/// Adds the drag in air, and in water below the plane, of all parts to the points' drag. `diameter` (m) is
/// that of the segments.
void addDragOfParts(const WettedParts& parts, double diameter, const MovingPoints& points, const Flow& air,
                    const Flow& water, const WaterPlane& plane, PointDrag& drag);

/// Adds the integral of the water's pressure over closed triangles below the plane to `force` (3 x #points,
/// N), exactly for plane triangles, so that it sums up to the weight of the displaced water. Returns the area
/// (m^2) of the water's plane inside the surface.
double addBuoyancy(const std::vector<Triangle>& closed, const Points& position, const WaterPlane& plane,
                   Points& force);

}  // namespace limber
