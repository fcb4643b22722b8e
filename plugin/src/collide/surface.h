// SPDX-License-Identifier: Zlib

// A triangle surface: its topology, its motion during one tick, the tree of bounding boxes for searches, and
// how fast two surfaces move past each other.

#pragma once

#include "mesh/surface.h"
#include "solver/point_state.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace limber {

// --- topology ----------------------------------------------------------------------------------------------

constexpr std::uint32_t kNoFeature = 0xffffffffu;

enum class Solid { ClosedPieces, AllPieces, None };

/// The features from which a surface is built. Numbers are indices of points.
struct SurfaceFeatures {
  std::vector<Triangle> triangles;      ///< counterclockwise from outside if they close a body
  std::vector<Edge> segments;           ///< besides the edges of the triangles, for example of a rope
  std::vector<std::uint32_t> vertices;  ///< besides the corners of both, for example the centre of a sphere
  Solid solid = Solid::ClosedPieces;    ///< what is solid behind its triangles
  bool rigid = false;                   ///< the shape is constant: flat and concave edges stay so
};

/// A triangle, a segment or a single vertex. Each vertex and edge is owned by one element: the first that
/// contains it.
struct SurfaceElement {
  std::array<std::uint32_t, 3> corners;  ///< the last one is repeated if there are fewer than three
  std::uint32_t triangle = kNoFeature;
  std::array<std::uint32_t, 3> vertices = {kNoFeature, kNoFeature, kNoFeature};  ///< owned by the element
  std::array<std::uint32_t, 3> edges = {kNoFeature, kNoFeature, kNoFeature};     ///< owned by the element
};

/// Lists of different lengths, one after the other: list i is items[first[i]] to items[first[i + 1]].
struct IndexLists {
  std::vector<std::uint32_t> first, items;

  const std::uint32_t* begin(std::uint32_t i) const { return items.data() + first[i]; }
  const std::uint32_t* end(std::uint32_t i) const { return items.data() + first[i + 1]; }
};

/// A node of the binary tree of elements. Children come after their parent in the array, so that boxes are
/// fitted from the last node to the first.
struct SurfaceNode {
  std::uint32_t child = 0;             ///< the first child; the second one follows it in the array
  std::uint32_t element = kNoFeature;  ///< kNoFeature: not a leaf
};

/// Size of a stack of nodes. One sibling per level waits while the other is visited, and halving makes at
/// most 32 levels.
constexpr std::size_t kNodeStack = 40;

/// The constant data of a surface that moves and deforms. Built once for each network and scale, or shape.
struct SurfaceTopology {
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> oneSided;  ///< #triangles: solid behind it
  std::vector<double> depthLimit;      ///< #triangles, m: vertices farther behind it do not touch it
  std::vector<Edge> edges;             ///< of triangles, then segments
  std::vector<std::array<std::uint32_t, 2>> edgeTriangles;  ///< #edges, kNoFeature: none
  IndexLists edgesAround, trianglesAround;                  ///< #points lists
  std::vector<std::uint32_t> vertices;                      ///< points that are on the surface, each once
  std::vector<SurfaceElement> elements;
  std::vector<SurfaceNode> nodes;  ///< empty without elements
  Points rest;                     ///< m, 3 x #points, positions at rest
  double featureSize = 0.0;        ///< m, mean length of the edges at rest; 0 without edges
};

/// Whether there are triangles, and all are one-sided.
inline bool isSolid(const SurfaceTopology& t) {
  return !t.oneSided.empty() &&
         std::all_of(t.oneSided.begin(), t.oneSided.end(), [](std::uint8_t solid) { return solid != 0; });
}

/// Builds the topology. The error names the first index that is out of range, the first triangle or segment
/// with two equal corners, or the first position that is not finite.
Result<SurfaceTopology> makeSurfaceTopology(const Points& rest, const SurfaceFeatures& features);

// --- motion during a tick ----------------------------------------------------------------------------------

/// A box that contains something at all times of the tick (m). The fourth coordinate is 0 and fills a SIMD
/// register.
struct SweptBox {
  Eigen::Array4d low = {kEmpty, kEmpty, kEmpty, 0.0};
  Eigen::Array4d high = {-kEmpty, -kEmpty, -kEmpty, 0.0};

  static constexpr double kEmpty = std::numeric_limits<double>::infinity();
};

inline SweptBox merged(const SweptBox& a, const SweptBox& b) {
  return {a.low.min(b.low), a.high.max(b.high)};
}

/// Returns a lower bound of the distance between points of the two boxes, m; 0 if they overlap.
inline double separation(const SweptBox& a, const SweptBox& b) {
  return (a.low - b.high).max(b.low - a.high).maxCoeff();
}

/// The least and the largest coordinate (m) along a direction.
struct Extent {
  double low = 0.0, high = 0.0;
};

/// The boxes of a surface, enlarged by its radius.
struct SurfaceBoxes {
  std::vector<SweptBox> points;  ///< #points
  std::vector<SweptBox> nodes;   ///< #nodes of its tree
  SweptBox vertices;             ///< around all vertices
};

/// A surface during one tick. Time runs from 0 at its start to 1 at its end; points move on straight lines.
struct MovingSurface {
  const SurfaceTopology* topology = nullptr;
  const Points* position = nullptr;     ///< m, at the start of the tick
  const Points* motion = nullptr;       ///< m, expected displacement during the tick
  double radius = 0.0;                  ///< m, thickness around the points, edges and triangles
  const SurfaceBoxes* boxes = nullptr;  ///< made by fitBoxes() for this tick

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

// --- normal cones ------------------------------------------------------------------------------------------

// Two points are locally the nearest of two surfaces if the direction between them is in the normal cones of
// both surfaces, at the given time of the tick. `outward` is a unit vector away from the surface.

/// About rad: an edge with a smaller fold angle is flat.
constexpr double kFlatFold = 0.02;

/// The tolerances of an edge's normal cone.
struct ConeTolerance {
  double sine;                  ///< of an angle outside the cone
  bool flatToo = false;         ///< flat edges have a cone, also slightly concave ones
  double flatFold = kFlatFold;  ///< about rad: an edge with a smaller fold angle is flat
};

/// Returns the unit normal of a triangle; 0 if it has no area.
Eigen::Vector3d normalAt(const MovingSurface& surface, double time, std::uint32_t triangle);

/// Whether the edge is convex and `outward` is between the normals of its triangles (its Gauss arc). The arc
/// of a boundary edge is half a circle, that of a segment a full one (`outward` is perpendicular to it).
bool isInNormalCone(const MovingSurface& surface, double time, std::uint32_t edge,
                    const Eigen::Vector3d& outward, const ConeTolerance& tolerance);

/// Whether the edge is between two triangles, perpendicular to `normal`, that are in one plane: at rest, and
/// much more nearly at the start and the expected end of the tick.
bool isFlatAlong(const MovingSurface& surface, std::uint32_t edge, const Eigen::Vector3d& normal);

/// Cosine between a direction and the normal above which a triangle faces it. Triangles perpendicular to a
/// flat face do not.
constexpr double kFacing = 0.02;

/// Whether the vertex has no triangles, or the outer side of at least one of them faces `outward`: the cosine
/// is larger than this.
bool facesOutward(const MovingSurface& surface, double time, std::uint32_t vertex,
                  const Eigen::Vector3d& outward, double cosine = kFacing);

/// Whether no edge around the vertex points to the side of `outward`, and a triangle faces `outward`.
bool isInVertexCone(const MovingSurface& surface, double time, std::uint32_t vertex,
                    const Eigen::Vector3d& outward);

// --- searches ----------------------------------------------------------------------------------------------

/// Builds the tree: halves the elements at the median of their centres along the longest side of their box,
/// down to leaves of one element.
std::vector<SurfaceNode> makeSurfaceTree(const Points& rest, const std::vector<SurfaceElement>& elements);

/// Returns the box around all vertices of the surface: a cheap first test for nearness.
SweptBox sweptBounds(const MovingSurface& surface);

/// Computes the boxes. Those of one-sided triangles extend behind them by the depth limit.
void fitBoxes(const MovingSurface& surface, SurfaceBoxes& boxes);

/// Pairs of leaves, by node.
using LeafPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Writes to `near` the pairs of leaves whose boxes are within `margin` (m) of each other. If a and b are the
/// same object: pairs of different leaves, each once, the smaller index first. The order depends only on the
/// trees and boxes. `waiting` is scratch: the pairs of nodes that are not yet visited.
void findNearLeaves(const MovingSurface& a, const MovingSurface& b, double margin, LeafPairs& waiting,
                    LeafPairs& near);

/// Whether there are such pairs.
bool areLeavesNear(const MovingSurface& a, const MovingSurface& b, double margin, LeafPairs& waiting);

/// The nearest point on the triangles of a surface.
struct NearestOnSurface {
  std::uint32_t triangle = kNoFeature;  ///< kNoFeature: none within the search distance
  double distance = 0.0;                ///< m
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
  bool behind = false;  ///< the query point is behind the surface there
};

/// Finds the nearest point at the start of the tick. Of equally near triangles it takes the lowest index.
NearestOnSurface nearestOnSurface(const MovingSurface& surface, const Eigen::Vector3d& point,
                                  double searchDistance);

// --- relative motion ---------------------------------------------------------------------------------------

/// The velocity of a surface:  mean + turn x (x - centre)  at x, up to `deformation`.
struct SurfaceMotion {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();    ///< m/s
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();    ///< rad/s
  double radius = 0.0;                               ///< m, largest distance of a point from the centre
  double spread = 0.0;                               ///< m/s, largest departure of a point from the mean
  double deformation = 0.0;                          ///< m/s, largest departure from the mean and the turn

  bool isZero() const { return mean.isZero(0.0) && spread == 0.0; }
};

/// The positions or velocities of points, also in a PointView.
using PointColumns = Eigen::Ref<const Points, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;

/// Returns the motion of points with these velocities (m/s; for displacements in m the result is in m and
/// rad). The turn is that of least squares: with r = x - centre, the sum over the points of
/// |v - mean - turn x r|^2  is least for  I turn = sum r x v,  where  I = sum (|r|^2 1 - r r^T).
SurfaceMotion fittedMotion(const PointColumns& positions, const PointColumns& velocities);
SurfaceMotion fittedMotion(const PointView& points, Eigen::Index count);

/// The frame in which the motion of a surface relative to another is told: one that does not turn, or the one
/// of surface b, at the centre of a or b.
enum class MotionFrame { Still, AtA, AtB };

/// The velocity of surface a relative to surface b, where they may touch.
struct RelativeMotion {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< m/s, at the centre of the frame
  double spread = 0.0;                             ///< m/s, largest departure from it
  double turn = 0.0;                               ///< rad/s, at which the frame turns

  /// Returns the largest relative speed (m/s) of features of this size (m). The frame's turn moves the ends
  /// of a feature by half its size per rad, and turns the normals of contacts.
  double speed(double featureSize) const { return mean.norm() + spread + 0.5 * featureSize * turn; }
};

/// Returns the relative motion. With the fields of SurfaceMotion, the relative velocity at x is
///     mean_a - mean_b - turn_b x (c - centre_b) + (turn_a - turn_b) x (x - c)   for c = centre_a,
/// up to both deformations. A point of contact is within the radius of c. Likewise for c = centre_b.
RelativeMotion relativeMotion(const SurfaceMotion& a, const SurfaceMotion& b, MotionFrame frame);

/// Returns the frame in which the relative speed of features of this size (m) is least.
MotionFrame calmestFrame(const SurfaceMotion& a, const SurfaceMotion& b, double featureSize);

}  // namespace limber
