// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>

#include "cook/equal_length_braces.h"
#include "core/mesh_edges.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace limber {
namespace {

std::vector<NetworkSpring> makeSprings(const std::vector<Edge>& edges, SpringKind kind,
                                       double stiffnessScale) {
  std::vector<NetworkSpring> springs;
  springs.reserve(edges.size());
  for (const Edge& edge : edges) springs.push_back({edge[0], edge[1], kind, stiffnessScale});
  return springs;
}

std::vector<NetworkSpring> joinSorted(const std::vector<NetworkSpring>& first,
                                      const std::vector<NetworkSpring>& second) {
  std::vector<NetworkSpring> all(first.size() + second.size());
  std::merge(
      first.begin(), first.end(), second.begin(), second.end(), all.begin(),
      [](const NetworkSpring& s, const NetworkSpring& t) { return s.a != t.a ? s.a < t.a : s.b < t.b; });
  return all;
}

std::vector<NetworkSpring> connect(const WeldedMesh& welded, const NetworkSettings& settings) {
  const std::vector<Edge> edges = uniqueEdges(welded.triangles);
  std::vector<NetworkSpring> springs = makeSprings(edges, SpringKind::Structural, 1.0);
  if (settings.braces == BraceRule::None) return springs;
  const std::vector<Edge> pairs = findEqualLengthPairs(welded.points, edges);
  return joinSorted(springs, makeSprings(pairs, SpringKind::Brace, settings.braceWeight));
}

RenderSurface makeRenderSurface(const TriangleMesh& mesh, const WeldedMesh& welded) {
  RenderSurface render;
  render.vertexToPoint = welded.vertexToPoint;
  render.uvs = mesh.uvs;
  render.triangles.reserve(welded.keptTriangles.size());
  for (const std::uint32_t kept : welded.keptTriangles) render.triangles.push_back(mesh.triangles[kept]);
  return render;
}

}  // namespace

Result<SharedNetwork> buildNetwork(const TriangleMesh& mesh, const NetworkSettings& settings) {
  if (settings.braces != BraceRule::None && !std::isfinite(settings.braceWeight) || settings.braceWeight <= 0.0) {
    return Error{"the brace weight is " + std::to_string(settings.braceWeight) + ", it must be above 0"};
  }
  Result<WeldedMesh> welded = weld(mesh, settings.weldTolerance);
  if (!welded) return Error{welded.error()};

  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Solid;
  network->springs = connect(*welded, settings);
  network->massShares =
      std::vector<double>(welded->points.size(), 1.0 / static_cast<double>(welded->points.size()));
  network->render = makeRenderSurface(mesh, *welded);
  network->report = welded->report;
  network->restPoints = std::move(welded->points);
  network->surface = std::move(welded->triangles);
  return SharedNetwork(std::move(network));
}

}  // namespace limber
