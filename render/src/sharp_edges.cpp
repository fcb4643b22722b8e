// SPDX-License-Identifier: Zlib
#include "limber/render/shape_desc.h"
#include "mat4.h"
#include "shape_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace limber::render {

std::size_t normalCount(const ShapeDesc& desc) {
  std::size_t count = skinnedPointCount(desc);
  for (const std::uint32_t normal : desc.vertexToNormal) {
    count = std::max(count, std::size_t{normal} + 1);
  }
  return count;
}

namespace {

std::uint32_t pointAtCorner(const ShapeDesc& desc, std::size_t corner) {
  return pointOf(desc, desc.triangles[corner]);
}

std::vector<Vec3> faceNormals(const ShapeDesc& desc, const std::vector<float>& positions) {
  const auto place = [&](std::size_t corner) {
    const float* p = positions.data() + 3 * std::size_t{pointAtCorner(desc, corner)};
    return Vec3{p[0], p[1], p[2]};
  };
  std::vector<Vec3> normals;
  for (std::size_t i = 0; i < desc.triangles.size(); i += 3) {
    normals.push_back(unitOr(cross(place(i + 1) - place(i), place(i + 2) - place(i)), Vec3{}));
  }
  return normals;
}

/// Which corners of triangles share a normal: a union-find.
class CornerGroups {
 public:
  explicit CornerGroups(std::size_t corners) : parent_(corners) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t find(std::size_t corner) {
    while (parent_[corner] != corner) {
      corner = parent_[corner] = parent_[parent_[corner]];
    }
    return corner;
  }
  void join(std::size_t a, std::size_t b) {
    parent_[std::max(find(a), find(b))] = std::min(find(a), find(b));
  }

 private:
  std::vector<std::size_t> parent_;
};

/// A side of a triangle, by the corners at its ends, in the order of their points.
struct Side {
  std::array<std::size_t, 2> corners;
  bool forwards;  ///< The triangle passes it from the lower to the higher point.
};

CornerGroups smoothGroups(const ShapeDesc& desc, const std::vector<Vec3>& normals, float angle) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Side>> edges;
  for (std::size_t i = 0; i < desc.triangles.size(); ++i) {
    const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
    const std::uint32_t a = pointAtCorner(desc, i), b = pointAtCorner(desc, next);
    edges[std::minmax(a, b)].push_back(a < b ? Side{{i, next}, true} : Side{{next, i}, false});
  }
  CornerGroups groups(desc.triangles.size());
  const float limit = std::cos(angle);
  for (const auto& [points, sides] : edges) {
    if (sides.size() != 2 || sides[0].forwards == sides[1].forwards ||
        dot(normals[sides[0].corners[0] / 3], normals[sides[1].corners[0] / 3]) < limit) {
      continue;
    }
    groups.join(sides[0].corners[0], sides[1].corners[0]);
    groups.join(sides[0].corners[1], sides[1].corners[1]);
  }
  return groups;
}

/// Returns the normal of each corner: the first group of a point has the point's number, others follow.
std::vector<std::uint32_t> numberNormals(const ShapeDesc& desc, CornerGroups& groups) {
  const std::size_t points = skinnedPointCount(desc);
  std::vector<std::uint32_t> normals(desc.triangles.size());
  std::vector<bool> taken(points, false);
  auto next = static_cast<std::uint32_t>(points);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    // the root of a group is its first corner
    if (const std::size_t root = groups.find(i); root != i) {
      normals[i] = normals[root];
    } else {
      const std::uint32_t point = pointAtCorner(desc, i);
      normals[i] = taken[point] ? next++ : point;
      taken[point] = true;
    }
  }
  return normals;
}

}  // namespace

void sharpenEdges(ShapeDesc& desc, const std::vector<float>& positions, float angle) {
  const std::string reason = validate(desc);
  if (!reason.empty() || desc.tubeRadius > 0.0f || positions.size() != 3 * skinnedPointCount(desc)) {
    throw std::runtime_error("sharpenEdges: " + (!reason.empty()          ? reason
                                                 : desc.tubeRadius > 0.0f ? "a tube has no edges"
                                                                          : "positions has another size"));
  }
  if (!(angle >= 0.0f && angle <= kPi)) {
    throw std::runtime_error("sharpenEdges: angle is " + std::to_string(angle) + ", but must be 0 to pi");
  }
  desc.vertexToNormal.clear();
  CornerGroups groups = smoothGroups(desc, faceNormals(desc, positions), angle);
  const std::vector<std::uint32_t> normals = numberNormals(desc, groups);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> vertices;
  std::vector<std::uint32_t> points, vertexNormals;
  std::vector<float> uvs;
  for (std::size_t i = 0; i < desc.triangles.size(); ++i) {
    const std::uint32_t old = desc.triangles[i];
    const auto [found, isNew] =
        vertices.try_emplace({old, normals[i]}, static_cast<std::uint32_t>(points.size()));
    if (isNew) {
      points.push_back(pointOf(desc, old));
      vertexNormals.push_back(normals[i]);
      if (!desc.uvs.empty()) {
        uvs.insert(uvs.end(), {desc.uvs[2 * old], desc.uvs[2 * old + 1]});
      }
    }
  }
  for (std::size_t i = 0; i < desc.triangles.size(); ++i) {
    desc.triangles[i] = vertices.at({desc.triangles[i], normals[i]});
  }
  desc.vertexToPoint = std::move(points);
  desc.uvs = std::move(uvs);
  desc.vertexToNormal = std::move(vertexNormals);
}

}  // namespace limber::render
