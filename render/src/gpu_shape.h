// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

#include "limber/render/gl_objects.h"
#include "limber/render/shape_desc.h"

namespace limber::render {

/// The weights of a skin, in one of two layouts. Dense: weight of (place, point) at
/// point * placeCount + place, so that neighbouring invocations read neighbouring floats. Sparse: by
/// place, a point and its weight each.
struct GpuSkin {
  bool dense = false;
  GlBuffer first;  ///< Sparse only: placeCount + 1.
  GlBuffer weights;

  std::size_t bytes() const { return first.bytes() + weights.bytes(); }
};

/// The shared data of one shape on the GPU. Nothing in it changes after construction.
struct GpuShape {
  std::string name;
  std::uint32_t pointCount = 0;
  std::uint32_t placeCount = 0;  ///< Equals pointCount without a skin.
  bool tube = false;
  bool smooth = false;  ///< Always for tubes, if only because their frames are computed the same way.
  bool twoSided = false;
  bool castsShadow = true;
  bool grid = false;
  float radius = 0.0f;  ///< Of the tube or of the grid.

  GLsizei indexCount = 0;
  GLsizei lineCount = 0;
  GpuSkin skin;
  GlBuffer vertices;
  GlBuffer indices;
  GlBuffer lines;             ///< Two points and one over the rest length (0: none), 12 bytes each.
  GlBuffer adjacencyOffsets;  ///< Smooth meshes only, as are the corners.
  GlBuffer adjacencyCorners;
  GlVertexArray layout;
  GlBuffer weldedIndices;      ///< Points instead of vertices; empty where they are the same, and of tubes.
  GlVertexArray weldedLayout;  ///< For them; no attributes. Of meshes only.

  std::size_t bytes() const;
  bool skinned() const { return skin.weights.name() != 0; }
  /// Three floats per place are computed for it before anything is drawn.
  bool needsNormals() const { return smooth && (tube || indexCount > 0); }
};

/// Throws std::runtime_error with the shape's name if the description is not valid.
GpuShape makeGpuShape(const Gl& gl, const ShapeDesc& desc);

}  // namespace limber::render
