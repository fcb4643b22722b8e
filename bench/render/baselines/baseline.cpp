// SPDX-License-Identifier: Zlib
#include "render/baselines/baseline.h"

#include "gpu_shape.h"
#include "mat4.h"
#include "program_set.h"
#include "renderer_parts.h"
#include "shape_layout.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace limber::bench {
namespace {

using namespace render;

/// A baseline that keeps the points of its frame in plain memory, in the order of the renderer's layout.
class StagedBaseline : public Baseline {
 public:
  explicit StagedBaseline(Renderer& renderer) : parts_(RendererAccess::parts(renderer)) {}

  float* points(InstanceId instance) const final {
    const FrameLayout::Slice* slice = parts_.layout.find(instance);
    if (!open_ || slice == nullptr)
      throw std::runtime_error("points(): this instance is not part of an open frame of the baseline");
    return points_ + 3 * std::size_t{slice->firstPoint};
  }

  void draw(const Camera& camera, const Light& light, const DrawOptions& options) override {
    if (!open_) throw std::logic_error("draw() of a baseline without beginFrame()");
    Stopwatch watch;
    const GlStateGuard guard(parts_.gl, parts_.sharedContext);
    uploadAll();
    parts_.uploadFrameData(camera, light, options, {});
    parts_.stats.uploadMs = watch.lap();
    drawPicture(options, light.shadows);
    parts_.stats.submitMs = watch.lap();
    open_ = false;
  }

 protected:
  virtual void uploadAll() = 0;
  virtual void drawPicture(const DrawOptions& options, bool shadows) = 0;

  /// Orders the instances as the renderer does.
  void layOut() {
    if (parts_.frame.open)
      throw std::logic_error("a baseline cannot draw while a frame of the renderer is open");
    parts_.layOutInstances();
  }
  void openFrame() {
    floats_.resize(3 * parts_.layout.pointCount);
    points_ = floats_.data();
    parts_.stats.waitMs = 0.0;  // It never waits for the GPU here.
    open_ = true;
  }
  /// The points from this one on.
  const float* staged(std::size_t firstPoint) const { return points_ + 3 * firstPoint; }

  RendererAccess::Parts& parts_;

 private:
  std::vector<float> floats_;
  float* points_ = nullptr;
  bool open_ = false;
};

// --- points body by body ---

class NaivePoints final : public StagedBaseline {
 public:
  explicit NaivePoints(Renderer& renderer) : StagedBaseline(renderer) {
    if (renderer.computesOnCpu())
      throw std::runtime_error("naive points need a renderer with ComputeOn::Gpu");
  }

  void beginFrame() override {
    layOut();
    parts_.reserveComputed();
    openFrame();
  }
  std::size_t bytes() const override {
    std::size_t sum = 0;
    for (const GlBuffer& buffer : buffers_) sum += buffer.bytes();
    return sum;
  }

 private:
  GLuint bufferFor(std::size_t instance, std::size_t bytes) {
    if (instance >= buffers_.size()) buffers_.resize(instance + 1);
    if (buffers_[instance].bytes() != bytes)
      buffers_[instance] = makeBuffer(parts_.gl, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
    return buffers_[instance].name();
  }
  DrawItem upload(const InstanceGroup& group, std::uint32_t indexInGroup) {
    const GpuShape& shape = parts_.shapes[group.shape];
    const std::uint32_t instance = group.firstInstance + indexInGroup;
    const std::uint32_t skinnedBefore = indexInGroup * shape.skinnedPointCount;
    const auto bytes = static_cast<GLsizeiptr>(3 * sizeof(float) * shape.pointCount);
    const GLuint buffer = bufferFor(instance, static_cast<std::size_t>(bytes));
    parts_.gl.NamedBufferSubData(buffer, 0, bytes,
                                 staged(group.firstPoint + std::size_t{indexInGroup} * shape.pointCount));
    const PointRange points{buffer, 0, bytes, 0};
    return {&shape,
            instance,
            1,
            points,
            shape.skinned() ? parts_.placeRange().from(group.firstPlace + skinnedBefore) : points,
            parts_.normalRange().from(group.firstNormal + skinnedBefore),
            group.textured};
  }
  void uploadAll() override {
    parts_.items.clear();
    for (const InstanceGroup& group : parts_.layout.groups)
      for (std::uint32_t i = 0; i < group.instanceCount; ++i) parts_.items.push_back(upload(group, i));
    parts_.stats.bytesStreamed = 3 * sizeof(float) * parts_.layout.pointCount;
  }
  void drawPicture(const DrawOptions& options, bool shadows) override {
    parts_.drawPicture(options, shadows);
  }

  std::vector<GlBuffer> buffers_;  // By instance.
};

// --- vertices body by body: vertices ---

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

/// Sums the normals of the triangles about each point. `points`: 3 floats for each point of the mesh.
void sumNormals(const UnsharedMesh& mesh, const float* points, std::vector<Vec3>& normals) {
  normals.assign(mesh.pointCount, {});
  for (std::size_t i = 0; i < mesh.corners.size(); i += 3) {
    const Vec3 normal = doubleArea(&mesh.corners[i], points);
    for (std::size_t k = i; k < i + 3; ++k) {
      Vec3& sum = normals[mesh.corners[k].point];
      sum = sum + normal;
    }
  }
  for (Vec3& normal : normals) normal = unitOr(normal, kAnyNormal);
}

/// Computes vertices on the CPU. `normals` are those of the points of a smooth mesh.
void makeVertices(const UnsharedMesh& mesh, const float* points, const std::vector<Vec3>& normals,
                  std::vector<UnsharedVertex>& vertices) {
  vertices.resize(mesh.corners.size());
  Vec3 face;
  for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
    if (!mesh.smooth && i % 3 == 0) face = unitOr(doubleArea(&mesh.corners[i], points), kAnyNormal);
    const UnsharedMesh::Corner& corner = mesh.corners[i];
    vertices[i] = {pointAt(points, corner.point), 1.0f, mesh.smooth ? normals[corner.point] : face, corner.u,
                   corner.v};
  }
}

// --- their programs ---

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

  /// Of a mesh.
  const ShaderProgram& surface(const SurfaceVariant& variant) {
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
  const ShaderProgram& depth() {
    if (depth_.name() == 0) {
      depth_ = buildProgram(gl_,
                            {{GL_VERTEX_SHADER, {"frame.glsl", {"unshared depth", kDepthVertexShader}}},
                             {GL_FRAGMENT_SHADER, {"depth.frag"}}},
                            {});
    }
    return depth_;
  }

 private:
  const Gl& gl_;
  int shadowTaps_;
  std::array<ShaderProgram, 32> surfaces_;
  ShaderProgram depth_;
};

// --- their bodies ---

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

class UnsharedBodies final : public StagedBaseline {
 public:
  explicit UnsharedBodies(Renderer& renderer)
      : StagedBaseline(renderer), programs_(parts_.gl, parts_.desc.shadowTaps) {}

  void beginFrame() override {
    layOut();
    for (const InstanceGroup& group : parts_.layout.groups) {
      const GpuShape& shape = parts_.shapes[group.shape];
      if (shape.tube || shape.skinned())
        throw std::runtime_error("unshared bodies are neither tubes nor skins, but the shape \"" +
                                 shape.name + "\" is one");
    }
    openFrame();
  }
  void draw(const Camera& camera, const Light& light, const DrawOptions& options) override {
    if (options.mode == DrawMode::Wireframe)
      throw std::runtime_error("unshared bodies have no lines to draw");
    StagedBaseline::draw(camera, light, options);
  }
  std::size_t bytes() const override {
    std::size_t sum = 0;
    for (const BodyBuffers& body : bodies_) sum += body.vertices.bytes() + body.indices.bytes();
    return sum;
  }

 private:
  const UnsharedMesh& meshOf(std::uint32_t shape) {
    if (meshes_.size() <= shape) meshes_.resize(shape + std::size_t{1});
    UnsharedMesh& mesh = meshes_[shape];
    if (mesh.pointCount == 0) mesh = readUnsharedMesh(parts_.gl, parts_.shapes[shape]);
    return mesh;
  }
  /// Uploads the vertices that were made last.
  GLuint uploadBody(std::size_t instance) {
    const Gl& gl = parts_.gl;
    const std::size_t bytes = vertices_.size() * sizeof(UnsharedVertex);
    if (instance >= bodies_.size()) bodies_.resize(instance + 1);
    BodyBuffers& body = bodies_[instance];
    if (body.vertices.bytes() != bytes) {
      std::vector<std::uint32_t> indices(vertices_.size());
      std::iota(indices.begin(), indices.end(), 0u);
      body.vertices = makeBuffer(gl, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
      body.indices = makeBuffer(gl, indices.size() * sizeof(std::uint32_t), indices.data());
      body.layout = makeLayout(gl, body.vertices.name(), body.indices.name());
    }
    gl.NamedBufferSubData(body.vertices.name(), 0, static_cast<GLsizeiptr>(bytes), vertices_.data());
    parts_.stats.bytesStreamed += bytes;
    return body.layout.name();
  }
  void uploadGroup(const InstanceGroup& group) {
    const UnsharedMesh& mesh = meshOf(group.shape);
    if (mesh.corners.empty()) return;
    for (std::uint32_t i = 0; i < group.instanceCount; ++i) {
      const float* points = staged(group.firstPoint + std::size_t{i} * mesh.pointCount);
      if (mesh.smooth) sumNormals(mesh, points, normals_);
      makeVertices(mesh, points, normals_, vertices_);
      const std::uint32_t instance = group.firstInstance + i;
      draws_.push_back({&parts_.shapes[group.shape], instance, group.textured, uploadBody(instance)});
    }
  }
  void uploadAll() override {
    draws_.clear();
    parts_.stats.bytesStreamed = 0;
    for (const InstanceGroup& group : parts_.layout.groups) uploadGroup(group);
  }
  void drawBody(const BodyDraw& body, const ShaderProgram& program) {
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
  void castShadows(const ShadowMap& map) {
    const Gl& gl = parts_.gl;
    map.begin();
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    gl.Enable(GL_DEPTH_CLAMP);  // As in the renderer.
    gl.Disable(GL_CULL_FACE);
    for (const BodyDraw& body : draws_)
      if (body.shape->castsShadow) drawBody(body, programs_.depth());
    gl.Disable(GL_DEPTH_CLAMP);
  }
  void drawSurfaces(bool shadows) {
    const Gl& gl = parts_.gl;
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    for (const BodyDraw& body : draws_) {
      const GpuShape& shape = *body.shape;
      shape.twoSided ? gl.Disable(GL_CULL_FACE) : gl.Enable(GL_CULL_FACE);
      drawBody(body, programs_.surface({VertexSource::Mesh, shape.smooth, shape.twoSided, shape.grid, shadows,
                                        body.textured}));
    }
  }
  void drawPicture(const DrawOptions& options, bool shadows) override {
    parts_.items.clear();
    parts_.bindFrameData();
    const bool castsShadows = shadows && !draws_.empty();
    if (castsShadows) castShadows(parts_.requireShadowMap());
    parts_.beginTarget(castsShadows);
    drawSurfaces(castsShadows);
    parts_.finishTarget(options);
  }

  UnsharedPrograms programs_;
  std::vector<UnsharedMesh> meshes_;  // By shape, read when first drawn.
  std::vector<Vec3> normals_;         // Of the points of one body after the other, as the vertices.
  std::vector<UnsharedVertex> vertices_;
  std::vector<BodyBuffers> bodies_;  // By instance.
  std::vector<BodyDraw> draws_;
};

}  // namespace

std::unique_ptr<Baseline> makeNaivePoints(Renderer& renderer) {
  return std::make_unique<NaivePoints>(renderer);
}

std::unique_ptr<Baseline> makeUnsharedBodies(Renderer& renderer) {
  return std::make_unique<UnsharedBodies>(renderer);
}

}  // namespace limber::bench
