// SPDX-License-Identifier: Zlib
#include "limber/render/scenery.h"

#include "limber/render/rigid_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace limber::render {
namespace {

constexpr float kTwoPi = 6.28318530718f;

// Corner i of a cube has bit 0 for x, bit 1 for y, bit 2 for z; faces counter-clockwise from outside.
constexpr std::array<std::array<std::uint32_t, 4>, 6> kBoxFaces{
    {{5, 1, 3, 7}, {0, 4, 6, 2}, {6, 7, 3, 2}, {0, 1, 5, 4}, {4, 5, 7, 6}, {1, 0, 2, 3}}};

void addPoint(std::vector<float>& points, float x, float y, float z) {
  points.insert(points.end(), {x, y, z});
}

void addQuad(std::vector<std::uint32_t>& triangles, std::uint32_t a, std::uint32_t b, std::uint32_t c,
             std::uint32_t d) {
  triangles.insert(triangles.end(), {a, b, c, a, c, d});
}

}  // namespace

Scenery makeBox(Vec3 centre, Vec3 halfExtents) {
  Scenery box;
  box.shape.name = "box";
  box.shape.pointCount = 8;
  for (unsigned i = 0; i < 8; ++i) {
    addPoint(box.points, centre.x + ((i & 1u) != 0 ? halfExtents.x : -halfExtents.x),
             centre.y + ((i & 2u) != 0 ? halfExtents.y : -halfExtents.y),
             centre.z + ((i & 4u) != 0 ? halfExtents.z : -halfExtents.z));
  }
  for (const auto& face : kBoxFaces) {
    const auto first = static_cast<std::uint32_t>(box.shape.vertexToPoint.size());
    box.shape.vertexToPoint.insert(box.shape.vertexToPoint.end(), face.begin(), face.end());
    box.shape.uvs.insert(box.shape.uvs.end(), {0.0f, 1.0f, 1.0f, 1.0f, 1.0f, 0.0f, 0.0f, 0.0f});
    addQuad(box.shape.triangles, first, first + 1, first + 2, first + 3);
  }
  return box;
}

Scenery makeUvSphere(Vec3 centre, float radius, std::uint32_t rings, std::uint32_t segments) {
  Scenery sphere;
  ShapeDesc& shape = sphere.shape;
  shape.name = "sphere";
  shape.shading = Shading::Smooth;
  shape.pointCount = (rings - 1) * segments + 2;
  const std::uint32_t south = shape.pointCount - 1;
  addPoint(sphere.points, centre.x, centre.y + radius, centre.z);
  for (std::uint32_t r = 1; r < rings; ++r) {
    const float polar = 0.5f * kTwoPi * static_cast<float>(r) / static_cast<float>(rings);
    for (std::uint32_t s = 0; s < segments; ++s) {
      const float around = kTwoPi * static_cast<float>(s) / static_cast<float>(segments);
      addPoint(sphere.points, centre.x + radius * std::sin(polar) * std::cos(around),
               centre.y + radius * std::cos(polar), centre.z - radius * std::sin(polar) * std::sin(around));
    }
  }
  addPoint(sphere.points, centre.x, centre.y - radius, centre.z);
  // The vertices of the last column repeat the points of the first, so that u can run from 0 to 1.
  for (std::uint32_t r = 0; r <= rings; ++r) {
    for (std::uint32_t s = 0; s <= segments; ++s) {
      const std::uint32_t ringPoint = 1 + (r - 1) * segments + s % segments;
      shape.vertexToPoint.push_back(r == 0 ? 0 : r == rings ? south : ringPoint);
      shape.uvs.push_back(static_cast<float>(s) / static_cast<float>(segments));
      shape.uvs.push_back(static_cast<float>(r) / static_cast<float>(rings));
    }
  }
  for (std::uint32_t r = 0; r < rings; ++r) {
    for (std::uint32_t s = 0; s < segments; ++s) {
      const std::uint32_t a = r * (segments + 1) + s;
      const std::uint32_t b = a + segments + 1;
      if (r > 0) {
        shape.triangles.insert(shape.triangles.end(), {a, b, a + 1});
      }
      if (r + 1 < rings) {
        shape.triangles.insert(shape.triangles.end(), {a + 1, b, b + 1});
      }
    }
  }
  return sphere;
}

Scenery makeFloor(Vec3 centre, float halfSize, float extent) {
  Scenery floor;
  floor.shape.name = "floor";
  floor.shape.pointCount = 4;
  floor.shape.castsShadow = false;
  floor.shape.pattern = Pattern::Grid;
  floor.shape.patternRadius = halfSize;
  constexpr std::array<std::array<float, 2>, 4> kCorners{{{-1, 1}, {1, 1}, {1, -1}, {-1, -1}}};
  for (const auto& corner : kCorners) {
    const float x = std::max(halfSize, extent) * corner[0];
    const float z = std::max(halfSize, extent) * corner[1];
    addPoint(floor.points, centre.x + x, centre.y, centre.z + z);
    floor.shape.uvs.insert(floor.shape.uvs.end(), {x, z});
  }
  addQuad(floor.shape.triangles, 0, 1, 2, 3);
  return floor;
}

namespace {

float largestCoordinate(const std::vector<float>& points) {
  float largest = 0.0f;
  for (const float x : points) {
    largest = std::max(largest, std::abs(x));
  }
  return largest > 0.0f ? largest : 1.0f;
}

}  // namespace

// With p0 the origin and p1 to p3 at `reach` along the axes, a point (x, y, z) of the scenery is at
//   p0 + (x / reach) (p1 - p0) + (y / reach) (p2 - p0) + (z / reach) (p3 - p0).
// Because `reach` is the size of the surface, weights are at most 4, and rounding errors stay small far from
// the world's origin.
RigidShape makeRigid(const Scenery& scenery) {
  RigidShape rigid{scenery.shape, largestCoordinate(scenery.points)};
  rigid.shape.pointCount = 4;
  Skin& skin = rigid.shape.skin;
  skin.first = {0};
  for (std::size_t i = 0; i + 2 < scenery.points.size(); i += 3) {
    const float x = scenery.points[i] / rigid.reach;
    const float y = scenery.points[i + 1] / rigid.reach;
    const float z = scenery.points[i + 2] / rigid.reach;
    skin.points.insert(skin.points.end(), {0, 1, 2, 3});
    skin.weights.insert(skin.weights.end(), {1.0f - x - y - z, x, y, z});
    skin.first.push_back(static_cast<std::uint32_t>(skin.weights.size()));
  }
  return rigid;
}

void writeFrame(float reach, const Frame& frame, float* xyz) {
  const Vec3 o = frame.origin;
  for (const Vec3 axis : {Vec3{}, frame.x, frame.y, frame.z}) {
    *xyz++ = o.x + reach * axis.x;
    *xyz++ = o.y + reach * axis.y;
    *xyz++ = o.z + reach * axis.z;
  }
}

}  // namespace limber::render
