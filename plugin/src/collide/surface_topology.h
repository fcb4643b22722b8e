// SPDX-License-Identifier: Zlib
#pragma once

#include "core/mesh_edges.h"
#include "solver/point_state.h"

#include <limber/result.h>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

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
/// each feature is in one element's care.
struct SurfaceElement {
  std::array<std::uint32_t, 3> corners;  ///< the last repeated
  std::uint32_t triangle = kNoFeature;
  std::array<std::uint32_t, 3> vertices = {kNoFeature, kNoFeature, kNoFeature};  ///< in its care
  std::array<std::uint32_t, 3> edges = {kNoFeature, kNoFeature, kNoFeature};     ///< in its care
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
  std::vector<double> depthLimit;      ///< #triangles, m: farther behind it, a vertex is none of its business
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

}  // namespace limber
