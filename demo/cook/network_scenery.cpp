// SPDX-License-Identifier: Zlib
#include "cook/network_scenery.h"

#include <array>
#include <cmath>

namespace limber::demo {
namespace {

constexpr std::uint32_t kSides = 6;
constexpr double kTurn = 6.283185307179586;

void addPoint(std::vector<float>& points, const Eigen::Vector3d& p) {
  for (int axis = 0; axis < 3; ++axis) points.push_back(static_cast<float>(p[axis]));
}

/// Six points around each end and two triangles for each side.
void addRod(render::Scenery& rods, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius) {
  const Eigen::Vector3d along = (b - a).normalized();
  const Eigen::Vector3d across = along.unitOrthogonal(), third = along.cross(across);
  const std::uint32_t first = rods.shape.pointCount;
  for (std::uint32_t side = 0; side < kSides; ++side) {
    const double angle = kTurn * side / kSides;
    const Eigen::Vector3d out = radius * (std::cos(angle) * across + std::sin(angle) * third);
    addPoint(rods.points, a + out);
    addPoint(rods.points, b + out);
    const std::uint32_t here = first + 2 * side, next = first + 2 * ((side + 1) % kSides);
    for (const std::uint32_t corner : {here, next, next + 1, here, next + 1, here + 1})
      rods.shape.triangles.push_back(corner);
  }
  rods.shape.pointCount += 2 * kSides;
}

std::vector<Eigen::Vector3d> pointNormals(const SpringNetwork& network) {
  std::vector<Eigen::Vector3d> normals(network.restPoints.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : network.surface) {
    const Eigen::Vector3d& a = network.restPoints[t[0]];
    const Eigen::Vector3d twiceArea = (network.restPoints[t[1]] - a).cross(network.restPoints[t[2]] - a);
    for (const std::uint32_t corner : t) normals[corner] += twiceArea;
  }
  for (Eigen::Vector3d& normal : normals) normal.normalize();
  return normals;
}

}  // namespace

Eigen::AlignedBox3d boundsOf(const SpringNetwork& network) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : network.restPoints) box.extend(p);
  return box;
}

render::Scenery springLines(const SpringNetwork& network, SpringKind kind) {
  render::Scenery lines;
  lines.shape.name = "spring lines";
  for (const NetworkSpring& spring : network.springs) {
    if (spring.kind == kind) lines.shape.lines.insert(lines.shape.lines.end(), {spring.a, spring.b});
  }
  if (lines.shape.lines.empty()) return lines;
  lines.shape.pointCount = static_cast<std::uint32_t>(network.restPoints.size());
  for (const Eigen::Vector3d& p : network.restPoints) addPoint(lines.points, p);
  return lines;
}

render::Scenery springRods(const SpringNetwork& network, SpringKind kind, double radius) {
  render::Scenery rods;
  rods.shape.name = "spring rods";
  rods.shape.shading = render::Shading::Smooth;
  for (const NetworkSpring& spring : network.springs) {
    if (spring.kind == kind) addRod(rods, network.restPoints[spring.a], network.restPoints[spring.b], radius);
  }
  return rods;
}

render::Scenery farWalls(const SpringNetwork& network, double distance) {
  render::Scenery walls;
  walls.shape.name = "far walls";
  if (network.surface.empty()) return walls;
  walls.shape.pointCount = static_cast<std::uint32_t>(network.restPoints.size());
  const std::vector<Eigen::Vector3d> normals = pointNormals(network);
  for (std::size_t i = 0; i < normals.size(); ++i)
    addPoint(walls.points, network.restPoints[i] + distance * normals[i]);
  for (const Triangle& t : network.surface)
    for (const std::uint32_t corner : {t[0], t[2], t[1]}) walls.shape.triangles.push_back(corner);
  return walls;
}

}  // namespace limber::demo
