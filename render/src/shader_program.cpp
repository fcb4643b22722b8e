// SPDX-License-Identifier: Zlib
#include "shader_program.h"

#include <stdexcept>

#include "shader_sources.h"

namespace limber::render {
namespace {

constexpr std::array<const char*, static_cast<std::size_t>(DrawUniform::Count)> kUniformNames{
    "firstPoint", "firstInstance", "pointCount",  "firstNormal", "firstPlace",
    "placeCount", "invocations",   "shapeRadius", "opacity",     "place"};

class Shader {
 public:
  Shader(const Gl& gl, GLenum stage) : gl_(gl), name_(gl.CreateShader(stage)) {}
  ~Shader() { gl_.DeleteShader(name_); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;
  GLuint name() const { return name_; }

 private:
  const Gl& gl_;
  GLuint name_;
};

std::string fileList(const StageSource& source) {
  std::string list;
  for (const std::string_view file : source.files) {
    list += (list.empty() ? "" : " + ") + std::string(file);
  }
  return list;
}

void compile(const Gl& gl, GLuint shader, const StageSource& source,
             const std::vector<std::string>& defines) {
  std::string text = "#version 450 core\n";
  for (const std::string& define : defines) {
    text += "#define " + define + "\n";
  }
  for (std::size_t i = 0; i < source.files.size(); ++i) {
    // The compiler then says "file:line", counting files from 1.
    text += "#line 1 " + std::to_string(i + 1) + "\n" + shaderSource(source.files[i]);
  }
  const char* start = text.c_str();
  gl.ShaderSource(shader, 1, &start, nullptr);
  gl.CompileShader(shader);
  GLint ok = GL_FALSE;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok != GL_TRUE) {
    std::array<char, 4096> log{};
    gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw std::runtime_error("cannot compile " + fileList(source) + ": " + log.data());
  }
}

void link(const Gl& gl, GLuint program, const std::vector<StageSource>& stages) {
  gl.LinkProgram(program);
  GLint ok = GL_FALSE;
  gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
  if (ok != GL_TRUE) {
    std::array<char, 4096> log{};
    gl.GetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw std::runtime_error("cannot link " + fileList(stages.back()) + ": " + log.data());
  }
}

}  // namespace

ShaderProgram buildProgram(const Gl& gl, const std::vector<StageSource>& stages,
                           const std::vector<std::string>& defines) {
  ShaderProgram built;
  built.program = GlProgram(gl, gl.CreateProgram());
  for (const StageSource& source : stages) {
    const Shader shader(gl, source.stage);
    compile(gl, shader.name(), source, defines);
    gl.AttachShader(built.name(), shader.name());
  }
  link(gl, built.name(), stages);
  for (std::size_t i = 0; i < kUniformNames.size(); ++i) {
    built.locations[i] = gl.GetUniformLocation(built.name(), kUniformNames[i]);
  }
  return built;
}

}  // namespace limber::render
