// SPDX-License-Identifier: Zlib
#include "cpu_normals.h"

#include "mat4.h"

#include <algorithm>
#include <cmath>

namespace limber::render {
namespace {

constexpr Vec3 kUp{0.0f, 1.0f, 0.0f};

Vec3 pointAt(const float* points, std::size_t index) {
  const float* p = points + 3 * index;
  return {p[0], p[1], p[2]};
}

void write(Vec3 v, float* to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

void addTo(Vec3& sum, Vec3 v) { sum = sum + v; }

void sumCrossProducts(const CpuTriangles& mesh, const float* points, Vec3* sums) {
  std::fill_n(sums, mesh.normalCount, Vec3{});
  const std::vector<std::uint32_t>& normals = mesh.normalsOf.empty() ? mesh.corners : mesh.normalsOf;
  for (std::size_t t = 0; t < mesh.corners.size(); t += 3) {
    const std::uint32_t* corner = mesh.corners.data() + t;
    const std::uint32_t* own = normals.data() + t;
    const Vec3 a = pointAt(points, corner[0]);
    const Vec3 normal = cross(pointAt(points, corner[1]) - a, pointAt(points, corner[2]) - a);
    addTo(sums[own[0]], normal);
    addTo(sums[own[1]], normal);
    addTo(sums[own[2]], normal);
  }
}

void writeUnit(const Vec3* sums, std::size_t count, float* normals) {
  for (std::size_t i = 0; i < count; ++i) {
    const float lengthSquared = dot(sums[i], sums[i]);
    write(lengthSquared > 0.0f ? (1.0f / std::sqrt(lengthSquared)) * sums[i] : kUp, normals + 3 * i);
  }
}

/// Returns the axis most nearly perpendicular to the tangent, made perpendicular.
Vec3 acrossFrom(Vec3 tangent) {
  const Vec3 size{std::abs(tangent.x), std::abs(tangent.y), std::abs(tangent.z)};
  const bool isX = size.x <= size.y && size.x <= size.z;
  const Vec3 axis = isX ? Vec3{1.0f, 0.0f, 0.0f} : size.y <= size.z ? kUp : Vec3{0.0f, 0.0f, 1.0f};
  return unitOr(axis - dot(axis, tangent) * tangent, axis);
}

void tubeFrames(const float* points, std::size_t count, float* sides) {
  Vec3 tangent = unitOr(pointAt(points, 1) - pointAt(points, 0), kUp);
  Vec3 side = acrossFrom(tangent);
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 before = pointAt(points, k == 0 ? 0 : k - 1);
    const Vec3 after = pointAt(points, std::min(k + 1, count - 1));
    tangent = unitOr(after - before, tangent);
    side = unitOr(side - dot(side, tangent) * tangent, acrossFrom(tangent));
    write(side, sides + 3 * k);
  }
}

}  // namespace

void computeMeshNormals(const CpuTriangles& mesh, const SmoothInstances& instances, std::vector<Vec3>& sums,
                        RowThreads& threads) {
  constexpr std::size_t kOperationsPerCorner = 10;
  sums.resize(std::size_t{threads.threads()} * mesh.normalCount);
  const auto compute = [&](RowRange range, unsigned part) {
    Vec3* own = sums.data() + std::size_t{part} * mesh.normalCount;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      sumCrossProducts(mesh, instances.points + 3 * i * mesh.pointCount, own);
      writeUnit(own, mesh.normalCount, instances.normals + 3 * i * mesh.normalCount);
    }
  };
  threads.run(instances.count, kOperationsPerCorner * mesh.corners.size(), compute);
}

void computeTubeFrames(std::uint32_t pointCount, const SmoothInstances& instances) {
  for (std::size_t i = 0; i < instances.count; ++i) {
    const std::size_t first = 3 * i * pointCount;
    tubeFrames(instances.points + first, pointCount, instances.normals + first);
  }
}

}  // namespace limber::render
