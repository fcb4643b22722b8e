// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/surface_topology.h"
#include "collide/swept_box.h"

namespace limber {

/// A surface during one tick. Time runs from 0 at its start to 1 at its end; points move on straight lines.
struct MovingSurface {
  const SurfaceTopology* topology = nullptr;
  const Points* position = nullptr;     ///< m, at the start of the tick
  const Points* motion = nullptr;       ///< m, expected over the tick
  double radius = 0.0;                  ///< m, of everything about its points, edges and triangles
  const SurfaceBoxes* boxes = nullptr;  ///< as fitBoxes() made them for this tick

  Eigen::Vector3d at(std::uint32_t point, double time) const {
    return position->col(point) + time * motion->col(point);
  }
};

/// A vertex (N = 1), an edge (2) or a triangle (3) of a moving surface.
template <int N>
struct MovingFeature {
  using Corners = Eigen::Matrix<double, 3, N>;
  Corners start, motion;

  Corners at(double time) const { return start + time * motion; }
};

template <int N, class Indices>
MovingFeature<N> featureOf(const MovingSurface& surface, const Indices& corners) {
  MovingFeature<N> feature;
  for (int i = 0; i < N; ++i) {
    feature.start.col(i) = surface.position->col(corners[static_cast<std::size_t>(i)]);
    feature.motion.col(i) = surface.motion->col(corners[static_cast<std::size_t>(i)]);
  }
  return feature;
}

template <int N>
Eigen::Vector3d normalOf(const Eigen::Matrix<double, 3, N>& triangle) {
  return (triangle.col(1) - triangle.col(0)).cross(triangle.col(2) - triangle.col(0)).normalized();
}

}  // namespace limber
