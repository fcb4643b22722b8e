// SPDX-License-Identifier: Zlib
#include "gl_state.h"

namespace limber::render {
namespace {

constexpr std::array<GLenum, GlState::kCaps> kCapNames{GL_COLOR_LOGIC_OP,
                                                       GL_CULL_FACE,
                                                       GL_DEPTH_CLAMP,
                                                       GL_DEPTH_TEST,
                                                       GL_FRAMEBUFFER_SRGB,
                                                       GL_MULTISAMPLE,
                                                       GL_POLYGON_OFFSET_FILL,
                                                       GL_PRIMITIVE_RESTART,
                                                       GL_PRIMITIVE_RESTART_FIXED_INDEX,
                                                       GL_RASTERIZER_DISCARD,
                                                       GL_SAMPLE_ALPHA_TO_COVERAGE,
                                                       GL_SAMPLE_ALPHA_TO_ONE,
                                                       GL_SAMPLE_COVERAGE,
                                                       GL_SAMPLE_MASK,
                                                       GL_SAMPLE_SHADING,
                                                       GL_STENCIL_TEST,
                                                       GL_LINE_SMOOTH,
                                                       GL_POLYGON_SMOOTH,
                                                       GL_CLIP_DISTANCE0,
                                                       GL_CLIP_DISTANCE1,
                                                       GL_CLIP_DISTANCE2,
                                                       GL_CLIP_DISTANCE3,
                                                       GL_CLIP_DISTANCE4,
                                                       GL_CLIP_DISTANCE5,
                                                       GL_CLIP_DISTANCE6,
                                                       GL_CLIP_DISTANCE7};

// In the order of `Value`.
constexpr std::array<GLenum, GlState::kValues> kValueNames{GL_CURRENT_PROGRAM,
                                                           GL_VERTEX_ARRAY_BINDING,
                                                           GL_DRAW_FRAMEBUFFER_BINDING,
                                                           GL_READ_FRAMEBUFFER_BINDING,
                                                           GL_DEPTH_FUNC,
                                                           GL_DEPTH_WRITEMASK,
                                                           GL_FRONT_FACE,
                                                           GL_CULL_FACE_MODE,
                                                           GL_BLEND_SRC_RGB,
                                                           GL_BLEND_DST_RGB,
                                                           GL_BLEND_SRC_ALPHA,
                                                           GL_BLEND_DST_ALPHA,
                                                           GL_BLEND_EQUATION_RGB,
                                                           GL_BLEND_EQUATION_ALPHA,
                                                           GL_CLIP_ORIGIN,
                                                           GL_CLIP_DEPTH_MODE,
                                                           GL_PROVOKING_VERTEX,
                                                           GL_PIXEL_PACK_BUFFER_BINDING,
                                                           GL_PIXEL_UNPACK_BUFFER_BINDING,
                                                           GL_PACK_ALIGNMENT,
                                                           GL_PACK_ROW_LENGTH,
                                                           GL_PACK_SKIP_ROWS,
                                                           GL_PACK_SKIP_PIXELS,
                                                           GL_PACK_SWAP_BYTES,
                                                           GL_UNPACK_ALIGNMENT,
                                                           GL_UNPACK_ROW_LENGTH,
                                                           GL_UNPACK_SKIP_ROWS,
                                                           GL_UNPACK_SKIP_PIXELS,
                                                           GL_UNPACK_IMAGE_HEIGHT,
                                                           GL_UNPACK_SKIP_IMAGES,
                                                           GL_UNPACK_SWAP_BYTES,
                                                           GL_UNIFORM_BUFFER_BINDING,
                                                           GL_SHADER_STORAGE_BUFFER_BINDING};

enum Value : std::size_t {
  kProgram,
  kVertexArray,
  kDrawFramebuffer,
  kReadFramebuffer,
  kDepthFunc,
  kDepthMask,
  kFrontFace,
  kCullMode,
  kBlendSrcRgb,
  kBlendDstRgb,
  kBlendSrcAlpha,
  kBlendDstAlpha,
  kBlendEquationRgb,
  kBlendEquationAlpha,
  kClipOrigin,
  kClipDepth,
  kProvokingVertex,
  kPackBuffer,
  kUnpackBuffer,
  kFirstPixelStore,
  kUniformBuffer = 31,
  kStorageBuffer = 32
};

void setFirst(const Gl& gl, GLenum cap, GLboolean on) {
  on != GL_FALSE ? gl.Enablei(cap, 0) : gl.Disablei(cap, 0);
}

GLenum toEnum(GLint value) { return static_cast<GLenum>(value); }
GLuint toName(GLint value) { return static_cast<GLuint>(value); }

struct RangeNames {
  GLenum target, buffer, start, size;
};
constexpr RangeNames kUniformRange{GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START,
                                   GL_UNIFORM_BUFFER_SIZE};
constexpr RangeNames kStorageRange{GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING,
                                   GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE};

GlState::BufferRange readRange(const Gl& gl, const RangeNames& names, GLuint index) {
  GlState::BufferRange range;
  gl.GetIntegeri_v(names.buffer, index, &range.buffer);
  gl.GetInteger64i_v(names.start, index, &range.start);
  gl.GetInteger64i_v(names.size, index, &range.size);
  return range;
}

// A size of 0 means that the whole buffer is bound, or none.
void writeRange(const Gl& gl, const RangeNames& names, GLuint index, const GlState::BufferRange& range) {
  if (range.size == 0) {
    gl.BindBufferBase(names.target, index, toName(range.buffer));
  } else {
    gl.BindBufferRange(names.target, index, toName(range.buffer), static_cast<GLintptr>(range.start),
                       static_cast<GLsizeiptr>(range.size));
  }
}

// Uses the active unit: glBindTextureUnit() with 0 would unbind the textures of all targets.
template <typename Action>
void forEachUnit(const Gl& gl, Action action) {
  GLint active = 0;
  gl.GetIntegerv(GL_ACTIVE_TEXTURE, &active);
  for (GLuint unit = 0; unit < GlState::kTextureUnits; ++unit) {
    gl.ActiveTexture(GL_TEXTURE0 + unit);
    action(unit);
  }
  gl.ActiveTexture(toEnum(active));
}

void writeBindings(const Gl& gl, const GlState& state) {
  writeRange(gl, kUniformRange, 0, state.uniforms);
  for (GLuint i = 0; i < state.storage.size(); ++i) {
    writeRange(gl, kStorageRange, i, state.storage[i]);
  }
  // Setting an indexed binding point changes the generic one, so the generic ones come after.
  gl.BindBuffer(GL_UNIFORM_BUFFER, toName(state.values[kUniformBuffer]));
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, toName(state.values[kStorageBuffer]));
  gl.BindBuffer(GL_PIXEL_PACK_BUFFER, toName(state.values[kPackBuffer]));
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, toName(state.values[kUnpackBuffer]));
  forEachUnit(gl, [&](GLuint unit) {
    gl.BindTexture(GL_TEXTURE_2D, toName(state.textures[unit].flat));
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, toName(state.textures[unit].array));
    gl.BindSampler(unit, toName(state.textures[unit].sampler));
  });
}

void writeFixedFunctions(const Gl& gl, const GlState& state) {
  const auto& v = state.values;
  gl.DepthFunc(toEnum(v[kDepthFunc]));
  gl.DepthMask(v[kDepthMask] != 0 ? GL_TRUE : GL_FALSE);
  gl.FrontFace(toEnum(v[kFrontFace]));
  gl.CullFace(toEnum(v[kCullMode]));
  gl.BlendFuncSeparatei(0, toEnum(v[kBlendSrcRgb]), toEnum(v[kBlendDstRgb]), toEnum(v[kBlendSrcAlpha]),
                        toEnum(v[kBlendDstAlpha]));
  gl.BlendEquationSeparatei(0, toEnum(v[kBlendEquationRgb]), toEnum(v[kBlendEquationAlpha]));
  gl.ClipControl(toEnum(v[kClipOrigin]), toEnum(v[kClipDepth]));
  gl.ProvokingVertex(toEnum(v[kProvokingVertex]));
  for (std::size_t i = kFirstPixelStore; i < kUniformBuffer; ++i) {
    gl.PixelStorei(kValueNames[i], v[i]);
  }
  const auto& mask = state.colourMask;
  gl.ColorMaski(0, mask[0] != 0, mask[1] != 0, mask[2] != 0, mask[3] != 0);
  gl.PolygonMode(GL_FRONT_AND_BACK, toEnum(state.polygonMode[0]));
  gl.DepthRangeIndexed(0, GLdouble{state.depthRange[0]}, GLdouble{state.depthRange[1]});
  gl.ViewportIndexedfv(0, state.viewport.data());
  setFirst(gl, GL_BLEND, state.blend);
  setFirst(gl, GL_SCISSOR_TEST, state.scissor);
}

}  // namespace

GlState readState(const Gl& gl) {
  GlState state;
  GLint active = 0, paused = 0;
  gl.GetIntegerv(GL_TRANSFORM_FEEDBACK_ACTIVE, &active);
  gl.GetIntegerv(GL_TRANSFORM_FEEDBACK_PAUSED, &paused);
  state.feedbackPaused = active != 0 && paused == 0;
  if (state.feedbackPaused) {
    gl.PauseTransformFeedback();
  }
  for (std::size_t i = 0; i < kCapNames.size(); ++i) {
    state.caps[i] = gl.IsEnabled(kCapNames[i]);
  }
  for (std::size_t i = 0; i < kValueNames.size(); ++i) {
    gl.GetIntegerv(kValueNames[i], &state.values[i]);
  }
  gl.GetFloati_v(GL_VIEWPORT, 0, state.viewport.data());
  state.blend = gl.IsEnabledi(GL_BLEND, 0);
  state.scissor = gl.IsEnabledi(GL_SCISSOR_TEST, 0);
  gl.GetIntegerv(GL_COLOR_WRITEMASK, state.colourMask.data());
  gl.GetIntegerv(GL_POLYGON_MODE, state.polygonMode.data());
  gl.GetFloatv(GL_DEPTH_RANGE, state.depthRange.data());
  state.uniforms = readRange(gl, kUniformRange, 0);
  for (GLuint i = 0; i < state.storage.size(); ++i) {
    state.storage[i] = readRange(gl, kStorageRange, i);
  }
  forEachUnit(gl, [&](GLuint unit) {
    gl.GetIntegerv(GL_TEXTURE_BINDING_2D, &state.textures[unit].flat);
    gl.GetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &state.textures[unit].array);
    gl.GetIntegerv(GL_SAMPLER_BINDING, &state.textures[unit].sampler);
  });
  return state;
}

void writeState(const Gl& gl, const GlState& state) {
  for (std::size_t i = 0; i < kCapNames.size(); ++i) {
    setCap(gl, kCapNames[i], state.caps[i] != GL_FALSE);
  }
  gl.UseProgram(toName(state.values[kProgram]));
  gl.BindVertexArray(toName(state.values[kVertexArray]));
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, toName(state.values[kDrawFramebuffer]));
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, toName(state.values[kReadFramebuffer]));
  writeFixedFunctions(gl, state);
  writeBindings(gl, state);
  if (state.feedbackPaused) {
    gl.ResumeTransformFeedback();
  }
}

void setRendererState(const Gl& gl) {
  GlState state;
  for (std::size_t i = 0; i < kCapNames.size(); ++i) {
    state.caps[i] = kCapNames[i] == GL_FRAMEBUFFER_SRGB || kCapNames[i] == GL_MULTISAMPLE;
  }
  auto& v = state.values;
  v[kDepthFunc] = GL_LESS;
  v[kDepthMask] = GL_TRUE;
  v[kFrontFace] = GL_CCW;
  v[kCullMode] = GL_BACK;
  v[kBlendSrcRgb] = v[kBlendSrcAlpha] = GL_ONE;
  v[kBlendEquationRgb] = v[kBlendEquationAlpha] = GL_FUNC_ADD;
  // Rows are then ordered from the top down, as in PNG and video.
  v[kClipOrigin] = GL_UPPER_LEFT;
  v[kClipDepth] = GL_ZERO_TO_ONE;
  v[kProvokingVertex] = GL_LAST_VERTEX_CONVENTION;
  for (std::size_t i = kFirstPixelStore; i < kUniformBuffer; ++i) {
    const bool alignment = kValueNames[i] == GL_PACK_ALIGNMENT || kValueNames[i] == GL_UNPACK_ALIGNMENT;
    v[i] = alignment ? 1 : 0;
  }
  state.colourMask = {1, 1, 1, 1};
  state.polygonMode = {GL_FILL, GL_FILL};
  state.depthRange = {0.0f, 1.0f};
  writeState(gl, state);
}

GlStateGuard::GlStateGuard(const Gl& gl, bool shared) : gl_(gl) {
  if (shared) {
    callerState_ = std::make_unique<GlState>(readState(gl));
    setRendererState(gl);
  }
}

GlStateGuard::~GlStateGuard() {
  if (callerState_ != nullptr) {
    writeState(gl_, *callerState_);
  }
}

}  // namespace limber::render
