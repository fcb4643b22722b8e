// SPDX-License-Identifier: Zlib
#include <limber/skin.h>

#include "cook/skin_weights.h"
#include "mesh/surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace limber {
namespace {

/// 8 bytes each in the skin, 12 more while it is made.
constexpr std::size_t kMostWeights = 20'000'000;

SkinProblem makeProblem(const SpringNetwork& network, const WeldedMesh& mesh, SkinKind kind) {
  SkinProblem problem{network.restPoints, mesh.points, vertexNormals(mesh.points, mesh.triangles), {}};
  if (kind == SkinKind::Barycentric) return problem;
  const TriangleBvh surface(network.restPoints, network.surface);
  problem.variances = belonging(mesh, network, surface) * gapVariances(network, surface);
  return problem;
}

std::string refuse(const SpringNetwork& network, const WeldedMesh& mesh, const SkinSettings& settings) {
  if (settings.neighbours < 4)
    return "a skin of " + std::to_string(settings.neighbours) +
           " neighbours was asked for, it takes 4 or more";
  if (std::string reason = validate(network); !reason.empty()) return "network: " + reason;
  if (network.surface.empty()) return "a network without a surface has no skin";
  if (!spansSpace(network.restPoints))
    return "the points of the network lie in a plane: no skin can ride on them";
  const std::size_t weights =
      std::max(mesh.points.size(), network.restPoints.size()) * network.restPoints.size();
  if (settings.kind == SkinKind::Dense && weights > kMostWeights) {
    return "a dense skin of " + std::to_string(mesh.points.size()) + " vertices on " +
           std::to_string(network.restPoints.size()) + " points takes " + std::to_string(weights) +
           " numbers, more than " + std::to_string(kMostWeights) + ": use a sparse one";
  }
  return {};
}

RenderSurface makeRenderSurface(const TriangleMesh& mesh, const WeldedMesh& welded, Skin skin) {
  RenderSurface render;
  render.skin = std::move(skin);
  render.vertexToPoint = welded.vertexToPoint;
  render.uvs = mesh.uvs;
  for (const std::uint32_t kept : welded.keptTriangles) render.triangles.push_back(mesh.triangles[kept]);
  return render;
}

/// Largest first, each with the rounding error of those before: what is left over is that of the smallest.
void roundPlace(const SkinWeights& exact, std::uint32_t begin, std::uint32_t end,
                std::vector<float>& weights) {
  std::vector<std::uint32_t> order(end - begin);
  std::iota(order.begin(), order.end(), begin);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return std::abs(exact.weights[i]) > std::abs(exact.weights[j]);
  });
  double left = 0.0;
  for (const std::uint32_t w : order) {
    weights[w] = static_cast<float>(exact.weights[w] + left);
    left += exact.weights[w] - static_cast<double>(weights[w]);
  }
}

}  // namespace

Skin rounded(const SkinWeights& exact) {
  Skin skin{exact.firstWeight, exact.points, std::vector<float>(exact.weights.size())};
  for (std::size_t i = 0; i < skin.size(); ++i)
    roundPlace(exact, exact.firstWeight[i], exact.firstWeight[i + 1], skin.weights);
  return skin;
}

namespace {

SkinWeights solve(const SpringNetwork& network, const SkinProblem& problem, const SkinSettings& settings) {
  if (settings.kind == SkinKind::Dense) return denseWeights(problem);
  if (settings.kind == SkinKind::Sparse) return sparseWeights(problem, settings.neighbours);
  return network.tetrahedra.empty() ? triangleWeights(problem, network.surface)
                                    : tetrahedronWeights(problem, network.tetrahedra);
}

}  // namespace

Result<SkinWeights> skinWeights(const SpringNetwork& network, const WeldedMesh& mesh,
                                const SkinSettings& settings) {
  if (std::string reason = refuse(network, mesh, settings); !reason.empty()) return Error{std::move(reason)};
  SkinWeights weights = solve(network, makeProblem(network, mesh, settings.kind), settings);
  const auto finite = [](double w) { return std::isfinite(w); };
  if (!std::all_of(weights.weights.begin(), weights.weights.end(), finite))
    return Error{"no skin can ride on this network: points coincide, or triangles have no area"};
  return weights;
}

Result<SharedNetwork> withSkin(const SpringNetwork& network, const TriangleMesh& mesh,
                               const SkinSettings& settings) {
  Result<WeldedMesh> welded = weld(mesh, settings.weldTolerance);
  if (!welded) return Error{welded.error()};
  const std::vector<bool> inward = facingInward(welded->points, welded->triangles);
  turn(welded->triangles, inward);
  Result<SkinWeights> weights = skinWeights(network, *welded, settings);
  if (!weights) return Error{weights.error()};
  auto skinned = std::make_shared<SpringNetwork>(network);
  skinned->render = makeRenderSurface(mesh, *welded, rounded(*weights));
  turn(skinned->render.triangles, inward);
  return SharedNetwork(std::move(skinned));
}

/// Relative to the first point of each place, so that nothing is lost far from the origin.
void applySkin(const Skin& skin, const float* points, float* places) {
  for (std::size_t i = 0; i < skin.size(); ++i) {
    const std::uint32_t begin = skin.firstWeight[i], end = skin.firstWeight[i + 1];
    const float* origin = points + 3 * std::size_t(skin.points[begin]);
    float x = 0.0f, y = 0.0f, z = 0.0f;
    for (std::uint32_t w = begin; w < end; ++w) {
      const float* p = points + 3 * std::size_t(skin.points[w]);
      x += skin.weights[w] * (p[0] - origin[0]);
      y += skin.weights[w] * (p[1] - origin[1]);
      z += skin.weights[w] * (p[2] - origin[2]);
    }
    places[3 * i] = origin[0] + x;
    places[3 * i + 1] = origin[1] + y;
    places[3 * i + 2] = origin[2] + z;
  }
}

}  // namespace limber
