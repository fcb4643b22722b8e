// SPDX-License-Identifier: Zlib
#pragma once

// Declares the elements of a network and its separation along them, for cracks and cuts.

#include <limber/spring_network.h>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace limber {

/// The parts that hold a network together: tetrahedra if they fill it, else the triangles of its surface,
/// else (ropes) its structural springs. Elements that share a facet hold together: a face of tetrahedra, an
/// edge of triangles, a point of springs.
struct Elements {
  std::size_t corners = 0;                         ///< of each: 4, 3 or 2
  std::vector<std::array<std::uint32_t, 4>> all;   ///< #elements, point indices; the first `corners` are used
  std::vector<std::vector<std::uint32_t>> around;  ///< #points, the elements around each, ascending
};

Elements elementsOf(const SpringNetwork& network);

/// Where a network separates.
struct SplitRequest {
  /// #elements: neighbours of opposite signs separate; 0 separates from none
  std::vector<int> side;
  /// Returns whether two neighbours of opposite signs, or the ends of a spring, separate; empty: all do.
  std::function<bool(const Eigen::Vector3d& middle)> within;
  /// Returns the place of a point, for `within`.
  std::function<Eigen::Vector3d(std::uint32_t point)> place;
};

/// A network after its separation.
struct SplitNetwork {
  SharedNetwork network;
  std::vector<std::uint32_t> pointOf;   ///< #points: the point of the old network from which each comes. Old
                                        ///< points keep their indices, new ones follow
  std::vector<std::uint32_t> springOf;  ///< #springs: the spring of the old network
};

/// Separates a network. A point is divided where its elements no longer hold together: each part gets a copy
/// of it with its share of the mass. A spring along separated elements is shared by their copies. One that
/// joins points that no longer hold together is left out. Filled bodies get surface on both sides of a crack.
/// Returns no network if nothing separates: a crack that ends on all sides within a body divides no point.
SplitNetwork splitNetwork(const SpringNetwork& network, const Elements& elements,
                          const SplitRequest& request);

// --- the steps of a separation -----------------------------------------------------------------------------

/// The points of a facet, ascending; unused ones are kNoPoint.
using Facet = std::array<std::uint32_t, 3>;

/// Two elements that share a facet.
struct ElementPair {
  Facet facet;
  std::uint32_t a, b;  ///< elements
  bool separated;
};

/// A copy of a point that its elements no longer share.
struct PointCopy {
  std::uint32_t from;  ///< point of the old network
  double share;        ///< of its mass
};

/// A separation that has been decided.
struct Separation {
  const SpringNetwork& before;
  const Elements& old;
  const SplitRequest& request;
  std::vector<ElementPair> neighbours;
  std::vector<std::array<std::uint32_t, 4>> elements;  ///< #elements, with the points of the new network
  std::vector<PointCopy> points;                       ///< #points of the new network
  std::vector<std::vector<std::uint32_t>> copies;      ///< #old points, of divided points: the points of the
                                                       ///< new network, ascending; else empty

  bool divided(std::uint32_t oldPoint) const { return !copies[oldPoint].empty(); }
};

/// Returns the corner of a new element that comes from the old point; kNoPoint if it has none.
std::uint32_t cornerFrom(const Separation& separation, std::uint32_t element, std::uint32_t oldPoint);

/// Sets the springs and SplitNetwork::springOf.
void splitSprings(const Separation& separation, SpringNetwork& network, std::vector<std::uint32_t>& springOf);

/// Sets the triangles and the render surface.
void splitSurface(const Separation& separation, SpringNetwork& network);

}  // namespace limber
