// SPDX-License-Identifier: Zlib
// Splits meshes into parts that become bodies, and wraps parts.

#include "network/parts.h"

#include "mesh/edges.h"
#include "mesh/surface.h"
#include "mesh/triangle_bvh.h"
#include "mesh/wrap.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

namespace limber {
namespace {

/// Largest number of bodies. Meshes of more pieces, such as trees with leaves, are one body.
constexpr std::size_t kMaxBodies = 32;

/// Parts smaller than this fraction of the largest are left out.
constexpr double kMinPartSize = 0.005;

/// The finest cells, as a share of the thickness that all parts of a wrap get: finer ones show nothing more.
constexpr double kCellsPerThickness = 14.0;

/// Returns the part of the mesh with the marked triangles, and the vertices that these use.
TriangleMesh partOf(const TriangleMesh& mesh, const std::vector<char>& marked) {
  TriangleMesh part;
  std::vector<std::uint32_t> newIndex(mesh.positions.size(), kNoPoint);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!marked[t]) continue;
    part.triangles.push_back(mesh.triangles[t]);
    for (std::uint32_t& corner : part.triangles.back()) {
      if (newIndex[corner] == kNoPoint) {
        newIndex[corner] = static_cast<std::uint32_t>(part.positions.size());
        part.positions.push_back(mesh.positions[corner]);
        if (!mesh.normals.empty()) part.normals.push_back(mesh.normals[corner]);
        if (!mesh.uvs.empty()) part.uvs.push_back(mesh.uvs[corner]);
      }
      corner = newIndex[corner];
    }
  }
  return part;
}

/// The pieces of a wrapped mesh that become bodies, the largest first.
struct Shells {
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> bodyOfTriangle;
  std::size_t bodies = 0;
};

Shells findShells(const TriangleMesh& wrapped) {
  const SurfaceComponents pieces = findComponents(wrapped.positions.size(), wrapped.triangles);
  std::vector<std::vector<Triangle>> triangles(pieces.count);
  for (std::size_t t = 0; t < wrapped.triangles.size(); ++t)
    triangles[pieces.ofTriangle[t]].push_back(wrapped.triangles[t]);
  std::vector<double> volume;
  volume.reserve(triangles.size());
  for (const std::vector<Triangle>& piece : triangles)
    volume.push_back(signedVolume(wrapped.positions, piece));
  std::vector<std::size_t> order(pieces.count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return volume[a] > volume[b]; });
  Shells shells;
  for (const std::size_t piece : order) {
    if (volume[piece] <= 0.0) break;  // surfaces of hollows are negative
    shells.triangles.insert(shells.triangles.end(), triangles[piece].begin(), triangles[piece].end());
    shells.bodyOfTriangle.resize(shells.triangles.size(), static_cast<std::uint32_t>(shells.bodies++));
  }
  return shells;
}

/// Returns the body of each kept triangle of the mesh: that of the shell nearest to most vertices of its
/// component.
std::vector<std::uint32_t> bodyOfTriangles(const WeldedMesh& welded, const TriangleMesh& wrapped,
                                           const Shells& shells) {
  const TriangleBvh bvh(wrapped.positions, shells.triangles);
  const SurfaceComponents pieces = findComponents(welded.points.size(), welded.triangles);
  std::vector<std::vector<std::size_t>> votes(pieces.count, std::vector<std::size_t>(shells.bodies, 0));
  for (std::size_t t = 0; t < welded.triangles.size(); ++t)
    ++votes[pieces.ofTriangle[t]]
           [shells.bodyOfTriangle[bvh.nearest(welded.points[welded.triangles[t][0]]).triangle]];
  std::vector<std::uint32_t> bodyOfPiece, body;
  for (const std::vector<std::size_t>& v : votes)
    bodyOfPiece.push_back(static_cast<std::uint32_t>(std::max_element(v.begin(), v.end()) - v.begin()));
  for (const std::uint32_t piece : pieces.ofTriangle) body.push_back(bodyOfPiece[piece]);
  return body;
}

void leaveOutTinyOnes(std::vector<Part>& parts) {
  double largest = 0.0;
  for (const Part& part : parts) largest = std::max(largest, extent(part.welded.points));
  const auto isTiny = [&](const Part& part) { return extent(part.welded.points) < kMinPartSize * largest; };
  parts.erase(std::remove_if(parts.begin(), parts.end(), isTiny), parts.end());
}

Result<Part> makePart(TriangleMesh mesh) {
  Result<WeldedMesh> welded = weld(mesh);
  if (!welded) return Error{welded.error()};
  return Part{std::move(mesh), std::move(*welded)};
}

}  // namespace

Result<std::vector<Part>> splitIntoParts(const TriangleMesh& mesh, const WrapSettings& settings,
                                         bool mayBeApart) {
  std::vector<Part> parts;
  Result<Part> whole = makePart(mesh);
  if (!whole) return Error{whole.error()};
  if (whole->welded.report.components > 1 && mayBeApart) {
    const Result<WrappedMesh> wrapped = wrapOfField(mesh, settings, "wrap.");
    if (!wrapped) return Error{wrapped.error()};
    const Shells shells = findShells(wrapped->mesh);
    if (shells.bodies > 1 && shells.bodies <= kMaxBodies) {
      const std::vector<std::uint32_t> body = bodyOfTriangles(whole->welded, wrapped->mesh, shells);
      for (std::uint32_t b = 0; b < shells.bodies; ++b) {
        std::vector<char> marked(mesh.triangles.size(), 0);
        for (std::size_t t = 0; t < body.size(); ++t) marked[whole->welded.keptTriangles[t]] = body[t] == b;
        if (std::none_of(marked.begin(), marked.end(), [](char m) { return m != 0; })) continue;
        Result<Part> part = makePart(partOf(mesh, marked));
        if (!part) return Error{part.error()};
        parts.push_back(std::move(*part));
      }
      leaveOutTinyOnes(parts);
      return parts;
    }
  }
  parts.push_back(std::move(*whole));
  return parts;
}

Result<WeldedMesh> wrapOutside(const TriangleMesh& mesh, WrapSettings settings, double thickness) {
  settings.connect = true;
  if (settings.resolution == 0.0) {
    const double cell = extent(mesh.positions) / kWrapCells;
    settings.resolution = std::max(cell, thickness / kCellsPerThickness);
    if (settings.thickness == 0.0) settings.thickness = kWrapWidths * cell;
    if (settings.join == 0.0) settings.join = kWrapWidths * cell;
  }
  settings.thickness = std::max(settings.thickness, thickness);
  const Result<WrappedMesh> result = wrapOfField(mesh, settings, "wrap.");
  if (!result) return Error{result.error()};
  TriangleMesh outside;
  outside.positions = result->mesh.positions;
  outside.triangles = findShells(result->mesh).triangles;
  return weld(outside);
}

}  // namespace limber
