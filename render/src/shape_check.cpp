// SPDX-License-Identifier: Zlib
#include <cmath>
#include <cstddef>

#include "limber/render/shape_desc.h"

namespace limber::render {
namespace {

std::string number(std::size_t value) { return std::to_string(value); }

std::string checkIndices(const char* array, const std::vector<std::uint32_t>& indices, std::size_t limit,
                         const char* what) {
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] >= limit) {
      return std::string(array) + "[" + number(i) + "] is " + number(indices[i]) + ", but there are only " +
             number(limit) + " " + what;
    }
  }
  return {};
}

std::string checkLines(const ShapeDesc& desc) {
  if (desc.lines.size() % 2 != 0) {
    return "lines has " + number(desc.lines.size()) + " indices, which is no multiple of 2";
  }
  if (!desc.lineRestLengths.empty() && 2 * desc.lineRestLengths.size() != desc.lines.size()) {
    return "lineRestLengths has " + number(desc.lineRestLengths.size()) + " entries for " +
           number(desc.lines.size() / 2) + " lines";
  }
  for (std::size_t i = 0; i < desc.lineRestLengths.size(); ++i) {
    if (!(desc.lineRestLengths[i] > 0.0f) || !std::isfinite(desc.lineRestLengths[i])) {
      return "lineRestLengths[" + number(i) + "] is not a positive length";
    }
  }
  return checkIndices("lines", desc.lines, desc.pointCount, "points");
}

std::string checkTube(const ShapeDesc& desc) {
  if (!std::isfinite(desc.tubeRadius)) {
    return "tubeRadius is not finite";
  }
  if (desc.pointCount < 2) {
    return "a tube needs at least 2 points";
  }
  if (desc.tubeSegments < 3) {
    return "tubeSegments is " + number(desc.tubeSegments) + ", but a tube needs at least 3";
  }
  if (!desc.triangles.empty() || !desc.vertexToPoint.empty() || !desc.uvs.empty() ||
      !desc.vertexToNormal.empty() || !desc.skin.first.empty()) {
    return "a tube makes its own vertices: triangles, vertexToPoint, uvs, vertexToNormal and skin must be "
           "empty";
  }
  return {};
}

std::string checkPattern(const ShapeDesc& desc) {
  if (desc.pattern == Pattern::Grid && (desc.uvs.empty() || !(desc.patternRadius > 0.0f))) {
    return "the grid pattern needs uvs and a positive patternRadius";
  }
  return {};
}

std::string checkSkinRows(const std::vector<std::uint32_t>& first, std::size_t weights) {
  if (first.front() != 0 || first.back() != weights) {
    return "skin.first goes from " + number(first.front()) + " to " + number(first.back()) +
           ", but must go from 0 to the " + number(weights) + " weights";
  }
  for (std::size_t i = 0; i + 1 < first.size(); ++i) {
    if (first[i] > first[i + 1]) {
      return "skin.first[" + number(i + 1) + "] is below the entry before it";
    }
  }
  return {};
}

std::string checkSkin(const ShapeDesc& desc) {
  const Skin& skin = desc.skin;
  if (skin.points.size() != skin.weights.size()) {
    return "skin.points has " + number(skin.points.size()) + " entries for " + number(skin.weights.size()) +
           " weights";
  }
  if (skin.first.empty()) {
    return skin.weights.empty() ? "" : "skin.first is empty, but there are weights";
  }
  for (std::size_t i = 0; i < skin.weights.size(); ++i) {
    if (!std::isfinite(skin.weights[i])) {
      return "skin.weights[" + number(i) + "] is not finite";
    }
  }
  const std::string reason = checkSkinRows(skin.first, skin.weights.size());
  return reason.empty() ? checkIndices("skin.points", skin.points, desc.pointCount, "points") : reason;
}

std::string checkMesh(const ShapeDesc& desc) {
  if (std::string reason = checkSkin(desc); !reason.empty()) {
    return reason;
  }
  const std::size_t vertices =
      desc.vertexToPoint.empty() ? skinnedPointCount(desc) : desc.vertexToPoint.size();
  if (!desc.uvs.empty() && desc.uvs.size() != 2 * vertices) {
    return "uvs has " + number(desc.uvs.size()) + " floats for " + number(vertices) + " vertices";
  }
  if (!desc.vertexToNormal.empty() && desc.vertexToNormal.size() != vertices) {
    return "vertexToNormal has " + number(desc.vertexToNormal.size()) + " entries for " + number(vertices) +
           " vertices";
  }
  if (desc.triangles.size() % 3 != 0) {
    return "triangles has " + number(desc.triangles.size()) + " indices, which is no multiple of 3";
  }
  if (desc.triangles.empty() && desc.lines.empty()) {
    return "there is nothing to draw: no triangles, no lines and no tubeRadius";
  }
  std::string reason = checkIndices("vertexToPoint", desc.vertexToPoint, skinnedPointCount(desc),
                                    desc.skin.first.empty() ? "points" : "places of the skin");
  if (reason.empty()) {
    reason = checkIndices("triangles", desc.triangles, vertices, "vertices");
  }
  if (reason.empty()) {
    reason = checkIndices("vertexToNormal", desc.vertexToNormal, skinnedPointCount(desc) + vertices,
                          "points and vertices");
  }
  return reason.empty() ? checkPattern(desc) : reason;
}

}  // namespace

std::string validate(const ShapeDesc& desc) {
  if (desc.pointCount == 0) {
    return "pointCount is 0";
  }
  const std::string reason = desc.tubeRadius > 0.0f ? checkTube(desc) : checkMesh(desc);
  return reason.empty() ? checkLines(desc) : reason;
}

}  // namespace limber::render
