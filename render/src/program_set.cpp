// SPDX-License-Identifier: Zlib
#include "program_set.h"

namespace limber::render {
namespace {

std::size_t indexOf(const SurfaceVariant& variant) {
  auto index = static_cast<std::size_t>(variant.source);
  for (const bool bit : {variant.smooth, variant.twoSided, variant.grid, variant.shadows, variant.textured}) {
    index = 2 * index + (bit ? 1 : 0);
  }
  return index;
}

const char* nameOf(VertexSource source) {
  switch (source) {
    case VertexSource::Welded:
      return "WELDED";
    case VertexSource::Tube:
      return "TUBE";
    case VertexSource::Unshared:
      return "UNSHARED";
    case VertexSource::Mesh:
      break;
  }
  return "MESH";
}

std::vector<std::string_view> surfaceVertexFiles() {
  return {"frame.glsl", "points.glsl", "normals.glsl", "tube.glsl", "surface.vert"};
}

}  // namespace

const ShaderProgram& ProgramSet::surface(const SurfaceVariant& variant) {
  ShaderProgram& program = surfaces_[indexOf(variant)];
  if (program.name() == 0) {
    std::vector<std::string> defines{"NORMALS_ACCESS readonly", "SHADOW_TAPS " + std::to_string(shadowTaps_),
                                     nameOf(variant.source)};
    const auto define = [&defines](bool wanted, const char* name) {
      if (wanted) {
        defines.emplace_back(name);
      }
    };
    define(variant.smooth, "SMOOTH");
    define(variant.smooth || variant.source == VertexSource::Unshared, "VERTEX_NORMAL");
    define(variant.twoSided, "TWO_SIDED");
    define(variant.grid, "GRID");
    define(variant.shadows, "SHADOWS");
    define(variant.textured, "TEXTURED");
    program = buildProgram(gl_,
                           {{GL_VERTEX_SHADER, surfaceVertexFiles()},
                            {GL_FRAGMENT_SHADER, {"frame.glsl", "background.glsl", "surface.frag"}}},
                           defines);
  }
  return program;
}

const ShaderProgram& ProgramSet::depth(VertexSource source) {
  ShaderProgram& program = depths_[static_cast<std::size_t>(source)];
  if (program.name() == 0) {
    program =
        buildProgram(gl_, {{GL_VERTEX_SHADER, surfaceVertexFiles()}, {GL_FRAGMENT_SHADER, {"depth.frag"}}},
                     {"NORMALS_ACCESS readonly", "DEPTH_ONLY", nameOf(source)});
  }
  return program;
}

const ShaderProgram& ProgramSet::normals(bool tube) {
  ShaderProgram& program = normals_[tube ? 1 : 0];
  if (program.name() == 0) {
    const char* main = tube ? "tube_frames.comp" : "mesh_normals.comp";
    program = buildProgram(
        gl_, {{GL_COMPUTE_SHADER, {"frame.glsl", "points.glsl", "normals.glsl", "tube.glsl", main}}},
        {"NORMALS_ACCESS writeonly"});
  }
  return program;
}

const ShaderProgram& ProgramSet::skin(bool dense) {
  ShaderProgram& program = skins_[dense ? 1 : 0];
  if (program.name() == 0) {
    program = buildProgram(gl_, {{GL_COMPUTE_SHADER, {"frame.glsl", "points.glsl", "skin.comp"}}},
                           {dense ? "DENSE" : "SPARSE"});
  }
  return program;
}

const ShaderProgram& ProgramSet::lines() {
  if (lines_.name() == 0) {
    lines_ = buildProgram(gl_,
                          {{GL_VERTEX_SHADER, {"frame.glsl", "points.glsl", "wide_line.glsl", "lines.vert"}},
                           {GL_FRAGMENT_SHADER, {"oklab.glsl", "strain_colour.glsl", "lines.frag"}}},
                          {});
  }
  return lines_;
}

const ShaderProgram& ProgramSet::overlay(bool onScreen) {
  ShaderProgram& program = overlays_[onScreen ? 1 : 0];
  if (program.name() == 0) {
    program = buildProgram(gl_,
                           {{GL_VERTEX_SHADER, {"frame.glsl", "wide_line.glsl", "overlay.vert"}},
                            {GL_FRAGMENT_SHADER, {"overlay.frag"}}},
                           {onScreen ? "ON_SCREEN" : "IN_SPACE"});
  }
  return program;
}

const ShaderProgram& ProgramSet::backdrop() {
  if (backdrop_.name() == 0) {
    backdrop_ = buildProgram(gl_,
                             {{GL_VERTEX_SHADER, {"backdrop.vert"}},
                              {GL_FRAGMENT_SHADER, {"frame.glsl", "background.glsl", "backdrop.frag"}}},
                             {});
  }
  return backdrop_;
}

const ShaderProgram& ProgramSet::legend(ColourMap map) {
  ShaderProgram& program = legends_[map == ColourMap::Strain ? 1 : 0];
  if (program.name() == 0) {
    program = buildProgram(
        gl_,
        {{GL_VERTEX_SHADER, {"frame.glsl", "legend.vert"}},
         {GL_FRAGMENT_SHADER, {"oklab.glsl", "strain_colour.glsl", "share_colour.glsl", "legend.frag"}}},
        {map == ColourMap::Strain ? "STRAIN" : "SHARE"});
  }
  return program;
}

}  // namespace limber::render
