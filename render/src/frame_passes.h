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
};

struct PictureSize {
  int width = 0;
  int height = 0;
  int shadowMapSize = 0;
};

FrameUniforms makeFrameUniforms(const Camera& camera, const Light& light, const DrawOptions& options,
                                const PictureSize& size);

/// Where the points of some instances lie: three floats each, packed, in a range of a buffer.
struct PointRange {
  GLuint buffer = 0;
  GLintptr byteOffset = 0;
  GLsizeiptr bytes = 0;
  std::uint32_t first = 0;  ///< Of the first instance, counted in points of the range.
};

/// One draw call per pass: some instances of a shape whose points lie one after the other.
struct DrawItem {
  const GpuShape* shape = nullptr;
  std::uint32_t firstInstance = 0;
  std::uint32_t instanceCount = 0;
  std::uint32_t firstNormal = 0;
  PointRange points;  ///< Streamed.
  PointRange places;  ///< What vertices ride on: of a skin, or the points.
  bool textured = false;
  GLuint layout = 0;  ///< Vertices made on the CPU; 0: the shape's layout, and points from the buffer above.
};

/// What all passes of a frame share.
struct PassContext {
  const Gl& gl;
  ProgramSet& programs;
  FrameStats& stats;
  const std::vector<DrawItem>& items;
  GLuint emptyLayout;  ///< For draws that make their vertices from the vertex number.
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

/// Places of skinned meshes, then normals of smooth meshes and frames of tubes, for all passes that
/// follow. First in the frame: a dispatch between draws would make a tiled renderer finish those first.
void computePlaces(const PassContext& pass);
void computeNormals(const PassContext& pass);
void castShadows(const PassContext& pass, const ShadowMap& map);
/// In wireframe mode only the shapes that have no lines.
void drawSurfaces(const PassContext& pass, DrawMode mode, bool shadows);
void drawLines(const PassContext& pass);
/// Fills what the surfaces left open.
void drawBackdrop(const PassContext& pass);
/// Last of what has depth: it compares with the others'.
void drawOverlay(const PassContext& pass, const OverlayLines& lines, float hiddenOpacity);
void drawLegend(const PassContext& pass, ColourMap map, const BarPlace& bar);
/// Strokes in pixels, on top of everything.
void drawStrokes(const PassContext& pass, const OverlayLines& strokes);

}  // namespace limber::render
