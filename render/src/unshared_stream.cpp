// SPDX-License-Identifier: Zlib
#include "unshared_stream.h"

#include <cstddef>
#include <numeric>
#include <stdexcept>

namespace limber::render {
namespace {

void addAttribute(const Gl& gl, GLuint layout, GLuint attribute, GLint floats, std::size_t offset) {
  gl.EnableVertexArrayAttrib(layout, attribute);
  gl.VertexArrayAttribBinding(layout, attribute, 0);
  gl.VertexArrayAttribFormat(layout, attribute, floats, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
}

GlVertexArray makeLayout(const Gl& gl, GLuint vertices, GLuint indices) {
  GlVertexArray layout = makeVertexArray(gl);
  const GLuint name = layout.name();
  gl.VertexArrayVertexBuffer(name, 0, vertices, 0, sizeof(UnsharedVertex));
  gl.VertexArrayElementBuffer(name, indices);
  addAttribute(gl, name, 0, 4, offsetof(UnsharedVertex, position));
  addAttribute(gl, name, 1, 2, offsetof(UnsharedVertex, u));
  addAttribute(gl, name, 2, 3, offsetof(UnsharedVertex, normal));
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
  ShapeMesh& known = meshes_[shape];
  if (!known.read || known.generation != shapes.generation(shape)) {
    known = {true, shapes.generation(shape), readUnsharedMesh(gl_, shapes[shape])};
  }
  return known.mesh;
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
