// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

#include "limber/render/gl_objects.h"
#include "limber/render/shape_desc.h"

namespace limber::render {

/// The shared data of one shape on the GPU. Nothing in it changes after construction.
struct GpuShape {
  std::string name;
  std::uint32_t pointCount = 0;
  bool tube = false;
  bool smooth = false;  ///< Always for tubes, if only because their frames are computed the same way.
  bool twoSided = false;
  bool castsShadow = true;
  bool grid = false;
  float radius = 0.0f;  ///< Of the tube or of the grid.

  GLsizei indexCount = 0;
  GLsizei lineCount = 0;
  GlBuffer vertices;
  GlBuffer indices;
  GlBuffer lines;             ///< Two points and one over the rest length (0: none), 12 bytes each.
  GlBuffer adjacencyOffsets;  ///< Smooth meshes only, as are the corners.
  GlBuffer adjacencyCorners;
  GlVertexArray layout;

  std::size_t bytes() const;
  /// Three floats per point are computed for it before anything is drawn.
  bool needsNormals() const { return smooth && (tube || indexCount > 0); }
};

/// Throws std::runtime_error with the shape's name if the description is not valid.
GpuShape makeGpuShape(const Gl& gl, const ShapeDesc& desc);

}  // namespace limber::render
