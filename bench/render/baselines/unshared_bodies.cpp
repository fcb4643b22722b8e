// SPDX-License-Identifier: Zlib
#include "gpu_shape.h"
#include "mat4.h"
#include "program_set.h"
#include "shape_layout.h"
#include "staged_baseline.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace limber::bench {
namespace {

using namespace render;

// --- vertices ---

/// A vertex in the format of Bullet's example browser.
struct UnsharedVertex {
  Vec3 position;
  float w = 1.0f;
  Vec3 normal;
  float u = 0.0f, v = 0.0f;
};
static_assert(sizeof(UnsharedVertex) == 36, "uploaded as it lies");

/// The triangles of a shape in plain memory, with three separate corners each.
struct UnsharedMesh {
  struct Corner {
    std::uint32_t point = 0;
    float u = 0.0f, v = 0.0f;
  };

  std::vector<Corner> corners;  ///< 3 per triangle.
  std::uint32_t pointCount = 0;
  bool smooth = false;
};

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

/// Reads the mesh back from the GPU, where the renderer has its only copy. Not for tubes.
UnsharedMesh readUnsharedMesh(const Gl& gl, const GpuShape& shape) {
  UnsharedMesh mesh;
  mesh.pointCount = shape.pointCount;
  mesh.smooth = shape.smooth;
  if (shape.indexCount == 0) return mesh;
  const auto vertices = readBuffer<SurfaceVertex>(gl, shape.vertices);
  for (const std::uint32_t index : readBuffer<std::uint32_t>(gl, shape.indices))
    mesh.corners.push_back({vertices[index].point, vertices[index].u, vertices[index].v});
  return mesh;
}

/// Computes vertices from points on the CPU; reuses its memory.
class UnsharedVertices {
 public:
  /// `points`: 3 floats for each point of the mesh. The result is valid until the next call.
  const std::vector<UnsharedVertex>& make(const UnsharedMesh& mesh, const float* points);

 private:
  void sumNormals(const UnsharedMesh& mesh, const float* points);

  std::vector<Vec3> normals_;  // One per point.
  std::vector<UnsharedVertex> vertices_;
};

void UnsharedVertices::sumNormals(const UnsharedMesh& mesh, const float* points) {
  normals_.assign(mesh.pointCount, {});
  for (std::size_t i = 0; i < mesh.corners.size(); i += 3) {
    const Vec3 normal = doubleArea(&mesh.corners[i], points);
    for (std::size_t k = i; k < i + 3; ++k) {
      Vec3& sum = normals_[mesh.corners[k].point];
      sum = sum + normal;
    }
  }
  for (Vec3& normal : normals_) normal = unitOr(normal, kAnyNormal);
}

const std::vector<UnsharedVertex>& UnsharedVertices::make(const UnsharedMesh& mesh, const float* points) {
  if (mesh.smooth) sumNormals(mesh, points);
  vertices_.resize(mesh.corners.size());
  Vec3 face;
  for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
    if (!mesh.smooth && i % 3 == 0) face = unitOr(doubleArea(&mesh.corners[i], points), kAnyNormal);
    const UnsharedMesh::Corner& corner = mesh.corners[i];
    vertices_[i] = {pointAt(points, corner.point), 1.0f, mesh.smooth ? normals_[corner.point] : face,
                    corner.u, corner.v};
  }
  return vertices_;
}

// --- programs ---

constexpr const char* kVertexShader = R"glsl(
layout(location = 0) in vec4 vertexPosition;
layout(location = 1) in vec2 vertexUv;
layout(location = 2) in vec3 vertexNormal;

layout(std430, binding = 2) readonly buffer Instances { vec4 instances[]; };  // Two each: colour and layer, material.

out vec3 toEye;
out vec3 shadowCoord;
out vec2 uv;
flat out vec4 look;
out vec3 smoothNormal;

void main() {
  vec3 position = vertexPosition.xyz;
  smoothNormal = vertexNormal;
  toEye = frame.eye.xyz - position;
  shadowCoord = (frame.worldToShadow * vec4(position, 1.0)).xyz;
  uv = vertexUv;
  look = instances[2u * firstInstance];
  gl_Position = frame.viewProjection * vec4(position, 1.0);
}
)glsl";

constexpr const char* kDepthVertexShader = R"glsl(
layout(location = 0) in vec4 vertexPosition;

void main() {
  vec3 shadow = (frame.worldToShadow * vec4(vertexPosition.xyz, 1.0)).xyz;
  gl_Position = vec4(2.0 * shadow.x - 1.0, 1.0 - 2.0 * shadow.y, shadow.z, 1.0);
}
)glsl";

// In place of the renderer's shading_normal.glsl, whose flat shapes have no normals at their vertices.
constexpr const char* kFlatNormal = R"glsl(
in vec3 toEye;
in vec3 smoothNormal;

vec3 shadingNormal() {
  vec3 normal = normalize(smoothNormal);
#ifdef TWO_SIDED
  normal = gl_FrontFacing ? normal : -normal;
#endif
  return normal;
}
)glsl";

/// Vertex attributes of all these programs.
enum UnsharedAttribute : GLuint { kPosition = 0, kTextureCoordinates = 1, kNormal = 2 };

/// Programs for complete vertices, each compiled on first use: vertex shaders of their own, and the
/// renderer's fragment shaders. Every function throws std::runtime_error if the driver rejects a shader.
class UnsharedPrograms {
 public:
  UnsharedPrograms(const Gl& gl, int shadowTaps) : gl_(gl), shadowTaps_(shadowTaps) {}

  const ShaderProgram& surface(const SurfaceVariant& variant);  ///< Of a mesh.
  const ShaderProgram& depth();

 private:
  const Gl& gl_;
  int shadowTaps_;
  std::array<ShaderProgram, 32> surfaces_;
  ShaderProgram depth_;
};

const ShaderProgram& UnsharedPrograms::surface(const SurfaceVariant& variant) {
  ShaderProgram& program = surfaces_[indexOf(variant)];
  if (program.name() == 0) {
    const ShaderText normal =
        variant.smooth ? ShaderText("shading_normal.glsl") : ShaderText("flat normal", kFlatNormal);
    program =
        buildProgram(gl_,
                     {{GL_VERTEX_SHADER, {"frame.glsl", {"unshared vertices", kVertexShader}}},
                      {GL_FRAGMENT_SHADER,
                       {"frame.glsl", "background.glsl", normal, "surface_colour.glsl", "surface.frag"}}},
                     definesOf(variant, shadowTaps_));
  }
  return program;
}

const ShaderProgram& UnsharedPrograms::depth() {
  if (depth_.name() == 0) {
    depth_ = buildProgram(gl_,
                          {{GL_VERTEX_SHADER, {"frame.glsl", {"unshared depth", kDepthVertexShader}}},
                           {GL_FRAGMENT_SHADER, {"depth.frag"}}},
                          {});
  }
  return depth_;
}

// --- bodies ---

/// Buffers of one body. Its indices count its vertices up.
struct BodyBuffers {
  GlBuffer vertices;
  GlBuffer indices;
  GlVertexArray layout;
};

/// One draw call per pass.
struct BodyDraw {
  const GpuShape* shape = nullptr;
  std::uint32_t instance = 0;
  bool textured = false;
  GLuint layout = 0;
};

class UnsharedBodies final : public StagedBaseline {
 public:
  explicit UnsharedBodies(Renderer& renderer)
      : StagedBaseline(renderer), programs_(parts_.gl, parts_.desc.shadowTaps) {}

  void beginFrame() override;
  void draw(const Camera& camera, const Light& light, const DrawOptions& options) override;
  std::size_t bytes() const override;

 private:
  const UnsharedMesh& meshOf(std::uint32_t shape);
  GLuint uploadBody(std::size_t instance, const std::vector<UnsharedVertex>& vertices);
  void uploadGroup(const InstanceGroup& group);
  void uploadAll() override;
  void drawBody(const BodyDraw& body, const ShaderProgram& program);
  void castShadows(const ShadowMap& map);
  void drawSurfaces(bool shadows);
  void drawPicture(const DrawOptions& options, bool shadows) override;

  UnsharedPrograms programs_;
  std::vector<UnsharedMesh> meshes_;  // By shape, read when first drawn.
  UnsharedVertices maker_;
  std::vector<BodyBuffers> bodies_;  // By instance.
  std::vector<BodyDraw> draws_;
};

void addFloatAttribute(const Gl& gl, GLuint layout, GLuint attribute, GLint floats, std::size_t offset) {
  gl.EnableVertexArrayAttrib(layout, attribute);
  gl.VertexArrayAttribBinding(layout, attribute, 0);
  gl.VertexArrayAttribFormat(layout, attribute, floats, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
}

GlVertexArray makeLayout(const Gl& gl, GLuint vertices, GLuint indices) {
  GlVertexArray layout = makeVertexArray(gl);
  const GLuint name = layout.name();
  gl.VertexArrayVertexBuffer(name, 0, vertices, 0, sizeof(UnsharedVertex));
  gl.VertexArrayElementBuffer(name, indices);
  addFloatAttribute(gl, name, kPosition, 4, offsetof(UnsharedVertex, position));
  addFloatAttribute(gl, name, kTextureCoordinates, 2, offsetof(UnsharedVertex, u));
  addFloatAttribute(gl, name, kNormal, 3, offsetof(UnsharedVertex, normal));
  return layout;
}

void UnsharedBodies::beginFrame() {
  layOut();
  for (const InstanceGroup& group : parts_.layout.groups) {
    const GpuShape& shape = parts_.shapes[group.shape];
    if (shape.tube || shape.skinned()) {
      throw std::runtime_error("unshared bodies are neither tubes nor skins, but the shape \"" + shape.name +
                               "\" is one");
    }
  }
  openFrame();
}

const UnsharedMesh& UnsharedBodies::meshOf(std::uint32_t shape) {
  if (meshes_.size() <= shape) meshes_.resize(shape + std::size_t{1});
  UnsharedMesh& mesh = meshes_[shape];
  if (mesh.pointCount == 0) mesh = readUnsharedMesh(parts_.gl, parts_.shapes[shape]);
  return mesh;
}

GLuint UnsharedBodies::uploadBody(std::size_t instance, const std::vector<UnsharedVertex>& vertices) {
  const Gl& gl = parts_.gl;
  const std::size_t bytes = vertices.size() * sizeof(UnsharedVertex);
  if (instance >= bodies_.size()) bodies_.resize(instance + 1);
  BodyBuffers& body = bodies_[instance];
  if (body.vertices.bytes() != bytes) {
    std::vector<std::uint32_t> indices(vertices.size());
    std::iota(indices.begin(), indices.end(), 0u);
    body.vertices = makeBuffer(gl, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
    body.indices = makeBuffer(gl, indices.size() * sizeof(std::uint32_t), indices.data());
    body.layout = makeLayout(gl, body.vertices.name(), body.indices.name());
  }
  gl.NamedBufferSubData(body.vertices.name(), 0, static_cast<GLsizeiptr>(bytes), vertices.data());
  parts_.stats.bytesStreamed += bytes;
  return body.layout.name();
}

void UnsharedBodies::uploadGroup(const InstanceGroup& group) {
  const UnsharedMesh& mesh = meshOf(group.shape);
  if (mesh.corners.empty()) return;
  for (std::uint32_t i = 0; i < group.instanceCount; ++i) {
    const std::size_t firstPoint = group.firstPoint + std::size_t{i} * mesh.pointCount;
    const std::uint32_t instance = group.firstInstance + i;
    const GLuint layout = uploadBody(instance, maker_.make(mesh, staged(firstPoint)));
    draws_.push_back({&parts_.shapes[group.shape], instance, group.textured, layout});
  }
}

void UnsharedBodies::uploadAll() {
  draws_.clear();
  parts_.stats.bytesStreamed = 0;
  for (const InstanceGroup& group : parts_.layout.groups) uploadGroup(group);
}

void UnsharedBodies::drawBody(const BodyDraw& body, const ShaderProgram& program) {
  const Gl& gl = parts_.gl;
  const GLuint name = program.name();
  gl.UseProgram(name);
  gl.ProgramUniform1ui(name, program.location(DrawUniform::FirstInstance), body.instance);
  gl.ProgramUniform1f(name, program.location(DrawUniform::ShapeRadius), body.shape->radius);
  gl.BindVertexArray(body.layout);
  gl.DrawElementsInstanced(GL_TRIANGLES, body.shape->indexCount, GL_UNSIGNED_INT, nullptr, 1);
  ++parts_.stats.shapeDrawCalls;
  ++parts_.stats.drawCalls;
}

void UnsharedBodies::castShadows(const ShadowMap& map) {
  const Gl& gl = parts_.gl;
  map.begin();
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_LESS);
  gl.Enable(GL_DEPTH_CLAMP);  // As in the renderer.
  gl.Disable(GL_CULL_FACE);
  for (const BodyDraw& body : draws_) {
    if (body.shape->castsShadow) drawBody(body, programs_.depth());
  }
  gl.Disable(GL_DEPTH_CLAMP);
}

void UnsharedBodies::drawSurfaces(bool shadows) {
  const Gl& gl = parts_.gl;
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_LESS);
  for (const BodyDraw& body : draws_) {
    const GpuShape& shape = *body.shape;
    if (shape.twoSided) {
      gl.Disable(GL_CULL_FACE);
    } else {
      gl.Enable(GL_CULL_FACE);
    }
    drawBody(body, programs_.surface({VertexSource::Mesh, shape.smooth, shape.twoSided, shape.grid, shadows,
                                      body.textured}));
  }
}

void UnsharedBodies::drawPicture(const DrawOptions& options, bool shadows) {
  parts_.items.clear();
  parts_.bindFrameData();
  const bool castsShadows = shadows && !draws_.empty();
  if (castsShadows) castShadows(parts_.requireShadowMap());
  parts_.beginTarget(castsShadows);
  drawSurfaces(castsShadows);
  parts_.finishTarget(options);
}

void UnsharedBodies::draw(const Camera& camera, const Light& light, const DrawOptions& options) {
  if (options.mode == DrawMode::Wireframe) throw std::runtime_error("unshared bodies have no lines to draw");
  StagedBaseline::draw(camera, light, options);
}

std::size_t UnsharedBodies::bytes() const {
  std::size_t sum = 0;
  for (const BodyBuffers& body : bodies_) sum += body.vertices.bytes() + body.indices.bytes();
  return sum;
}

}  // namespace

std::unique_ptr<Baseline> makeUnsharedBodies(Renderer& renderer) {
  return std::make_unique<UnsharedBodies>(renderer);
}

}  // namespace limber::bench
