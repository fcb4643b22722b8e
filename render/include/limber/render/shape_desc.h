// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber::render {

enum class Shading {
  Flat,   ///< One normal per triangle, from screen-space derivatives.
  Smooth  ///< Area-weighted normals per point, computed in every frame (see ComputeOn).
};

enum class Pattern {
  Plain,
  Grid  ///< A line at every metre of uv, over a checkerboard; fades out at uv length `patternRadius`.
};

/// Places are positions that follow the points: place p is the sum of weights[k] times point points[k], for
/// first[p] <= k < first[p + 1]. The renderer computes them in every frame (see ComputeOn), on a GPU from the
/// points alone, so that a detailed mesh costs no more to stream than the few points that move it. The
/// weights of a place should add up to 1, or it does not follow translations of its body.
struct Skin {
  std::vector<std::uint32_t> first;   ///< #places + 1, rising from 0; empty: no skin.
  std::vector<std::uint32_t> points;  ///< One per weight.
  std::vector<float> weights;

  std::size_t skinnedPointCount() const { return first.empty() ? 0 : first.size() - 1; }
};

/// The data that all instances of a shape share and that never change: topology and appearance. The points
/// move (three floats each, streamed in every frame). A vertex is a point, or with a skin a place, with a
/// texture coordinate, so that seams need no second point.
///
/// A mesh has triangles; a tube (rope) has `tubeRadius` > 0 and no triangles: its points form a polyline, and
/// the GPU makes its surface. Both may have lines. A shape may also have only lines; it is then visible in
/// wireframe mode only.
struct ShapeDesc {
  std::string name;  ///< Only used in error messages.

  std::uint32_t pointCount = 0;  ///< At least 1; a tube needs at least 2.
  Skin skin;                     ///< Empty: vertices lie on the points themselves.
  std::vector<std::uint32_t>
      vertexToPoint;       ///< Point (with a skin: place) of each vertex; empty: vertex i is at point i.
  std::vector<float> uvs;  ///< 2 per vertex, or empty.
  /// Normal of each vertex, for smooth shading: vertices of one normal are shaded as one curved surface. They
  /// are counted from 0. Empty: one normal per point (with a skin: place). See sharpenEdges().
  std::vector<std::uint32_t> vertexToNormal;
  std::vector<std::uint32_t> triangles;  ///< 3 vertex indices each, counter-clockwise outside.
  std::vector<std::uint32_t> lines;      ///< 2 point indices each.
  std::vector<float> lineRestLengths;    ///< Metres, > 0, one per line; empty: not coloured.

  Shading shading = Shading::Flat;
  bool twoSided = false;  ///< Draw and light both sides (cloth).
  /// Leaves out the back faces of a two-sided surface if it is closed. They are visible only if the body is
  /// turned inside out or cut open by the picture's near plane, and are half the work of a software
  /// rasteriser.
  bool hideBackFaces = false;
  bool castsShadow = true;  ///< Turning it off saves much time for a floor, which has nothing below it.

  float tubeRadius = 0.0f;          ///< Metres; above 0 makes this a tube.
  std::uint32_t tubeSegments = 12;  ///< Around the tube; at least 3.

  Pattern pattern = Pattern::Plain;
  float patternRadius = 0.0f;  ///< Metres of uv at which a Grid has faded out.
};

/// Returns the number of places of the skin, or of points without a skin. vertexToPoint is below it.
inline std::size_t skinnedPointCount(const ShapeDesc& desc) {
  return desc.skin.first.empty() ? desc.pointCount : desc.skin.skinnedPointCount();
}

/// Returns the number of normals of a smooth mesh: at least that of the points, or of the skin's places.
std::size_t normalCount(const ShapeDesc& desc);

/// Makes edges sharp where the surface bends by more than `angle` (radians, 0 to pi) between two triangles at
/// rest, and at edges that do not have two triangles. Around a point, triangles that are joined across smooth
/// edges share a normal. Vertices are added at sharp edges. `positions`: 3 x skinnedPointCount() floats.
/// Throws std::runtime_error for a description that is not valid, a tube, or another number of positions.
void sharpenEdges(ShapeDesc& desc, const std::vector<float>& positions, float angle);

/// Returns the reason why the description cannot be drawn (with array and index), or an empty string.
std::string validate(const ShapeDesc& desc);

}  // namespace limber::render
