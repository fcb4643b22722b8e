// SPDX-License-Identifier: Zlib
#include "shape_layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace limber::render {
namespace {

constexpr std::uint32_t kRingsPerSpan = 3;
constexpr std::uint32_t kRingsPerEnd = 4;
constexpr float kHalfPi = 1.57079632679f;

using Ring = SurfaceVertex;

// Adds the rings from the pole to the one before the equator, which belongs to the body of the tube.
void addEnd(std::vector<Ring>& rings, std::uint32_t point, bool first) {
  for (std::uint32_t i = 0; i < kRingsPerEnd; ++i) {
    const std::uint32_t step = first ? i : kRingsPerEnd - 1 - i;
    const float angle = kHalfPi * static_cast<float>(step) / static_cast<float>(kRingsPerEnd);
    Ring ring;
    ring.point = point;
    ring.v = first ? 0.0f : 1.0f;
    ring.out = std::sin(angle);
    ring.along = first ? -std::cos(angle) : std::cos(angle);
    rings.push_back(ring);
  }
}

std::vector<Ring> makeRings(std::uint32_t pointCount) {
  std::vector<Ring> rings;
  addEnd(rings, 0, true);
  const std::uint32_t last = (pointCount - 1) * kRingsPerSpan;
  for (std::uint32_t i = 0; i <= last; ++i) {
    Ring ring;
    ring.point = i / kRingsPerSpan;
    ring.fraction = static_cast<float>(i % kRingsPerSpan) / static_cast<float>(kRingsPerSpan);
    ring.v = static_cast<float>(i) / static_cast<float>(last);
    ring.out = 1.0f;
    rings.push_back(ring);
  }
  addEnd(rings, pointCount - 1, false);
  return rings;
}

}  // namespace

SurfaceMesh makeTubeMesh(std::uint32_t pointCount, std::uint32_t segments) {
  SurfaceMesh mesh;
  const std::vector<Ring> rings = makeRings(pointCount);
  for (const Ring& ring : rings) {
    for (std::uint32_t s = 0; s <= segments; ++s) {
      mesh.vertices.push_back(ring);
      mesh.vertices.back().u = static_cast<float>(s) / static_cast<float>(segments);
    }
  }
  const std::uint32_t stride = segments + 1;
  for (std::uint32_t r = 0; r + 1 < rings.size(); ++r) {
    for (std::uint32_t s = 0; s < segments; ++s) {
      const std::uint32_t a = r * stride + s;
      for (const std::uint32_t index : {a, a + 1, a + stride, a + 1, a + stride + 1, a + stride}) {
        mesh.indices.push_back(index);
      }
    }
  }
  return mesh;
}

bool isClosed(const std::vector<std::uint32_t>& triangles) {
  std::vector<std::uint64_t> edges, reversed;
  edges.reserve(triangles.size());
  reversed.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const std::uint64_t from = triangles[i], to = triangles[i % 3 == 2 ? i - 2 : i + 1];
    edges.push_back(from << 32 | to);
    reversed.push_back(to << 32 | from);
  }
  std::sort(edges.begin(), edges.end());
  std::sort(reversed.begin(), reversed.end());
  return edges == reversed;
}

bool isDense(const Skin& skin, std::uint32_t pointCount) {
  return 2 * skin.weights.size() >= skin.skinnedPointCount() * pointCount;
}

std::vector<float> denseWeights(const Skin& skin, std::uint32_t pointCount) {
  const std::size_t places = skin.skinnedPointCount();
  std::vector<float> matrix(places * pointCount, 0.0f);
  for (std::size_t p = 0; p < places; ++p) {
    for (std::size_t k = skin.first[p]; k < skin.first[p + 1]; ++k) {
      matrix[skin.points[k] * places + p] += skin.weights[k];
    }
  }
  return matrix;
}

std::vector<std::uint32_t> sparseWeights(const Skin& skin) {
  std::vector<std::uint32_t> pairs;
  pairs.reserve(2 * skin.weights.size());
  for (std::size_t k = 0; k < skin.weights.size(); ++k) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &skin.weights[k], sizeof bits);
    pairs.insert(pairs.end(), {skin.points[k], bits});
  }
  return pairs;
}

std::uint32_t normalOf(const ShapeDesc& desc, std::uint32_t vertex) {
  if (!desc.vertexToNormal.empty()) {
    return desc.vertexToNormal[vertex];
  }
  return desc.vertexToPoint.empty() ? vertex : desc.vertexToPoint[vertex];
}

NormalAdjacency makeNormalAdjacency(const ShapeDesc& desc) {
  const auto pointOf = [&desc](std::size_t corner) {
    const std::uint32_t vertex = desc.triangles[corner];
    return desc.vertexToPoint.empty() ? vertex : desc.vertexToPoint[vertex];
  };
  NormalAdjacency adjacency;
  adjacency.offsets.assign(normalCount(desc) + 1, 0);
  for (const std::uint32_t vertex : desc.triangles) {
    ++adjacency.offsets[normalOf(desc, vertex) + std::size_t{1}];
  }
  for (std::size_t n = 0; n < normalCount(desc); ++n) {
    adjacency.offsets[n + 1] += adjacency.offsets[n];
  }
  adjacency.corners.resize(3 * desc.triangles.size());
  std::vector<std::uint32_t> next(adjacency.offsets.begin(), adjacency.offsets.end() - 1);
  for (std::size_t i = 0; i < desc.triangles.size(); ++i) {
    const std::size_t first = i - i % 3, slot = 3 * std::size_t{next[normalOf(desc, desc.triangles[i])]++};
    for (std::size_t k = 0; k < 3; ++k) {
      adjacency.corners[slot + k] = pointOf(first + (i + k) % 3);
    }
  }
  return adjacency;
}

}  // namespace limber::render
