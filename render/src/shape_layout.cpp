// SPDX-License-Identifier: Zlib
// Lays the arrays of shapes out for the shaders, and checks descriptions of shapes.

#include "shape_layout.h"

#include "limber/render/shape_desc.h"

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
  return desc.vertexToNormal.empty() ? pointOf(desc, vertex) : desc.vertexToNormal[vertex];
}

NormalAdjacency makeNormalAdjacency(const ShapeDesc& desc) {
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
      adjacency.corners[slot + k] = pointOf(desc, desc.triangles[first + (i + k) % 3]);
    }
  }
  return adjacency;
}

// --- checks ------------------------------------------------------------------------------------------------

namespace {

std::string number(std::size_t value) { return std::to_string(value); }

std::string checkIndices(const char* array, const std::vector<std::uint32_t>& indices, std::size_t limit,
                         const char* what) {
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] >= limit) {
      return std::string(array) + "[" + number(i) + "] is " + number(indices[i]) + ", but there are only " +
             number(limit) + " " + what;
    }
  }
  return {};
}

std::string checkLines(const ShapeDesc& desc) {
  if (desc.lines.size() % 2 != 0) {
    return "lines has " + number(desc.lines.size()) + " indices, which is no multiple of 2";
  }
  if (!desc.lineRestLengths.empty() && 2 * desc.lineRestLengths.size() != desc.lines.size()) {
    return "lineRestLengths has " + number(desc.lineRestLengths.size()) + " entries for " +
           number(desc.lines.size() / 2) + " lines";
  }
  for (std::size_t i = 0; i < desc.lineRestLengths.size(); ++i) {
    if (!(desc.lineRestLengths[i] > 0.0f) || !std::isfinite(desc.lineRestLengths[i])) {
      return "lineRestLengths[" + number(i) + "] is not a positive length";
    }
  }
  return checkIndices("lines", desc.lines, desc.pointCount, "points");
}

std::string checkTube(const ShapeDesc& desc) {
  if (!std::isfinite(desc.tubeRadius)) {
    return "tubeRadius is not finite";
  }
  if (desc.pointCount < 2) {
    return "a tube needs at least 2 points";
  }
  if (desc.tubeSegments < 3) {
    return "tubeSegments is " + number(desc.tubeSegments) + ", but a tube needs at least 3";
  }
  if (!desc.triangles.empty() || !desc.vertexToPoint.empty() || !desc.uvs.empty() ||
      !desc.vertexToNormal.empty() || !desc.skin.first.empty()) {
    return "a tube makes its own vertices: triangles, vertexToPoint, uvs, vertexToNormal and skin must be "
           "empty";
  }
  return {};
}

std::string checkPattern(const ShapeDesc& desc) {
  if (desc.pattern == Pattern::Grid && (desc.uvs.empty() || !(desc.patternRadius > 0.0f))) {
    return "the grid pattern needs uvs and a positive patternRadius";
  }
  return {};
}

std::string checkSkinRows(const std::vector<std::uint32_t>& first, std::size_t weights) {
  if (first.size() < 2) {
    return "skin.first has one entry, but a skin with places has one more than places";
  }
  if (first.front() != 0 || first.back() != weights) {
    return "skin.first goes from " + number(first.front()) + " to " + number(first.back()) +
           ", but must go from 0 to the " + number(weights) + " weights";
  }
  for (std::size_t i = 0; i + 1 < first.size(); ++i) {
    if (first[i] > first[i + 1]) {
      return "skin.first[" + number(i + 1) + "] is below the entry before it";
    }
  }
  return {};
}

std::string checkSkin(const ShapeDesc& desc) {
  const Skin& skin = desc.skin;
  if (skin.points.size() != skin.weights.size()) {
    return "skin.points has " + number(skin.points.size()) + " entries for " + number(skin.weights.size()) +
           " weights";
  }
  if (skin.first.empty()) {
    return skin.weights.empty() ? "" : "skin.first is empty, but there are weights";
  }
  for (std::size_t i = 0; i < skin.weights.size(); ++i) {
    if (!std::isfinite(skin.weights[i])) {
      return "skin.weights[" + number(i) + "] is not finite";
    }
  }
  const std::string reason = checkSkinRows(skin.first, skin.weights.size());
  return reason.empty() ? checkIndices("skin.points", skin.points, desc.pointCount, "points") : reason;
}

std::string checkMesh(const ShapeDesc& desc) {
  if (std::string reason = checkSkin(desc); !reason.empty()) {
    return reason;
  }
  const std::size_t vertices =
      desc.vertexToPoint.empty() ? skinnedPointCount(desc) : desc.vertexToPoint.size();
  if (!desc.uvs.empty() && desc.uvs.size() != 2 * vertices) {
    return "uvs has " + number(desc.uvs.size()) + " floats for " + number(vertices) + " vertices";
  }
  for (std::size_t i = 0; i < desc.uvs.size(); ++i) {
    if (!std::isfinite(desc.uvs[i])) {
      return "uvs[" + number(i) + "] is not finite";
    }
  }
  if (!desc.vertexToNormal.empty() && desc.vertexToNormal.size() != vertices) {
    return "vertexToNormal has " + number(desc.vertexToNormal.size()) + " entries for " + number(vertices) +
           " vertices";
  }
  if (desc.triangles.size() % 3 != 0) {
    return "triangles has " + number(desc.triangles.size()) + " indices, which is no multiple of 3";
  }
  if (desc.triangles.empty() && desc.lines.empty()) {
    return "there is nothing to draw: no triangles, no lines and no tubeRadius";
  }
  std::string reason = checkIndices("vertexToPoint", desc.vertexToPoint, skinnedPointCount(desc),
                                    desc.skin.first.empty() ? "points" : "places of the skin");
  if (reason.empty()) {
    reason = checkIndices("triangles", desc.triangles, vertices, "vertices");
  }
  if (reason.empty()) {
    reason = checkIndices("vertexToNormal", desc.vertexToNormal, skinnedPointCount(desc) + vertices,
                          "points and vertices");
  }
  return reason.empty() ? checkPattern(desc) : reason;
}

}  // namespace

std::string validate(const ShapeDesc& desc) {
  if (desc.pointCount == 0) {
    return "pointCount is 0";
  }
  const std::string reason = desc.tubeRadius > 0.0f ? checkTube(desc) : checkMesh(desc);
  return reason.empty() ? checkLines(desc) : reason;
}

}  // namespace limber::render
