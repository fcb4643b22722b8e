// SPDX-License-Identifier: Zlib
#pragma once

// Declares the steps of a separation: the points, the springs, and the surface that is drawn.

#include "solver/split.h"

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

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
