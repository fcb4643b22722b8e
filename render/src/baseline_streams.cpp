// SPDX-License-Identifier: Zlib
#include "baseline_streams.h"

#include "mat4.h"
#include "shape_layout.h"

#include <cstddef>
#include <numeric>
#include <stdexcept>

namespace limber::render {

float* NaiveStream::begin(const FrameLayout& layout) {
  staging_.resize(3 * layout.pointCount);
  return staging_.data();
}

GLuint NaiveStream::bufferFor(std::size_t instance, std::size_t bytes) {
  if (instance >= buffers_.size()) {
    buffers_.resize(instance + 1);
  }
  if (buffers_[instance].bytes() != bytes) {
    buffers_[instance] = makeBuffer(gl_, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
  }
  return buffers_[instance].name();
}

void NaiveStream::upload(const FrameLayout& layout, const ShapeTable& shapes, const GlBuffer& places,
                         std::vector<DrawItem>& items) {
  items.clear();
  for (const InstanceGroup& group : layout.groups) {
    const GpuShape& shape = shapes[group.shape];
    const std::size_t bytes = 3 * sizeof(float) * shape.pointCount;
    for (std::uint32_t i = 0; i < group.instanceCount; ++i) {
      const std::uint32_t skipped = i * shape.pointCount;
      const GLuint buffer = bufferFor(group.firstInstance + i, bytes);
      gl_.NamedBufferSubData(buffer, 0, static_cast<GLsizeiptr>(bytes),
                             staging_.data() + 3 * std::size_t{group.firstPoint + skipped});
      const PointRange points{buffer, 0, static_cast<GLsizeiptr>(bytes), 0};
      const PointRange skinned{places.name(), 0, static_cast<GLsizeiptr>(places.bytes()),
                               group.firstPlace + i * shape.skinnedPointCount};
      items.push_back({&shape, group.firstInstance + i, 1, group.firstNormal + i * shape.skinnedPointCount, points,
                       shape.skinned() ? skinned : points, group.textured});
    }
  }
}

std::size_t NaiveStream::bytes() const {
  std::size_t sum = 0;
  for (const GlBuffer& buffer : buffers_) {
    sum += buffer.bytes();
  }
  return sum;
}

namespace {

constexpr Vec3 kAnyNormal{0.0f, 1.0f, 0.0f};  // For triangles without area, as in the shader.

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

namespace {

GlVertexArray makeLayout(const Gl& gl, GLuint vertices, GLuint indices) {
  GlVertexArray layout = makeVertexArray(gl);
  const GLuint name = layout.name();
  gl.VertexArrayVertexBuffer(name, 0, vertices, 0, sizeof(UnsharedVertex));
  gl.VertexArrayElementBuffer(name, indices);
  addFloatAttribute(gl, name, 0, 4, offsetof(UnsharedVertex, position));
  addFloatAttribute(gl, name, 1, 2, offsetof(UnsharedVertex, u));
  addFloatAttribute(gl, name, 2, 3, offsetof(UnsharedVertex, normal));
  return layout;
}

}  // namespace

float* UnsharedStream::begin(const FrameLayout& layout, const ShapeTable& shapes) {
  for (const InstanceGroup& group : layout.groups) {
    const GpuShape& shape = shapes[group.shape];
    if (shape.tube || shape.skinned()) {
      throw std::runtime_error("StreamPath::Unshared draws neither tubes nor skins, but the shape \"" +
                               shape.name + "\" is one");
    }
  }
  staging_.resize(3 * layout.pointCount);
  return staging_.data();
}

const UnsharedMesh& UnsharedStream::meshOf(std::uint32_t shape, const ShapeTable& shapes) {
  if (meshes_.size() <= shape) {
    meshes_.resize(shape + std::size_t{1});
  }
  ShapeMesh& entry = meshes_[shape];
  if (!entry.read || entry.generation != shapes.generation(shape)) {
    entry = {true, shapes.generation(shape), readUnsharedMesh(gl_, shapes[shape])};
  }
  return entry.mesh;
}

GLuint UnsharedStream::uploadBody(std::size_t instance, const std::vector<UnsharedVertex>& vertices) {
  const std::size_t bytes = vertices.size() * sizeof(UnsharedVertex);
  if (instance >= bodies_.size()) {
    bodies_.resize(instance + 1);
  }
  Body& body = bodies_[instance];
  if (body.vertices.bytes() != bytes) {
    std::vector<std::uint32_t> indices(vertices.size());
    std::iota(indices.begin(), indices.end(), 0u);
    body.vertices = makeBuffer(gl_, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
    body.indices = makeBuffer(gl_, indices.size() * sizeof(std::uint32_t), indices.data());
    body.layout = makeLayout(gl_, body.vertices.name(), body.indices.name());
  }
  gl_.NamedBufferSubData(body.vertices.name(), 0, static_cast<GLsizeiptr>(bytes), vertices.data());
  uploadedBytes_ += bytes;
  return body.layout.name();
}

void UnsharedStream::upload(const FrameLayout& layout, const ShapeTable& shapes,
                            std::vector<DrawItem>& items) {
  items.clear();
  uploadedBytes_ = 0;
  for (const InstanceGroup& group : layout.groups) {
    const UnsharedMesh& mesh = meshOf(group.shape, shapes);
    if (mesh.corners.empty()) {
      continue;
    }
    for (std::uint32_t i = 0; i < group.instanceCount; ++i) {
      const std::size_t firstPoint = group.firstPoint + std::size_t{i} * mesh.pointCount;
      DrawItem item;
      item.shape = &shapes[group.shape];
      item.firstInstance = group.firstInstance + i;
      item.instanceCount = 1;
      item.textured = group.textured;
      item.layout = uploadBody(item.firstInstance, maker_.make(mesh, staging_.data() + 3 * firstPoint));
      items.push_back(item);
    }
  }
}

std::size_t UnsharedStream::bytes() const {
  std::size_t sum = 0;
  for (const Body& body : bodies_) {
    sum += body.vertices.bytes() + body.indices.bytes();
  }
  return sum;
}

}  // namespace limber::render
