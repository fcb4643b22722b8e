// SPDX-License-Identifier: Zlib
#pragma once

#include "core/moving_surface.h"

#include <utility>
#include <vector>

namespace limber {

/// Halves the elements at the median of their centres along the longest side of their box, down to leaves of
/// one element.
std::vector<SurfaceNode> makeSurfaceTree(const Points& rest, const std::vector<SurfaceElement>& elements);

/// The box of all points that a surface uses.
Box sweptBounds(const MovingSurface& surface);

/// `boxes` is resized to #nodes. The boxes of one-sided triangles reach as far behind them as vertices are
/// pushed out again.
void fitBoxes(const MovingSurface& surface, SurfaceBoxes& boxes);

/// Pairs of elements, one of each surface.
using ElementPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Those whose boxes are within `margin` of each other, in an order that depends on the trees and boxes
/// alone. `waiting` is scratch.
void findNearElements(const MovingSurface& a, const MovingSurface& b, double margin, ElementPairs& waiting,
                      ElementPairs& near);

/// Pairs of different elements of one surface, each once, the smaller first.
void findNearElements(const MovingSurface& surface, double margin, ElementPairs& waiting, ElementPairs& near);

/// The triangles whose boxes overlap `box`.
void findTriangles(const MovingSurface& surface, const Box& box, std::vector<std::uint32_t>& found);

/// The point of the triangles that is nearest to `place` at the start of the tick.
struct NearestOnSurface {
  std::uint32_t triangle = kNoFeature;  ///< none within the distance asked for
  double distance = 0.0;                ///< m
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
  bool behind = false;  ///< the triangles there face away from the place
};

/// Of equally near triangles the one with the lowest index.
NearestOnSurface nearestOnSurface(const MovingSurface& surface, const Eigen::Vector3d& place, double within);

}  // namespace limber
