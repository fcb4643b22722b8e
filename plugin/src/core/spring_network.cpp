// SPDX-License-Identifier: Zlib
#include <limber/spring_network.h>

#include <array>
#include <cmath>
#include <cstddef>

namespace limber {
namespace {

/// How far the mass shares may be from 1 together: the rounding of a sum of millions.
constexpr double kShareRounding = 1e-9;

using Pair = std::array<std::uint32_t, 2>;

std::string name(const char* what, std::size_t index) { return what + (" " + std::to_string(index)); }

std::string checkPoints(const std::vector<Eigen::Vector3d>& points) {
  if (points.empty()) return "the network has no points";
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) return name("point", i) + " is not finite";
  }
  return {};
}

std::string checkMassShares(const std::vector<double>& shares, std::size_t points) {
  if (shares.size() != points) {
    return std::to_string(shares.size()) + " mass shares for " + std::to_string(points) + " points";
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (!std::isfinite(shares[i]) || shares[i] <= 0.0) return name("mass share", i) + " is not above 0";
    sum += shares[i];
  }
  if (std::abs(sum - 1.0) > kShareRounding)
    return "the mass shares sum to " + std::to_string(sum) + ", not to 1";
  return {};
}

std::string checkSpring(const NetworkSpring& spring, std::size_t points) {
  if (spring.a >= spring.b) return " does not go from a lower to a higher point";
  if (spring.b >= points) return " uses point " + std::to_string(spring.b) + " of " + std::to_string(points);
  if (!std::isfinite(spring.stiffnessScale) || spring.stiffnessScale <= 0.0) {
    return " has a stiffness scale that is not above 0";
  }
  return {};
}

std::string checkSprings(const std::vector<NetworkSpring>& springs, std::size_t points) {
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const std::string reason = checkSpring(springs[i], points);
    if (!reason.empty()) return name("spring", i) + reason;
    if (i == 0) continue;
    const Pair previous{springs[i - 1].a, springs[i - 1].b}, pair{springs[i].a, springs[i].b};
    if (pair == previous) return name("spring", i) + " joins the same points as the one before";
    if (pair < previous) return name("spring", i) + " is not in the order of its points";
  }
  return {};
}

std::string checkTriangles(const std::vector<Triangle>& triangles, std::size_t count,
                           const char* triangleName, const char* cornerName) {
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const std::uint32_t corner : triangles[i]) {
      if (corner < count) continue;
      return name(triangleName, i) + " uses " + name(cornerName, corner) + " of " + std::to_string(count);
    }
  }
  return {};
}

std::string checkVertexToPoint(const std::vector<std::uint32_t>& vertexToPoint, std::size_t points) {
  for (std::size_t i = 0; i < vertexToPoint.size(); ++i) {
    if (vertexToPoint[i] < points || vertexToPoint[i] == kNoPoint) continue;
    return name("render vertex", i) + " rides on " + name("point", vertexToPoint[i]) + " of " +
           std::to_string(points);
  }
  return {};
}

std::string checkPointless(const RenderSurface& render) {
  for (std::size_t i = 0; i < render.triangles.size(); ++i) {
    for (const std::uint32_t vertex : render.triangles[i]) {
      if (render.vertexToPoint[vertex] != kNoPoint) continue;
      return name("render triangle", i) + " uses " + name("vertex", vertex) + ", which rides on no point";
    }
  }
  return {};
}

std::string checkRender(const RenderSurface& render, std::size_t points) {
  const std::size_t vertices = render.vertexToPoint.size();
  if (!render.uvs.empty() && render.uvs.size() != vertices) {
    return std::to_string(render.uvs.size()) + " texture coordinates for " + std::to_string(vertices) +
           " render vertices";
  }
  std::string reason = checkVertexToPoint(render.vertexToPoint, points);
  if (reason.empty()) reason = checkTriangles(render.triangles, vertices, "render triangle", "vertex");
  if (reason.empty()) reason = checkPointless(render);
  return reason;
}

std::string checkRopeHasNoSurface(const SpringNetwork& network) {
  const RenderSurface& render = network.render;
  const bool bare = network.surface.empty() && render.triangles.empty() && render.vertexToPoint.empty();
  return network.kind != NetworkKind::Rope || bare ? std::string() : "a rope has no surface";
}

}  // namespace

std::string validate(const SpringNetwork& network) {
  const std::size_t points = network.restPoints.size();
  std::string reason = checkPoints(network.restPoints);
  if (reason.empty()) reason = checkMassShares(network.massShares, points);
  if (reason.empty()) reason = checkSprings(network.springs, points);
  if (reason.empty()) reason = checkTriangles(network.surface, points, "surface triangle", "point");
  if (reason.empty()) reason = checkRender(network.render, points);
  if (reason.empty()) reason = checkRopeHasNoSurface(network);
  return reason;
}

}  // namespace limber
