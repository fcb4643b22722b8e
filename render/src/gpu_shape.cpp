// SPDX-License-Identifier: Zlib
#include "gpu_shape.h"

#include "shape_layout.h"

#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace limber::render {
namespace {

template <typename T>
GlBuffer upload(const Gl& gl, const std::vector<T>& data) {
  return makeBuffer(gl, data.size() * sizeof(T), data.data());
}

SurfaceMesh makeSurface(const ShapeDesc& desc) {
  if (desc.tubeRadius > 0.0f) {
    return makeTubeMesh(desc.pointCount, desc.tubeSegments);
  }
  SurfaceMesh mesh;
  mesh.indices = desc.triangles;
  const std::size_t count = desc.vertexToPoint.empty() ? skinnedPointCount(desc) : desc.vertexToPoint.size();
  mesh.vertices.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    SurfaceVertex& vertex = mesh.vertices[i];
    vertex.point = pointOf(desc, i);
    vertex.normal = normalOf(desc, i);
    if (!desc.uvs.empty()) {
      vertex.u = desc.uvs[std::size_t{2} * i];
      vertex.v = desc.uvs[std::size_t{2} * i + 1];
    }
  }
  return mesh;
}

std::vector<std::uint32_t> packLines(const ShapeDesc& desc) {
  std::vector<std::uint32_t> packed;
  packed.reserve(desc.lines.size() / 2 * 3);
  for (std::size_t i = 0; 2 * i < desc.lines.size(); ++i) {
    const float perRest = desc.lineRestLengths.empty() ? 0.0f : 1.0f / desc.lineRestLengths[i];
    std::uint32_t bits = 0;
    std::memcpy(&bits, &perRest, sizeof bits);
    packed.insert(packed.end(), {desc.lines[2 * i], desc.lines[2 * i + 1], bits});
  }
  return packed;
}

void addIndexAttribute(const Gl& gl, GLuint layout, GLuint attribute, std::size_t offset) {
  gl.EnableVertexArrayAttrib(layout, attribute);
  gl.VertexArrayAttribBinding(layout, attribute, 0);
  gl.VertexArrayAttribIFormat(layout, attribute, 1, GL_UNSIGNED_INT, static_cast<GLuint>(offset));
}

void addFloatAttribute(const Gl& gl, GLuint layout, GLuint attribute, GLint floats, std::size_t offset) {
  gl.EnableVertexArrayAttrib(layout, attribute);
  gl.VertexArrayAttribBinding(layout, attribute, 0);
  gl.VertexArrayAttribFormat(layout, attribute, floats, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
}

GlVertexArray makeLayout(const Gl& gl, const GpuShape& shape) {
  GlVertexArray layout = makeVertexArray(gl);
  const GLuint name = layout.name();
  gl.VertexArrayVertexBuffer(name, 0, shape.vertices.name(), 0, sizeof(SurfaceVertex));
  gl.VertexArrayElementBuffer(name, shape.indices.name());
  addIndexAttribute(gl, name, 0, offsetof(SurfaceVertex, point));
  addFloatAttribute(gl, name, 1, 2, offsetof(SurfaceVertex, u));
  if (shape.tube) {
    addFloatAttribute(gl, name, 2, 3, offsetof(SurfaceVertex, fraction));
  } else {
    addIndexAttribute(gl, name, 3, offsetof(SurfaceVertex, normal));
  }
  return layout;
}

/// Returns the triangles with points (with a skin: places) instead of vertices.
std::vector<std::uint32_t> weldedTriangles(const ShapeDesc& desc) {
  std::vector<std::uint32_t> points = desc.triangles;
  for (std::uint32_t& corner : points) {
    corner = pointOf(desc, corner);
  }
  return points;
}

void uploadWelded(const Gl& gl, const ShapeDesc& desc, GpuShape& shape) {
  shape.weldedLayout = makeVertexArray(gl);
  GLuint indices = shape.indices.name();
  const std::vector<std::uint32_t> triangles = weldedTriangles(desc);
  shape.closed = isClosed(triangles);
  if (!desc.vertexToPoint.empty()) {
    shape.weldedIndices = upload(gl, triangles);
    indices = shape.weldedIndices.name();
  }
  gl.VertexArrayElementBuffer(shape.weldedLayout.name(), indices);
}

void uploadSurface(const Gl& gl, const ShapeDesc& desc, GpuShape& shape) {
  const SurfaceMesh mesh = makeSurface(desc);
  if (mesh.indices.empty()) {
    return;
  }
  shape.indexCount = static_cast<GLsizei>(mesh.indices.size());
  shape.vertices = upload(gl, mesh.vertices);
  shape.indices = upload(gl, mesh.indices);
  shape.layout = makeLayout(gl, shape);
  if (!shape.tube) {
    uploadWelded(gl, desc, shape);
  }
}

// A storage block larger than the driver's limit would be truncated without an error.
void requireBindable(const Gl& gl, const ShapeDesc& desc, const char* what, std::size_t bytes) {
  GLint64 maxBytes = 0;
  gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &maxBytes);
  if (bytes > static_cast<std::size_t>(maxBytes)) {
    throw std::runtime_error("shape \"" + desc.name + "\": " + what + " take " + std::to_string(bytes) +
                             " bytes, but this driver can bind " + std::to_string(maxBytes));
  }
}

void uploadSkin(const Gl& gl, const ShapeDesc& desc, GpuSkin& skin) {
  skin.dense = isDense(desc.skin, desc.pointCount);
  if (skin.dense) {
    skin.weights = upload(gl, denseWeights(desc.skin, desc.pointCount));
  } else {
    skin.first = upload(gl, desc.skin.first);
    skin.weights = upload(gl, sparseWeights(desc.skin));
  }
  requireBindable(gl, desc, "the skin's weights", skin.weights.bytes());
}

void uploadAdjacency(const Gl& gl, const ShapeDesc& desc, GpuShape& shape) {
  const NormalAdjacency adjacency = makeNormalAdjacency(desc);
  shape.adjacencyOffsets = upload(gl, adjacency.offsets);
  shape.adjacencyCorners = upload(gl, adjacency.corners);
  requireBindable(gl, desc, "the triangles around points", shape.adjacencyCorners.bytes());
}

void addComputeInput(const Gl& gl, const ShapeDesc& desc, GpuShape& shape) {
  if (!desc.skin.first.empty()) {
    uploadSkin(gl, desc, shape.skin);
  }
  if (shape.needsNormals() && !shape.tube) {
    uploadAdjacency(gl, desc, shape);
  }
}

CpuShape makeCpuShape(const ShapeDesc& desc, const GpuShape& shape) {
  CpuShape cpu;
  if (!desc.skin.first.empty()) {
    cpu.skin = makeCpuSkin(desc.skin, desc.pointCount);
  }
  if (shape.needsNormals() && !shape.tube) {
    cpu.triangles = {shape.skinnedPointCount, shape.normalCount, weldedTriangles(desc), {}};
    if (!desc.vertexToNormal.empty()) {
      for (const std::uint32_t vertex : desc.triangles) {
        cpu.triangles.normalsOf.push_back(desc.vertexToNormal[vertex]);
      }
    }
  }
  return cpu;
}

}  // namespace

std::size_t GpuShape::bytes() const {
  return skin.bytes() + vertices.bytes() + indices.bytes() + weldedIndices.bytes() + lines.bytes() +
         adjacencyOffsets.bytes() + adjacencyCorners.bytes();
}

GpuShape makeGpuShape(const Gl& gl, const ShapeDesc& desc, bool computeOnCpu) {
  if (const std::string reason = validate(desc); !reason.empty()) {
    throw std::runtime_error("shape \"" + desc.name + "\": " + reason);
  }
  GpuShape shape;
  shape.name = desc.name;
  shape.pointCount = desc.pointCount;
  shape.skinnedPointCount = static_cast<std::uint32_t>(skinnedPointCount(desc));
  shape.tube = desc.tubeRadius > 0.0f;
  shape.normalCount = static_cast<std::uint32_t>(normalCount(desc));
  shape.sharp = !desc.vertexToNormal.empty();
  shape.smooth = shape.tube || desc.shading == Shading::Smooth;
  shape.twoSided = desc.twoSided;
  shape.castsShadow = desc.castsShadow;
  shape.grid = desc.pattern == Pattern::Grid && !shape.tube;
  shape.radius = shape.tube ? desc.tubeRadius : desc.patternRadius;
  uploadSurface(gl, desc, shape);
  shape.hideBackFaces = !desc.twoSided || (desc.hideBackFaces && shape.closed);
  if (computeOnCpu) {
    shape.cpu = makeCpuShape(desc, shape);
  } else {
    addComputeInput(gl, desc, shape);
  }
  if (!desc.lines.empty()) {
    shape.lineCount = static_cast<GLsizei>(desc.lines.size() / 2);
    shape.lines = upload(gl, packLines(desc));
    requireBindable(gl, desc, "the lines", shape.lines.bytes());
  }
  return shape;
}

ShapeId ShapeTable::add(GpuShape shape) {
  if (free_.empty()) {
    free_.push_back(static_cast<std::uint32_t>(shapes_.size()));
    shapes_.emplace_back();
    extents_.emplace_back();
    generations_.push_back(0);
  }
  const std::uint32_t index = free_.back();
  free_.pop_back();
  extents_[index] = {shape.pointCount, shape.skinnedPointCount, shape.skinned(),
                     shape.needsNormals() ? shape.normalCount : 0};
  shapes_[index] = std::move(shape);
  return {index, generations_[index]};
}

void ShapeTable::remove(ShapeId id) {
  ++generations_[id.index];
  removed_.push_back(id.index);
}

void ShapeTable::freeRemoved() {
  for (const std::uint32_t index : removed_) {
    shapes_[index] = {};
    extents_[index] = {};
    free_.push_back(index);
  }
  removed_.clear();
}

void ShapeTable::require(ShapeId id, const char* caller) const {
  if (id.index >= shapes_.size() || generations_[id.index] != id.generation ||
      shapes_[id.index].pointCount == 0) {
    throw std::runtime_error(std::string(caller) + ": there is no shape with this id");
  }
}

std::size_t ShapeTable::bytes() const {
  std::size_t sum = 0;
  for (const GpuShape& shape : shapes_) {
    sum += shape.bytes();
  }
  return sum;
}

}  // namespace limber::render
