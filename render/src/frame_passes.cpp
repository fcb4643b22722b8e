// SPDX-License-Identifier: Zlib
#include "frame_passes.h"

#include "gl_state.h"

#include <algorithm>

namespace limber::render {
namespace {

constexpr std::uint32_t kGroupSize = 64;
constexpr std::uint32_t kMaxGroupsPerRow = 65535;  // The limit that every OpenGL driver supports.

void setUniforms(const PassContext& pass, const ShaderProgram& program, const DrawItem& item,
                 std::uint32_t first, std::uint32_t count) {
  const auto set = [&](DrawUniform uniform, std::uint32_t value) {
    pass.gl.ProgramUniform1ui(program.name(), program.location(uniform), value);
  };
  set(DrawUniform::FirstPoint, first);
  set(DrawUniform::FirstInstance, item.firstInstance);
  set(DrawUniform::PointCount, count);
  set(DrawUniform::FirstNormal, item.normals.first);
  set(DrawUniform::NormalCount, item.shape->normalCount);
  pass.gl.ProgramUniform1f(program.name(), program.location(DrawUniform::ShapeRadius), item.shape->radius);
}

void bind(const PassContext& pass, StorageBinding binding, const PointRange& range) {
  pass.gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, range.buffer, range.byteOffset, range.bytes);
}

void use(const PassContext& pass, const ShaderProgram& program, const DrawItem& item, const PointRange& range,
         std::uint32_t count) {
  pass.gl.UseProgram(program.name());
  setUniforms(pass, program, item, range.first, count);
  bind(pass, kPoints, range);
  if (item.shape->needsNormals()) {
    bind(pass, kNormals, item.normals);
  }
}

void useWithPoints(const PassContext& pass, const ShaderProgram& program, const DrawItem& item) {
  use(pass, program, item, item.points, item.shape->pointCount);
}

void useWithPlaces(const PassContext& pass, const ShaderProgram& program, const DrawItem& item) {
  use(pass, program, item, item.places, item.shape->skinnedPointCount);
}

VertexSource sourceOf(const DrawItem& item, bool needsUvs) {
  if (item.shape->tube) {
    return VertexSource::Tube;
  }
  return needsUvs ? VertexSource::Mesh : VertexSource::Welded;
}

GLuint layoutOf(const DrawItem& item, VertexSource source) {
  return source == VertexSource::Welded ? item.shape->weldedLayout.name() : item.shape->layout.name();
}

void drawTriangles(const PassContext& pass, const DrawItem& item, VertexSource source) {
  pass.gl.BindVertexArray(layoutOf(item, source));
  pass.gl.DrawElementsInstanced(GL_TRIANGLES, item.shape->indexCount, GL_UNSIGNED_INT, nullptr,
                                static_cast<GLsizei>(item.instanceCount));
  ++pass.stats.shapeDrawCalls;
  ++pass.stats.drawCalls;
}

void dispatch(const PassContext& pass, const ShaderProgram& program, std::uint32_t invocations) {
  pass.gl.ProgramUniform1ui(program.name(), program.location(DrawUniform::Invocations), invocations);
  const std::uint32_t groups = (invocations + kGroupSize - 1) / kGroupSize;
  const std::uint32_t columns = std::min(groups, kMaxGroupsPerRow);
  pass.gl.DispatchCompute(columns, (groups + columns - 1) / columns, 1);
  ++pass.stats.dispatches;
}

void setCulling(const Gl& gl, bool on) { setCap(gl, GL_CULL_FACE, on); }

}  // namespace

void computePlaces(const PassContext& pass) {
  // The passes of the previous frame may still read the buffer that is now overwritten.
  pass.gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  for (const DrawItem& item : pass.items) {
    const GpuShape& shape = *item.shape;
    if (!shape.skinned()) {
      continue;
    }
    const ShaderProgram& program = pass.programs.skin(shape.skin.dense);
    useWithPoints(pass, program, item);
    const auto set = [&](DrawUniform uniform, std::uint32_t value) {
      pass.gl.ProgramUniform1ui(program.name(), program.location(uniform), value);
    };
    set(DrawUniform::FirstPlace, item.places.first);
    set(DrawUniform::PlaceCount, shape.skinnedPointCount);
    pass.gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kPlaces, item.places.buffer);
    pass.gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kSkinFirst, shape.skin.first.name());
    pass.gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kSkinWeights, shape.skin.weights.name());
    dispatch(pass, program, item.instanceCount * shape.skinnedPointCount);
  }
  pass.gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void computeNormals(const PassContext& pass) {
  pass.gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  for (const DrawItem& item : pass.items) {
    const GpuShape& shape = *item.shape;
    if (!shape.needsNormals()) {
      continue;
    }
    const ShaderProgram& program = pass.programs.normals(shape.tube);
    useWithPlaces(pass, program, item);
    if (shape.tube) {
      dispatch(pass, program, item.instanceCount);
    } else {
      pass.gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kOffsets, shape.adjacencyOffsets.name());
      pass.gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kCorners, shape.adjacencyCorners.name());
      dispatch(pass, program, item.instanceCount * shape.normalCount);
    }
  }
  pass.gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void castShadows(const PassContext& pass, const ShadowMap& map) {
  map.begin();
  pass.gl.Enable(GL_DEPTH_TEST);
  pass.gl.DepthFunc(GL_LESS);
  // Casters in front of the map's near plane are clamped to it, not lost.
  pass.gl.Enable(GL_DEPTH_CLAMP);
  for (const DrawItem& item : pass.items) {
    if (item.shape->indexCount > 0 && item.shape->castsShadow) {
      // The back faces of a closed surface lie behind its front faces, seen from the sun.
      setCulling(pass.gl, item.shape->closed);
      const VertexSource source = sourceOf(item, false);
      useWithPlaces(pass, pass.programs.depth(source), item);
      drawTriangles(pass, item, source);
    }
  }
  pass.gl.Disable(GL_DEPTH_CLAMP);
}

namespace {

bool isDrawn(const GpuShape& shape, DrawMode mode) {
  return shape.indexCount > 0 && (mode != DrawMode::Wireframe || shape.lineCount == 0);
}

void coverPicture(const PassContext& pass, const ShaderProgram& program) {
  pass.gl.UseProgram(program.name());
  pass.gl.BindVertexArray(pass.emptyLayout);
  pass.gl.DrawArraysInstanced(GL_TRIANGLES, 0, 3, 1);
  ++pass.stats.drawCalls;
}

}  // namespace

void computeOpenness(const PassContext& pass, const OpennessMap& map, DrawMode mode) {
  map.beginDepth();
  pass.gl.Enable(GL_DEPTH_TEST);
  pass.gl.DepthFunc(GL_LESS);
  for (const DrawItem& item : pass.items) {
    if (isDrawn(*item.shape, mode)) {
      setCulling(pass.gl, item.shape->hideBackFaces);
      const VertexSource source = sourceOf(item, false);
      useWithPlaces(pass, pass.programs.depth(source, true), item);
      drawTriangles(pass, item, source);
    }
  }
  pass.gl.Disable(GL_DEPTH_TEST);
  setCulling(pass.gl, false);
  map.beginRaw();
  coverPicture(pass, pass.programs.occlusion());
  map.beginSmooth();
  coverPicture(pass, pass.programs.occlusionBlur());
}

void drawSurfaces(const PassContext& pass, DrawMode mode, bool shadows) {
  pass.gl.Enable(GL_DEPTH_TEST);
  pass.gl.DepthFunc(GL_LESS);
  for (const DrawItem& item : pass.items) {
    const GpuShape& shape = *item.shape;
    if (!isDrawn(shape, mode)) {
      continue;
    }
    setCulling(pass.gl, shape.hideBackFaces);
    const VertexSource source = sourceOf(item, shape.grid || shape.sharp || item.textured || pass.gallery);
    useWithPlaces(
        pass,
        pass.programs.surface({source, shape.smooth, shape.twoSided, shape.grid, shadows, item.textured}),
        item);
    drawTriangles(pass, item, source);
  }
}

void drawLines(const PassContext& pass) {
  pass.gl.Enable(GL_DEPTH_TEST);
  pass.gl.DepthFunc(GL_LESS);
  setCulling(pass.gl, false);
  pass.gl.BindVertexArray(pass.emptyLayout);
  for (const DrawItem& item : pass.items) {
    if (item.shape->lineCount == 0) {
      continue;
    }
    useWithPoints(pass, pass.programs.lines(), item);
    pass.gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kLines, item.shape->lines.name());
    pass.gl.DrawArraysInstanced(GL_TRIANGLES, 0, 6 * item.shape->lineCount,
                                static_cast<GLsizei>(item.instanceCount));
    ++pass.stats.shapeDrawCalls;
    ++pass.stats.drawCalls;
  }
}

void drawBackdrop(const PassContext& pass) {
  pass.gl.Enable(GL_DEPTH_TEST);
  pass.gl.DepthFunc(GL_LEQUAL);
  setCulling(pass.gl, false);
  coverPicture(pass, pass.programs.backdrop());
}

void drawOverlay(const PassContext& pass, const OverlayLines& lines, float hiddenOpacity) {
  const Gl& gl = pass.gl;
  const ShaderProgram& program = pass.programs.overlay(false);
  gl.UseProgram(program.name());
  gl.BindVertexArray(pass.emptyLayout);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kLines, lines.buffer());
  setCulling(gl, false);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthMask(GL_FALSE);
  gl.Enablei(GL_BLEND, 0);
  gl.BlendFuncSeparatei(0, GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  const auto draw = [&](GLenum depth, float opacity) {
    gl.DepthFunc(depth);
    gl.ProgramUniform1f(program.name(), program.location(DrawUniform::Opacity), opacity);
    gl.DrawArraysInstanced(GL_TRIANGLES, 0, 6 * lines.count(), 1);
    ++pass.stats.drawCalls;
  };
  if (hiddenOpacity > 0.0f) {
    draw(GL_GREATER, hiddenOpacity);
  }
  draw(GL_LEQUAL, 1.0f);
  gl.Disablei(GL_BLEND, 0);
  gl.DepthMask(GL_TRUE);
}

void drawLegend(const PassContext& pass, ColourMap map, const BarRectangle& bar) {
  const ShaderProgram& program = pass.programs.legend(map);
  pass.gl.Disable(GL_DEPTH_TEST);
  setCulling(pass.gl, false);
  pass.gl.UseProgram(program.name());
  pass.gl.ProgramUniform4f(program.name(), program.location(DrawUniform::Rectangle), bar.left, bar.top,
                           bar.width, bar.height);
  pass.gl.BindVertexArray(pass.emptyLayout);
  pass.gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, 1);
  ++pass.stats.drawCalls;
}

void drawStrokes(const PassContext& pass, const OverlayLines& strokes) {
  const ShaderProgram& program = pass.programs.overlay(true);
  pass.gl.Disable(GL_DEPTH_TEST);
  setCulling(pass.gl, false);
  pass.gl.UseProgram(program.name());
  pass.gl.ProgramUniform1f(program.name(), program.location(DrawUniform::Opacity), 1.0f);
  pass.gl.BindVertexArray(pass.emptyLayout);
  pass.gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kLines, strokes.buffer());
  pass.gl.DrawArraysInstanced(GL_TRIANGLES, 0, 6 * strokes.count(), 1);
  ++pass.stats.drawCalls;
}

}  // namespace limber::render
