// SPDX-License-Identifier: Zlib
#pragma once

// The features of two surfaces that may touch: lists of those in the region that both surfaces reach, and the
// pairs of them whose boxes overlap.

#include "collide/surface.h"

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

struct NearVertex {
  std::uint32_t vertex, element;  ///< the element that owns it
  MovingFeature<1> feature;
};

struct NearEdge {
  std::uint32_t edge;
  MovingFeature<2> feature;
  Eigen::Vector3d along;  ///< m, at the start
};

struct NearTriangle {
  std::uint32_t triangle, element, leaf;  ///< the element that owns it, and its node
  MovingFeature<3> feature;
  Eigen::Vector3d normal;  ///< at the start, unit; 0 if it has no area
};

NearVertex nearVertex(const MovingSurface& surface, std::uint32_t vertex, std::uint32_t element = kNoFeature);
NearEdge nearEdge(const MovingSurface& surface, std::uint32_t edge);
NearTriangle nearTriangle(const MovingSurface& surface, std::uint32_t triangle,
                          std::uint32_t element = kNoFeature, std::uint32_t leaf = 0);

/// Boxes in single precision, of which several are compared at a time. They are rounded outward: those that
/// overlap in double precision overlap here, too.
class BoxList {
 public:
  void clear();
  void add(const SweptBox& box);

  const SweptBox& bounds() const { return bounds_; }

  /// Writes to `near` the pairs of boxes that overlap, of this list and of another.
  void findNear(const BoxList& other, LeafPairs& near) const;

 private:
  static constexpr std::size_t kChunk = 8;  // a multiple of 4

  struct Chunk {
    std::array<std::array<float, kChunk>, 3> low, high;
    std::array<float, 4> allLow, allHigh;  ///< around all; the fourth coordinate fills a SIMD register
  };

  static bool areNear(const Chunk& a, const Chunk& b);
  static std::uint32_t findNear(const Chunk& a, std::size_t i, const Chunk& b);

  std::vector<Chunk> chunks_;
  std::size_t size_ = 0;
  SweptBox bounds_;
};

/// The features of a surface that may touch another one.
struct NearFeatures {
  std::vector<NearVertex> vertices;
  std::vector<NearEdge> edges;
  std::vector<NearTriangle> triangles;
  BoxList vertexBoxes, edgeBoxes, triangleBoxes;  ///< of each of these
};

/// The region in which a surface may touch features of another one.
struct NearRegion {
  SweptBox features;    ///< around vertices and edges
  SweptBox all;         ///< also around what is behind triangles
  double margin = 0.0;  ///< m, largest distance of boxes that are near
};

/// Which features of a surface are listed.
struct ListedFeatures {
  bool vertices = true, triangles = true;
  const std::vector<std::uint8_t>* leftOut = nullptr;  ///< #edges, not 0: not listed; nullptr: all are
};

/// Lists the features of a surface that may touch those in the region. Their boxes are enlarged by half the
/// margin, so that those of two lists overlap where they are near.
void listNearFeatures(const MovingSurface& surface, const ListedFeatures& listed, const NearRegion& region,
                      NearFeatures& near);

}  // namespace limber
