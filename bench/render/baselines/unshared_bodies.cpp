// SPDX-License-Identifier: Zlib
#include "render/baselines/baseline.h"

#include "staged_baseline.h"
#include "unshared_programs.h"
#include "unshared_vertices.h"

#include <cstddef>
#include <numeric>

namespace limber::bench {
namespace {

using namespace render;

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
  void uploadAll();
  void drawBody(const BodyDraw& body, const ShaderProgram& program);
  void castShadows(const ShadowMap& map);
  void drawSurfaces(bool shadows);
  void drawPicture(const DrawOptions& options, bool shadows);

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
  if (meshes_.size() <= shape) {
    meshes_.resize(shape + std::size_t{1});
  }
  UnsharedMesh& mesh = meshes_[shape];
  if (mesh.pointCount == 0) {
    mesh = readUnsharedMesh(parts_.gl, parts_.shapes[shape]);
  }
  return mesh;
}

GLuint UnsharedBodies::uploadBody(std::size_t instance, const std::vector<UnsharedVertex>& vertices) {
  const Gl& gl = parts_.gl;
  const std::size_t bytes = vertices.size() * sizeof(UnsharedVertex);
  if (instance >= bodies_.size()) {
    bodies_.resize(instance + 1);
  }
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
  if (mesh.corners.empty()) {
    return;
  }
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
  for (const InstanceGroup& group : parts_.layout.groups) {
    uploadGroup(group);
  }
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
    if (body.shape->castsShadow) {
      drawBody(body, programs_.depth());
    }
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
  if (castsShadows) {
    castShadows(parts_.requireShadowMap());
  }
  parts_.beginTarget(castsShadows);
  drawSurfaces(castsShadows);
  parts_.finishTarget(options);
}

void UnsharedBodies::draw(const Camera& camera, const Light& light, const DrawOptions& options) {
  requireOpen();
  if (options.mode == DrawMode::Wireframe) {
    throw std::runtime_error("unshared bodies have no lines to draw");
  }
  Stopwatch watch;
  const GlStateGuard guard(parts_.gl, parts_.sharedContext);
  uploadAll();
  parts_.uploadFrameData(camera, light, options, {});
  parts_.stats.uploadMs = watch.lap();
  drawPicture(options, light.shadows);
  parts_.stats.submitMs = watch.lap();
  closeFrame();
}

std::size_t UnsharedBodies::bytes() const {
  std::size_t sum = 0;
  for (const BodyBuffers& body : bodies_) {
    sum += body.vertices.bytes() + body.indices.bytes();
  }
  return sum;
}

}  // namespace

std::unique_ptr<Baseline> makeUnsharedBodies(Renderer& renderer) {
  return std::make_unique<UnsharedBodies>(renderer);
}

}  // namespace limber::bench
