// SPDX-License-Identifier: Zlib
#include "cook/outward_surface.h"

#include "cook/triangle_geometry.h"
#include "core/mesh_edges.h"
#include "core/surface_components.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace limber {
namespace {

using Eigen::Vector3d;

constexpr double kFullAngle = 4.0 * 3.14159265358979323846;

struct Component {
  std::vector<Triangle> triangles;
  Eigen::AlignedBox3d box;
  double volume = 0.0;  ///< m^3, signed; 0 unless closed
};

std::vector<Component> split(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles,
                             const SurfaceComponents& components) {
  std::vector<Component> parts(components.count);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Component& part = parts[components.ofTriangle[t]];
    part.triangles.push_back(triangles[t]);
    for (const std::uint32_t corner : triangles[t]) part.box.extend(points[corner]);
  }
  for (Component& part : parts) {
    const EdgeDefects defects = findEdgeDefects(part.triangles);
    if (defects.open + defects.nonManifold + defects.inconsistent == 0)
      part.volume = signedVolume(points, part.triangles);
  }
  return parts;
}

/// Whether one of its corners is; components that pass through each other are not within each other.
bool isWithin(const std::vector<Vector3d>& points, const Component& inner, const Component& outer) {
  if (!outer.box.contains(inner.box)) return false;
  const Vector3d& place = points[inner.triangles.front().front()];
  double angle = 0.0;
  for (const Triangle& t : outer.triangles)
    angle += solidAngle({points[t[0]], points[t[1]], points[t[2]]}, place);
  return std::abs(angle) > 0.5 * kFullAngle;
}

const Component& outermostAround(const std::vector<Vector3d>& points, const Component& part,
                                 const std::vector<Component>& parts) {
  const Component* outermost = &part;
  for (const Component& other : parts)
    if (std::abs(other.volume) > std::abs(outermost->volume) && isWithin(points, part, other))
      outermost = &other;
  return *outermost;
}

}  // namespace

std::vector<bool> facingInward(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles) {
  const SurfaceComponents components = findComponents(points.size(), triangles);
  const std::vector<Component> parts = split(points, triangles, components);
  if (std::none_of(parts.begin(), parts.end(), [](const Component& c) { return c.volume < 0.0; }))
    return std::vector<bool>(triangles.size(), false);
  std::vector<bool> turned;
  for (const Component& part : parts)
    turned.push_back(part.volume != 0.0 && outermostAround(points, part, parts).volume < 0.0);
  std::vector<bool> marked;
  for (const std::uint32_t component : components.ofTriangle) marked.push_back(turned[component]);
  return marked;
}

void turn(std::vector<Triangle>& triangles, const std::vector<bool>& marked) {
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (marked[t]) std::swap(triangles[t][1], triangles[t][2]);
}

std::vector<Triangle> turnedOutward(const std::vector<Vector3d>& points, std::vector<Triangle> triangles) {
  turn(triangles, facingInward(points, triangles));
  return triangles;
}

}  // namespace limber
