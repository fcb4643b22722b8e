// SPDX-License-Identifier: Zlib
#include "tube_mesh.h"

#include <cmath>

namespace limber::render {
namespace {

constexpr std::uint32_t kRingsPerSpan = 3;
constexpr std::uint32_t kRingsPerEnd = 4;
constexpr float kQuarterTurn = 1.57079632679f;

using Ring = SurfaceVertex;

// From the pole to just before the equator, which belongs to the body of the tube.
void addEnd(std::vector<Ring>& rings, std::uint32_t point, bool first) {
  for (std::uint32_t i = 0; i < kRingsPerEnd; ++i) {
    const std::uint32_t step = first ? i : kRingsPerEnd - 1 - i;
    const float angle = kQuarterTurn * static_cast<float>(step) / static_cast<float>(kRingsPerEnd);
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

}  // namespace limber::render
