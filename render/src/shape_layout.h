// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/shape_desc.h"

#include <cstdint>
#include <vector>

namespace limber::render {

/// A vertex as the shaders read it. The last three members are for tubes only.
struct SurfaceVertex {
  std::uint32_t point = 0;
  std::uint32_t normal = 0;  ///< Of meshes.
  float u = 0.0f, v = 0.0f;
  float fraction = 0.0f;  ///< Of the distance from `point` to the next point.
  float out = 0.0f;       ///< Profile: distance from the centre line in radii,
  float along = 0.0f;     ///< and along it in radii (round ends).
};

struct SurfaceMesh {
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint32_t> indices;
};

/// Returns the surface of a tube through `pointCount` points (at least 2): rings of `segments` quads, several
/// rings between two points, and half spheres as ends. u runs around and v along the tube, both 0 to 1.
SurfaceMesh makeTubeMesh(std::uint32_t pointCount, std::uint32_t segments);

/// Returns true if triangles (3 points each) have no boundary: each edge is passed as often in one direction
/// as in the other. Then every ray that comes from outside and hits them passes through a front face.
bool isClosed(const std::vector<std::uint32_t>& triangles);

/// Returns true if a full matrix takes less memory: 4 bytes per place and point, against 8 per weight.
bool isDense(const Skin& skin, std::uint32_t pointCount);

/// Returns #points x #places floats: the weight of point k on place p is at k * #places + p.
std::vector<float> denseWeights(const Skin& skin, std::uint32_t pointCount);

/// Returns 2 x #weights integers: point and the weight's bits, in the order of the skin.
std::vector<std::uint32_t> sparseWeights(const Skin& skin);

/// For every normal its triangles, each as its three points (with a skin: places).
struct NormalAdjacency {
  std::vector<std::uint32_t> offsets;  ///< #normals + 1, into corners counted in threes.
  std::vector<std::uint32_t> corners;
};

/// `desc` must be valid. Vertices with the same normal share its list, so seams are smooth.
NormalAdjacency makeNormalAdjacency(const ShapeDesc& desc);

/// Returns the point (with a skin: place) of a vertex.
inline std::uint32_t pointOf(const ShapeDesc& desc, std::uint32_t vertex) {
  return desc.vertexToPoint.empty() ? vertex : desc.vertexToPoint[vertex];
}

/// Returns the normal of a vertex, which is its point unless the description says otherwise.
std::uint32_t normalOf(const ShapeDesc& desc, std::uint32_t vertex);

}  // namespace limber::render
