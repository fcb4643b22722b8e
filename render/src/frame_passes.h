// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <vector>

#include "gpu_shape.h"
#include "limber/render/renderer.h"
#include "program_set.h"
#include "shadow_map.h"

namespace limber::render {

/// One draw call per pass: some instances of a shape whose points lie one after the other.
struct DrawItem {
  const GpuShape* shape = nullptr;
  std::uint32_t firstInstance = 0;
  std::uint32_t instanceCount = 0;
  std::uint32_t firstPoint = 0;  ///< In the bound range of the buffer.
  std::uint32_t firstNormal = 0;
  GLuint positions = 0;  ///< Buffer; below, the range of it to bind.
  GLintptr byteOffset = 0;
  GLsizeiptr bytes = 0;
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
  kCorners = 5
};

/// Normals of smooth meshes and frames of tubes, for all passes that follow. First in the frame: a
/// dispatch between draws would make a tiled renderer finish those draws first.
void computeNormals(const PassContext& pass);
void castShadows(const PassContext& pass, const ShadowMap& map);
/// In wireframe mode only the shapes that have no lines.
void drawSurfaces(const PassContext& pass, DrawMode mode, bool shadows);
void drawLines(const PassContext& pass);
/// Fills what the surfaces left open.
void drawBackdrop(const PassContext& pass);
void drawLegend(const PassContext& pass);

}  // namespace limber::render
