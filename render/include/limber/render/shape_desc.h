// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber::render {

enum class Shading {
  Flat,   ///< One normal per triangle, from screen-space derivatives.
  Smooth  ///< Area-weighted normals per point, computed on the GPU every frame.
};

enum class Pattern {
  Plain,
  Grid  ///< Lines every metre of uv over a checker, fading out at uv length `patternRadius`.
};

/// Places that follow the points: place p is the sum of weights[k] times point points[k] over k from
/// first[p] up to first[p + 1], computed on the GPU every frame. With it a detailed mesh costs no more
/// to stream than the few points that move it. The weights of a place should add up to 1, or it will
/// not move along with its body.
struct Skin {
  std::vector<std::uint32_t> first;   ///< #places + 1, rising from 0; empty: no skin.
  std::vector<std::uint32_t> points;  ///< One per weight.
  std::vector<float> weights;

  std::size_t placeCount() const { return first.empty() ? 0 : first.size() - 1; }
};

/// What all instances of one body type share: topology and looks that never change. Points are
/// what moves (three floats each, streamed every frame); a vertex is a point, or with a skin a place,
/// with a texture coordinate, so that seams need no second point.
///
/// A mesh has triangles; a tube (rope) has `tubeRadius` > 0 and no triangles: its points are the
/// polyline, its surface is made on the GPU. Either may have lines, and lines alone are a shape
/// too (it is then invisible except in wireframe mode).
struct ShapeDesc {
  std::string name;  ///< Only used in error messages.

  std::uint32_t pointCount = 0;  ///< At least 1; a tube needs at least 2.
  Skin skin;                     ///< Empty: vertices ride on the points themselves.
  std::vector<std::uint32_t>
      vertexToPoint;                     ///< One per vertex, of a place if there is a skin; empty: i to i.
  std::vector<float> uvs;                ///< 2 per vertex, or empty.
  std::vector<std::uint32_t> triangles;  ///< 3 vertex indices each, counter-clockwise outside.
  std::vector<std::uint32_t> lines;      ///< 2 point indices each.
  std::vector<float> lineRestLengths;    ///< Metres, > 0, one per line; empty: not coloured.

  Shading shading = Shading::Flat;
  bool twoSided = false;    ///< Draw and light both sides (cloth).
  bool castsShadow = true;  ///< Off saves much for a floor, which has nothing below it.

  float tubeRadius = 0.0f;          ///< Metres; above 0 makes this a tube.
  std::uint32_t tubeSegments = 12;  ///< Around the tube; at least 3.

  Pattern pattern = Pattern::Plain;
  float patternRadius = 0.0f;  ///< Metres of uv at which a Grid has faded away.
};

/// What vertexToPoint counts: the places of the skin, without one the points.
inline std::size_t placeCount(const ShapeDesc& desc) {
  return desc.skin.first.empty() ? desc.pointCount : desc.skin.placeCount();
}

/// Why the description cannot be drawn (naming the array and the index), or empty if it can.
std::string validate(const ShapeDesc& desc);

}  // namespace limber::render
