// SPDX-License-Identifier: Zlib
#pragma once

// A triangle surface: what stays the same while it moves, where it is during one tick, and the tree of boxes
// that finds what is near it.

#include "mesh/edges.h"
#include "solver/point_state.h"

#include <limber/result.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace limber {

// --- what stays the same -----------------------------------------------------------------------------------

constexpr std::uint32_t kNoFeature = 0xffffffffu;

/// What a surface is made of.
struct SurfaceFeatures {
  std::vector<Triangle> triangles;      ///< outward where they close a body
  std::vector<Edge> segments;           ///< beside the triangles' own edges, as those of a rope
  std::vector<std::uint32_t> vertices;  ///< beside the corners of all these, as the centre of a sphere
  bool outward = false;                 ///< open surfaces, too, are solid behind their triangles
  bool rigid = false;                   ///< edges that are flat or concave remain so
};

/// A triangle, a segment or a lone vertex, with those of its edges and corners that no element before it has:
/// each feature belongs to one element.
struct SurfaceElement {
  std::array<std::uint32_t, 3> corners;  ///< the last repeated
  std::uint32_t triangle = kNoFeature;
  std::array<std::uint32_t, 3> vertices = {kNoFeature, kNoFeature, kNoFeature};  ///< that belong to it
  std::array<std::uint32_t, 3> edges = {kNoFeature, kNoFeature, kNoFeature};     ///< that belong to it
};

/// Lists of different lengths, one after the other: list i is items[first[i]] to items[first[i + 1]].
struct IndexLists {
  std::vector<std::uint32_t> first, items;

  const std::uint32_t* begin(std::uint32_t i) const { return items.data() + first[i]; }
  const std::uint32_t* end(std::uint32_t i) const { return items.data() + first[i + 1]; }
};

/// A binary tree over the elements. Children stand behind their parents, so that boxes are fitted from the
/// last node to the first.
struct SurfaceNode {
  std::uint32_t child = 0;             ///< the first of two that follow each other
  std::uint32_t element = kNoFeature;  ///< of a leaf
};

/// What stays the same while a surface moves and deforms. Built once for a network at its scale, or a shape.
struct SurfaceTopology {
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> oneSided;  ///< #triangles: solid behind it
  std::vector<double> depthLimit;      ///< #triangles, m: vertices farther behind it do not touch it
  std::vector<Edge> edges;             ///< of triangles, then segments
  std::vector<std::array<std::uint32_t, 2>> edgeTriangles;  ///< #edges, kNoFeature where there is none
  IndexLists edgesAround, trianglesAround;                  ///< #points lists
  std::vector<std::uint32_t> vertices;                      ///< points that are on the surface, each once
  std::vector<SurfaceElement> elements;
  std::vector<SurfaceNode> nodes;  ///< none without elements
  Points rest;                     ///< m, 3 x #points, as built
  double featureSize = 0.0;        ///< m, of its edges at rest on average; 0: it has none
};

/// The error names the first index that is out of range, the first triangle or segment whose corners are not
/// different, or the first position that is not finite.
Result<SurfaceTopology> makeSurfaceTopology(const Points& rest, const SurfaceFeatures& features);

// --- where it is in a tick ---------------------------------------------------------------------------------

/// Where something is at any time of the tick (m). The fourth coordinate is 0: whole registers.
struct SweptBox {
  Eigen::Array4d low = {kEmpty, kEmpty, kEmpty, 0.0};
  Eigen::Array4d high = {-kEmpty, -kEmpty, -kEmpty, 0.0};

  static constexpr double kEmpty = std::numeric_limits<double>::infinity();
};

inline SweptBox merged(const SweptBox& a, const SweptBox& b) {
  return {a.low.min(b.low), a.high.max(b.high)};
}

/// m: no two points of the boxes are nearer to each other; 0 if they overlap.
inline double separation(const SweptBox& a, const SweptBox& b) {
  return (a.low - b.high).max(b.low - a.high).maxCoeff();
}

/// The boxes of a surface, its radius included.
struct SurfaceBoxes {
  std::vector<SweptBox> points;  ///< #points
  std::vector<SweptBox> nodes;   ///< #nodes of its tree
};

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

// --- what is near it ---------------------------------------------------------------------------------------

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
