// SPDX-License-Identifier: Zlib
// The renderer in a context that belongs to another program.
#include "gl_state.h"

#include <array>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <stdexcept>

#include "limber/render/gl_objects.h"
#include "test_scene.h"

namespace limber::render::test {
namespace {

// A program with its own context and framebuffer, which can set unusual OpenGL state.
struct Program {
  std::unique_ptr<GlContext> context = createContext();
  Gl gl = loadGl(*context);
  GlBuffer buffer = makeBuffer(gl, 1024, nullptr);
  GlVertexArray vertexArray = makeVertexArray(gl);
  GlTexture colour;
  GlTexture array;
  GlFramebuffer framebuffer;

  Program() {
    GLuint name = 0;
    gl.CreateTextures(GL_TEXTURE_2D, 1, &name);
    colour = GlTexture(gl, name);
    gl.TextureStorage2D(name, 1, GL_RGBA8, kWidth, kHeight);
    gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
    array = GlTexture(gl, name);
    gl.TextureStorage3D(name, 1, GL_RGBA8, 4, 4, 2);
    framebuffer = makeFramebuffer(gl);
    gl.NamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, colour.name(), 0);
  }

  // Sets all state that could change the renderer's picture.
  void setUnusualState() {
    for (const GLenum cap : std::initializer_list<GLenum>{
             GL_SCISSOR_TEST, GL_STENCIL_TEST, GL_BLEND, GL_CULL_FACE, GL_POLYGON_OFFSET_FILL,
             GL_PRIMITIVE_RESTART, GL_RASTERIZER_DISCARD, GL_COLOR_LOGIC_OP, GL_SAMPLE_COVERAGE,
             GL_SAMPLE_SHADING, GL_SAMPLE_ALPHA_TO_ONE}) {
      gl.Enable(cap);
    }
    gl.Disablei(GL_BLEND, 2);
    gl.ColorMaski(0, GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    gl.ColorMaski(1, GL_TRUE, GL_FALSE, GL_FALSE, GL_TRUE);
    gl.DepthMask(GL_FALSE);
    gl.DepthFunc(GL_GREATER);
    gl.DepthRangeIndexed(0, 0.25, 0.75);
    gl.DepthRangeIndexed(1, 0.125, 0.5);
    gl.FrontFace(GL_CW);
    gl.CullFace(GL_FRONT);
    gl.PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    gl.BlendEquationSeparatei(0, GL_FUNC_REVERSE_SUBTRACT, GL_MAX);
    gl.BlendFuncSeparatei(0, GL_ZERO, GL_ZERO, GL_DST_COLOR, GL_ONE);
    gl.BlendFuncSeparatei(1, GL_ONE, GL_ZERO, GL_ZERO, GL_ONE);
    gl.PixelStorei(GL_PACK_ROW_LENGTH, 7);
    for (const GLenum skipped : std::initializer_list<GLenum>{GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES,
                                                              GL_UNPACK_IMAGE_HEIGHT}) {
      gl.PixelStorei(skipped, 3);
    }
    gl.ViewportIndexedf(0, 3.0f, 5.0f, 7.5f, 11.0f);
    gl.ViewportIndexedf(1, 1.0f, 2.0f, 3.0f, 4.0f);
    gl.BindVertexArray(vertexArray.name());
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer.name());
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.name());
    for (const GLenum target : std::initializer_list<GLenum>{GL_UNIFORM_BUFFER, GL_SHADER_STORAGE_BUFFER}) {
      gl.BindBufferRange(target, 0, buffer.name(), 256, 128);
    }
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, buffer.name());
    gl.BindBuffer(GL_UNIFORM_BUFFER, 0);
    gl.ActiveTexture(GL_TEXTURE1);
    gl.BindTexture(GL_TEXTURE_2D, colour.name());
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, array.name());
    gl.ActiveTexture(GL_TEXTURE5);
  }

  std::unique_ptr<GlContext> adopted() const {
    return adoptContext([this](const char* name) { return context->getProcAddress(name); });
  }
};

// State of further viewports and draw buffers.
struct FurtherState {
  GLboolean blend1 = GL_FALSE, blend2 = GL_FALSE;
  std::array<GLint, 4> mask{};
  GLint source = 0;
  std::array<GLfloat, 4> viewport{};
  std::array<GLfloat, 2> depths{};

  explicit FurtherState(const Gl& gl)
      : blend1(gl.IsEnabledi(GL_BLEND, 1)), blend2(gl.IsEnabledi(GL_BLEND, 2)) {
    gl.GetIntegeri_v(GL_COLOR_WRITEMASK, 1, mask.data());
    gl.GetIntegeri_v(GL_BLEND_SRC_RGB, 1, &source);
    gl.GetFloati_v(GL_VIEWPORT, 1, viewport.data());
    gl.GetFloati_v(GL_DEPTH_RANGE, 1, depths.data());
  }
  bool operator==(const FurtherState& other) const {
    return blend1 == other.blend1 && blend2 == other.blend2 && mask == other.mask && source == other.source &&
           viewport == other.viewport && depths == other.depths;
  }
};

bool equal(const GlState& a, const GlState& b) {
  const auto sameRange = [](const GlState::BufferRange& x, const GlState::BufferRange& y) {
    return x.buffer == y.buffer && x.start == y.start && x.size == y.size;
  };
  bool same = a.caps == b.caps && a.values == b.values && a.viewport == b.viewport && a.blend == b.blend &&
              a.scissor == b.scissor && a.colourMask == b.colourMask && a.polygonMode == b.polygonMode &&
              a.depthRange == b.depthRange && sameRange(a.uniforms, b.uniforms);
  for (std::size_t i = 0; i < a.storage.size(); ++i) {
    same = same && sameRange(a.storage[i], b.storage[i]);
  }
  for (std::size_t i = 0; i < a.textures.size(); ++i) {
    same = same && a.textures[i].flat == b.textures[i].flat && a.textures[i].array == b.textures[i].array;
  }
  return same;
}

Scenery ball() { return makeUvSphere({0.0f, 0.5f, 0.0f}, 0.8f); }

void drawBall(Renderer& renderer, InstanceId id, const Stage& stage) {
  FrameWriter frame = renderer.beginFrame();
  const Scenery scenery = ball();
  std::copy(scenery.points.begin(), scenery.points.end(), frame.points(id));
  Overlay overlay;
  addCross(overlay, {0.0f, 1.5f, 0.0f}, 0.5f, {1.0f, 0.0f, 0.0f});
  renderer.draw(frame, stage.camera, stage.light, {}, overlay);
}

TEST(AdoptedContext, PicturesAreTheSameAndTheProgramsStateStays) {
  Stage stage;
  const InstanceId id = stage.add(ball());
  drawBall(stage.renderer(), id, stage);
  const Image expected = stage.renderer().readPixels();

  Program program;
  const auto context = program.adopted();
  program.setUnusualState();
  const GlState before = readState(program.gl);
  const FurtherState furtherBefore(program.gl);
  Renderer renderer(*context, smallDesc());
  EXPECT_TRUE(equal(readState(program.gl), before)) << "made";
  const std::array<std::uint8_t, 4> white{255, 255, 255, 255};
  renderer.addTexture(1, 1, white.data());
  EXPECT_TRUE(equal(readState(program.gl), before)) << "texture added";
  const InstanceId adoptedId = renderer.addInstance(renderer.addShape(ball().shape));
  drawBall(renderer, adoptedId, stage);
  EXPECT_TRUE(equal(readState(program.gl), before)) << "drawn";
  EXPECT_EQ(renderer.readPixels().rgba, expected.rgba);
  EXPECT_TRUE(equal(readState(program.gl), before)) << "read";
  EXPECT_EQ(renderer.debugMessages(), nullptr);
  renderer.resize(64, 64);
  EXPECT_TRUE(equal(readState(program.gl), before)) << "resized";
  EXPECT_TRUE(FurtherState(program.gl) == furtherBefore);
  EXPECT_THROW(renderer.blitTo(77, 0, 0, 4, 4), std::runtime_error) << "no such framebuffer";
  EXPECT_NO_THROW(checkGlErrors(program.gl, "end"));
}

TEST(AdoptedContext, ThePictureComesUprightIntoTheProgramsFramebuffer) {
  Stage stage;
  Program program;
  const auto context = program.adopted();
  Renderer renderer(*context, smallDesc());
  const InstanceId id = renderer.addInstance(renderer.addShape(ball().shape));
  drawBall(renderer, id, stage);
  const Image picture = renderer.readPixels();
  program.gl.Enable(GL_SCISSOR_TEST);
  renderer.blitTo(program.framebuffer.name(), 0, 0, kWidth, kHeight);
  program.gl.BindFramebuffer(GL_READ_FRAMEBUFFER, program.framebuffer.name());
  Image copied;
  copied.resize(kWidth, kHeight);
  program.gl.ReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, copied.rgba.data());
  for (int y = 0; y < kHeight; ++y) {
    ASSERT_EQ(std::memcmp(copied.pixel(0, y), picture.pixel(0, kHeight - 1 - y), 4 * kWidth), 0)
        << "row " << y;
  }
  EXPECT_NE(renderer.texture(), 0u);
}

TEST(AdoptedContext, WithoutALoaderIsRefused) { EXPECT_THROW(adoptContext({}), std::runtime_error); }

}  // namespace
}  // namespace limber::render::test
