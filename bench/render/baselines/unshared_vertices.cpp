// SPDX-License-Identifier: Zlib
#include "unshared_vertices.h"

#include "mat4.h"
#include "shape_layout.h"

#include <cstddef>

namespace limber::bench {
namespace {

using namespace render;

constexpr Vec3 kAnyNormal{0.0f, 1.0f, 0.0f};  // For triangles without area, as in the renderer's shader.

template <typename T>
std::vector<T> readBuffer(const Gl& gl, const GlBuffer& buffer) {
  std::vector<T> values(buffer.bytes() / sizeof(T));
  gl.GetNamedBufferSubData(buffer.name(), 0, static_cast<GLsizeiptr>(values.size() * sizeof(T)),
                           values.data());
  return values;
}

Vec3 pointAt(const float* points, std::uint32_t index) {
  const float* p = points + 3 * std::size_t{index};
  return {p[0], p[1], p[2]};
}

/// Returns the normal with the length of twice the triangle's area.
Vec3 doubleArea(const UnsharedMesh::Corner* triangle, const float* points) {
  const Vec3 a = pointAt(points, triangle[0].point);
  return cross(pointAt(points, triangle[1].point) - a, pointAt(points, triangle[2].point) - a);
}

}  // namespace

UnsharedMesh readUnsharedMesh(const Gl& gl, const GpuShape& shape) {
  UnsharedMesh mesh;
  mesh.pointCount = shape.pointCount;
  mesh.smooth = shape.smooth;
  if (shape.indexCount == 0) {
    return mesh;
  }
  const auto vertices = readBuffer<SurfaceVertex>(gl, shape.vertices);
  for (const std::uint32_t index : readBuffer<std::uint32_t>(gl, shape.indices)) {
    mesh.corners.push_back({vertices[index].point, vertices[index].u, vertices[index].v});
  }
  return mesh;
}

void UnsharedVertices::sumNormals(const UnsharedMesh& mesh, const float* points) {
  normals_.assign(mesh.pointCount, {});
  for (std::size_t i = 0; i < mesh.corners.size(); i += 3) {
    const Vec3 normal = doubleArea(&mesh.corners[i], points);
    for (std::size_t k = i; k < i + 3; ++k) {
      Vec3& sum = normals_[mesh.corners[k].point];
      sum = sum + normal;
    }
  }
  for (Vec3& normal : normals_) {
    normal = unitOr(normal, kAnyNormal);
  }
}

const std::vector<UnsharedVertex>& UnsharedVertices::make(const UnsharedMesh& mesh, const float* points) {
  if (mesh.smooth) {
    sumNormals(mesh, points);
  }
  vertices_.resize(mesh.corners.size());
  Vec3 face;
  for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
    if (!mesh.smooth && i % 3 == 0) {
      face = unitOr(doubleArea(&mesh.corners[i], points), kAnyNormal);
    }
    const UnsharedMesh::Corner& corner = mesh.corners[i];
    vertices_[i] = {pointAt(points, corner.point), 1.0f, mesh.smooth ? normals_[corner.point] : face,
                    corner.u, corner.v};
  }
  return vertices_;
}

}  // namespace limber::bench
