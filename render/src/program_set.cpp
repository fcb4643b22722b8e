// SPDX-License-Identifier: Zlib
#include "program_set.h"

#include <stdexcept>

namespace limber::render {
namespace {

constexpr std::array<const char*, static_cast<std::size_t>(DrawUniform::Count)> kUniformNames{
    "firstPoint",        "firstInstance", "pointCount",  "firstNormal", "normalCount", "firstPlace",
    "skinnedPointCount", "invocations",   "shapeRadius", "opacity",     "rectangle"};

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
  for (const ShaderText& file : source.files) {
    list += (list.empty() ? "" : " + ") + std::string(file.name);
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
    // The compiler then reports "file:line", with files counted from 1.
    text += "#line 1 " + std::to_string(i + 1) + "\n" + source.files[i].text;
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

std::size_t indexOf(const SurfaceVariant& variant) {
  auto index = static_cast<std::size_t>(variant.source);
  for (const bool bit : {variant.smooth, variant.twoSided, variant.grid, variant.shadows, variant.textured}) {
    index = 2 * index + (bit ? 1 : 0);
  }
  return index;
}

namespace {

const char* nameOf(VertexSource source) {
  switch (source) {
    case VertexSource::Welded:
      return "WELDED";
    case VertexSource::Tube:
      return "TUBE";
    case VertexSource::Mesh:
      break;
  }
  return "MESH";
}

std::vector<ShaderText> surfaceVertexFiles() {
  return {"frame.glsl", "points.glsl", "tube.glsl", "surface.vert"};
}

// Builds a program whose one triangle covers the picture.
ShaderProgram buildCovering(const Gl& gl, const std::vector<ShaderText>& fragmentFiles,
                            const std::vector<std::string>& defines) {
  return buildProgram(gl, {{GL_VERTEX_SHADER, {"backdrop.vert"}}, {GL_FRAGMENT_SHADER, fragmentFiles}},
                      defines);
}

// Returns the program, built by `build` on first use.
template <typename Build>
const ShaderProgram& built(ShaderProgram& program, const Build& build) {
  if (program.name() == 0) {
    program = build();
  }
  return program;
}

}  // namespace

std::vector<std::string> definesOf(const SurfaceVariant& variant, int shadowTaps) {
  std::vector<std::string> defines{"NORMALS_ACCESS readonly", "SHADOW_TAPS " + std::to_string(shadowTaps),
                                   nameOf(variant.source)};
  const auto define = [&defines](bool wanted, const char* name) {
    if (wanted) {
      defines.emplace_back(name);
    }
  };
  define(variant.smooth, "SMOOTH");
  define(variant.twoSided, "TWO_SIDED");
  define(variant.grid, "GRID");
  define(variant.shadows, "SHADOWS");
  define(variant.textured, "TEXTURED");
  return defines;
}

const ShaderProgram& ProgramSet::surface(const SurfaceVariant& variant) {
  return built(surfaces_[indexOf(variant)], [&] {
    std::vector<std::string> defines = definesOf(variant, shadowTaps_);
    std::vector<ShaderText> files{"frame.glsl", "background.glsl", "shading_normal.glsl",
                                  "surface_colour.glsl"};
    if (gallery_) {
      defines.insert(defines.end(), {"GALLERY", "BLOCKER_TAPS 16", "PENUMBRA_TAPS 24"});
      files.insert(files.end(), {"studio.glsl", "gallery.frag"});
    } else {
      files.emplace_back("surface.frag");
    }
    return buildProgram(gl_, {{GL_VERTEX_SHADER, surfaceVertexFiles()}, {GL_FRAGMENT_SHADER, files}},
                        defines);
  });
}

const ShaderProgram& ProgramSet::depth(VertexSource source, bool fromEye) {
  return built(depths_[static_cast<std::size_t>(source) + (fromEye ? kVertexSources : 0)], [&] {
    return buildProgram(
        gl_, {{GL_VERTEX_SHADER, surfaceVertexFiles()}, {GL_FRAGMENT_SHADER, {"depth.frag"}}},
        {"NORMALS_ACCESS readonly", "DEPTH_ONLY", nameOf(source), fromEye ? "FROM_EYE" : "FROM_LIGHT"});
  });
}

const ShaderProgram& ProgramSet::normals(bool tube) {
  return built(normals_[tube ? 1 : 0], [&] {
    const char* main = tube ? "tube_frames.comp" : "mesh_normals.comp";
    return buildProgram(gl_, {{GL_COMPUTE_SHADER, {"frame.glsl", "points.glsl", "tube.glsl", main}}},
                        {"NORMALS_ACCESS writeonly"});
  });
}

const ShaderProgram& ProgramSet::skin(bool dense) {
  return built(skins_[dense ? 1 : 0], [&] {
    return buildProgram(gl_, {{GL_COMPUTE_SHADER, {"frame.glsl", "points.glsl", "skin.comp"}}},
                        {dense ? "DENSE" : "SPARSE"});
  });
}

const ShaderProgram& ProgramSet::lines() {
  return built(lines_, [&] {
    return buildProgram(gl_,
                        {{GL_VERTEX_SHADER, {"frame.glsl", "points.glsl", "wide_line.glsl", "lines.vert"}},
                         {GL_FRAGMENT_SHADER, {"colours.glsl", "lines.frag"}}},
                        {});
  });
}

const ShaderProgram& ProgramSet::overlay(bool onScreen) {
  return built(overlays_[onScreen ? 1 : 0], [&] {
    return buildProgram(gl_,
                        {{GL_VERTEX_SHADER, {"frame.glsl", "wide_line.glsl", "overlay.vert"}},
                         {GL_FRAGMENT_SHADER, {"overlay.frag"}}},
                        {onScreen ? "ON_SCREEN" : "IN_SPACE"});
  });
}

const ShaderProgram& ProgramSet::backdrop() {
  return built(backdrop_, [&] {
    return gallery_ ? buildCovering(gl_, {"frame.glsl", "background.glsl", "studio.glsl", "wall.frag"}, {})
                    : buildCovering(gl_, {"frame.glsl", "background.glsl", "backdrop.frag"}, {});
  });
}

const ShaderProgram& ProgramSet::occlusion() {
  return built(occlusion_, [&] {
    return buildCovering(gl_, {"frame.glsl", "studio.glsl", "occlusion.frag"},
                         {"OCCLUSION_SLICES 3", "OCCLUSION_STEPS 8"});
  });
}

const ShaderProgram& ProgramSet::occlusionBlur() {
  return built(occlusionBlur_, [&] { return buildCovering(gl_, {"frame.glsl", "occlusion_blur.frag"}, {}); });
}

const ShaderProgram& ProgramSet::legend(ColourMap map) {
  const bool strain = map == ColourMap::Strain;
  return built(legends_[strain ? 1 : 0], [&] {
    return buildProgram(gl_,
                        {{GL_VERTEX_SHADER, {"frame.glsl", "legend.vert"}},
                         {GL_FRAGMENT_SHADER, {"colours.glsl", "legend.frag"}}},
                        {strain ? "STRAIN" : "SHARE"});
  });
}

}  // namespace limber::render
