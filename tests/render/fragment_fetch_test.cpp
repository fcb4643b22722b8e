// SPDX-License-Identifier: Zlib
// Software rasterisers run vertex stages at once and fragment stages later. So only a shader that reads the
// ring in its fragment stage can show the effect of a missing fence here.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <vector>

#include "limber/render/gl_context.h"
#include "limber/render/gl_debug_messages.h"
#include "limber/render/stream_buffer.h"

namespace limber::render {
namespace {

constexpr int kValues = 64;
constexpr int kFrames = 40;

constexpr const char* kVertexShader = R"(#version 450 core
void main() {
  vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
})";

constexpr const char* kFragmentShader = R"(#version 450 core
layout(std430, binding = 0) readonly buffer Values { float values[]; };
layout(location = 0) out vec4 result;
void main() { result = vec4(values[int(gl_FragCoord.x)] / 255.0, 0.0, 0.0, 1.0); })";

class FragmentFetch : public ::testing::Test {
 protected:
  void SetUp() override {
    program = GlProgram(gl, gl.CreateProgram());
    attach(GL_VERTEX_SHADER, kVertexShader);
    attach(GL_FRAGMENT_SHADER, kFragmentShader);
    gl.LinkProgram(program.name());
    gl.UseProgram(program.name());
    GLuint name = 0;
    gl.CreateTextures(GL_TEXTURE_2D, 1, &name);
    target = GlTexture(gl, name);
    gl.TextureStorage2D(name, 1, GL_RGBA8, kValues, kFrames);
    gl.NamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, name, 0);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer.name());
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.name());
    gl.BindVertexArray(layout.name());
  }
  void TearDown() override {
    EXPECT_NO_THROW(checkGlErrors(gl, "end of the test"));
    EXPECT_EQ(messages.complaints(), 0u) << messages.lastComplaint();
  }

  void attach(GLenum stage, const char* text) {
    const GLuint shader = gl.CreateShader(stage);
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    gl.AttachShader(program.name(), shader);
    gl.DeleteShader(shader);
  }
  static int valueOf(int frame, int i) { return (37 * frame + 11 * i) % 256; }
  static void fill(const StreamFrame& region, int frame) {
    for (int i = 0; i < kValues; ++i) {
      region.data[i] = static_cast<float>(valueOf(frame, i));
    }
  }
  // Draws one row of the picture per frame, so that all frames can be checked after the last.
  void drawRow(const StreamBuffer& buffer, const StreamFrame& region, int row) {
    gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, buffer.name(), region.byteOffset,
                       kValues * static_cast<GLsizeiptr>(sizeof(float)));
    gl.ViewportIndexedf(0, 0.0f, static_cast<GLfloat>(row), kValues, 1.0f);
    gl.DrawArraysInstanced(GL_TRIANGLES, 0, 3, 1);
  }
  int wrongPixels() {
    std::vector<std::uint8_t> rgba(4 * kValues * kFrames);
    gl.ReadPixels(0, 0, kValues, kFrames, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
    int wrong = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
      for (int i = 0; i < kValues; ++i) {
        wrong += rgba[4 * static_cast<std::size_t>(frame * kValues + i)] != valueOf(frame, i) ? 1 : 0;
      }
    }
    return wrong;
  }
  static StreamBufferDesc bufferDesc() {
    StreamBufferDesc desc;
    desc.floatsPerFrame = kValues;
    return desc;
  }

  std::unique_ptr<GlContext> context = createContext();
  Gl gl = loadGl(*context);
  DebugMessages messages{gl};
  GlProgram program;
  GlTexture target;
  GlFramebuffer framebuffer = makeFramebuffer(gl);
  GlVertexArray layout = makeVertexArray(gl);
};

TEST_F(FragmentFetch, TheRingNeverOverwritesWhatIsStillRead) {
  StreamBuffer buffer(gl, bufferDesc());
  for (int frame = 0; frame < kFrames; ++frame) {
    const StreamFrame region = buffer.beginFrame();
    fill(region, frame);
    drawRow(buffer, region, frame);
    buffer.endFrame();
  }
  EXPECT_EQ(wrongPixels(), 0);
  EXPECT_EQ(buffer.counters().waits, static_cast<std::uint64_t>(kFrames) - 3);
}

TEST_F(FragmentFetch, BypassingTheFencesShowsAsWrongPixels) {
  StreamBuffer buffer(gl, bufferDesc());
  for (int frame = 0; frame < kFrames; ++frame) {
    const StreamFrame region = buffer.beginFrame();
    fill(region, frame);
    drawRow(buffer, region, frame);
    fill(region, frame + 1);
    buffer.endFrame();
  }
  EXPECT_GT(wrongPixels(), 0) << "this driver cannot show the hazard, so the test above proves nothing";
}

}  // namespace
}  // namespace limber::render
