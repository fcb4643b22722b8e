// SPDX-License-Identifier: Zlib
#pragma once

#include "gpu_shape.h"
#include "gpu_textures.h"
#include "limber/render/renderer.h"
#include "mat4.h"
#include "overlay_lines.h"
#include "program_set.h"

#include <array>
#include <cstdint>
#include <vector>

namespace limber::render {

/// The uniform block of frame.glsl, in its memory layout.
struct FrameUniforms {
  using Vec4 = std::array<float, 4>;

  Mat4 viewProjection;
  Mat4 worldToShadow;
  Vec4 eye{};
  Vec4 towardsLight{};
  Vec4 sun{};
  Vec4 sky{};
  Vec4 ground{};
  Vec4 backgroundTop{};
  Vec4 backgroundBottom{};
  Vec4 viewport{};
  Vec4 forward{};
  Vec4 right{};
  Vec4 down{};
  Vec4 shadowVolume{};
  Vec4 stage{};
};

struct PictureSize {
  int width = 0;
  int height = 0;
  int shadowMapSize = 0;
};

/// These throw std::runtime_error with the name of the field.
void requireFinite(const char* field, float value);
void requireFinite(const char* field, Vec3 value);
void requireUsable(const Camera& camera, const Light& light, const DrawOptions& options);

FrameUniforms makeFrameUniforms(const Camera& camera, const Light& light, const DrawOptions& options,
                                const PictureSize& size);

/// A range of a buffer with the points of some instances: three floats each, packed.
struct PointRange {
  GLuint buffer = 0;
  GLintptr byteOffset = 0;
  GLsizeiptr bytes = 0;
  std::uint32_t first = 0;  ///< First point of the first instance in the range.

  /// The same range for an instance whose points come so much later.
  PointRange from(std::uint32_t points) const { return {buffer, byteOffset, bytes, first + points}; }
};

inline PointRange wholeOf(const GlBuffer& buffer) {
  return {buffer.name(), 0, static_cast<GLsizeiptr>(buffer.bytes()), 0};
}

/// One draw call per pass: instances of a shape with contiguous points.
struct DrawItem {
  const GpuShape* shape = nullptr;
  std::uint32_t firstInstance = 0;
  std::uint32_t instanceCount = 0;
  PointRange points;   ///< Streamed.
  PointRange places;   ///< Positions of the vertices: the places of the skin, or the points.
  PointRange normals;  ///< Of the places of smooth meshes, or side vectors of tubes.
  bool textured = false;
};

/// Data that all passes of a frame share.
struct PassContext {
  const Gl& gl;
  ProgramSet& programs;
  FrameStats& stats;
  const std::vector<DrawItem>& items;
  bool gallery;
  GLuint emptyLayout;  ///< For draws that compute their vertices from gl_VertexID.
};

/// Binding points, equal in all shaders.
enum StorageBinding : GLuint {
  kPoints = 0,
  kNormals = 1,
  kInstances = 2,
  kLines = 3,
  kOffsets = 4,
  kCorners = 5,
  kSkinFirst = 4,
  kSkinWeights = 5,
  kPlaces = 6
};

/// These two compute the places of skinned meshes, then the normals of smooth meshes and the side vectors of
/// tubes, for all later passes. They come first in the frame: a dispatch between draws forces a tiled
/// renderer to finish those draws first.
void computePlaces(const PassContext& pass);
void computeNormals(const PassContext& pass);
/// Computes how open each pixel is: depths, then rays, then an average.
void computeOpenness(const PassContext& pass, const OpennessMap& map, DrawMode mode);
void castShadows(const PassContext& pass, const ShadowMap& map);
/// Draws the surfaces; in wireframe mode only of shapes without lines.
void drawSurfaces(const PassContext& pass, DrawMode mode, bool shadows);
void drawLines(const PassContext& pass);
/// Draws the background where there is no surface.
void drawBackdrop(const PassContext& pass);
/// Call it after everything with depth: it compares with that depth.
void drawOverlay(const PassContext& pass, const OverlayLines& lines, float hiddenOpacity);
void drawLegend(const PassContext& pass, ColourMap map, const BarRectangle& bar);
/// Draws strokes in pixels, on top of everything.
void drawStrokes(const PassContext& pass, const OverlayLines& strokes);

}  // namespace limber::render
