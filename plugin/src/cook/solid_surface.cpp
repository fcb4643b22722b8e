// SPDX-License-Identifier: Zlib
#include "cook/solid_surface.h"

#include "mesh/edges.h"
#include "mesh/surface.h"

#include <utility>

namespace limber {
namespace {

using Eigen::Vector3d;

}  // namespace

std::string whyNotSolid(const MeshReport& report) {
  if (report.openEdges > 0)
    return "the mesh is not closed: it has " + std::to_string(report.openEdges) + " open edges";
  if (report.inconsistentEdges > 0)
    return "the mesh has no inside: at " + std::to_string(report.inconsistentEdges) +
           " edges its triangles are oriented against each other";
  return {};
}

SolidSurface makeSolidSurface(const WeldedMesh& mesh) {
  const std::vector<Triangle> triangles = turnedOutward(mesh.points, mesh.triangles);
  SolidSurface s{triangles, {}, {}, {}, 0, TriangleBvh(mesh.points, triangles), {}, 0.0};
  SurfaceComponents components = findComponents(mesh.points.size(), triangles);
  s.pieces = components.count;
  s.pieceOfTriangle = std::move(components.ofTriangle);
  s.volume = signedVolume(mesh.points, triangles);
  for (const Triangle& t : triangles) {
    const Vector3d &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    s.centroids.emplace_back((a + b + c) / 3.0);
    s.normals.push_back((b - a).cross(c - a).normalized());
    s.box.extend(a).extend(b).extend(c);
  }
  return s;
}

}  // namespace limber
