// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/moving_surface.h"

#include <utility>
#include <vector>

namespace limber {

/// Halves the elements at the median of their centres along the longest side of their box, down to leaves of
/// one element.
std::vector<SurfaceNode> makeSurfaceTree(const Points& rest, const std::vector<SurfaceElement>& elements);

/// Around all vertices of the surface: cheap, and enough to see that nothing is near.
SweptBox sweptBounds(const MovingSurface& surface);

/// The boxes of one-sided triangles reach as far behind them as vertices are
/// pushed out again.
void fitBoxes(const MovingSurface& surface, SurfaceBoxes& boxes);

/// Pairs of leaves of trees.
using LeafPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Those whose boxes are within `margin` of each other, in an order that depends on the trees and boxes
/// alone. `waiting` is scratch.
void findNearLeaves(const MovingSurface& a, const MovingSurface& b, double margin, LeafPairs& waiting,
                    LeafPairs& near);

/// Pairs of different leaves of one tree, each once, the smaller first.
void findNearLeaves(const MovingSurface& surface, double margin, LeafPairs& waiting, LeafPairs& near);

/// The triangles whose boxes overlap `box`.
void findTriangles(const MovingSurface& surface, const Eigen::AlignedBox3d& box,
                   std::vector<std::uint32_t>& found);

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
