// SPDX-License-Identifier: Zlib
// Checks that a spring network satisfies the conditions of its members, and adds groups to it.

#include <limber/spring_network.h>

#include "mesh/surface.h"
#include "network/tetrahedra.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Tolerance of the sum of the mass fractions: the rounding of a sum of millions.
constexpr double kFractionRounding = 1e-9;

/// Tolerance of the sum of the weights of a skinned point: the rounding of thousands of floats.
constexpr double kWeightRounding = 1e-4;

/// m, as for meshes: volumes and their squares are far from the limits of a double.
constexpr double kMaxCoordinate = 1e9;

std::string checkPoints(const std::vector<Eigen::Vector3d>& points) {
  if (points.empty()) return "the network has no points";
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) return numbered("point", i) + " is not finite";
    if (points[i].cwiseAbs().maxCoeff() > kMaxCoordinate)
      return numbered("point", i) + " has a coordinate beyond 1e9";
  }
  return {};
}

std::string checkMassFractions(const std::vector<double>& fractions, std::size_t points) {
  if (fractions.size() != points) {
    return std::to_string(fractions.size()) + " mass fractions for " + std::to_string(points) + " points";
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < fractions.size(); ++i) {
    if (!std::isfinite(fractions[i]) || fractions[i] <= 0.0)
      return numbered("mass fraction", i) + " is not above 0";
    sum += fractions[i];
  }
  if (std::abs(sum - 1.0) > kFractionRounding)
    return "the mass fractions sum to " + std::to_string(sum) + ", not to 1";
  return {};
}

std::string checkSpring(const NetworkSpring& spring, std::size_t points) {
  if (spring.a >= spring.b) return " does not go from a lower to a higher point";
  if (spring.b >= points) return " uses point " + std::to_string(spring.b) + " of " + std::to_string(points);
  if (spring.kind > SpringKind::Brace) return " has an unknown kind";
  if (!std::isfinite(spring.stiffnessScale) || spring.stiffnessScale <= 0.0) {
    return " has a stiffness scale that is not above 0";
  }
  return {};
}

std::string checkSprings(const std::vector<NetworkSpring>& springs, std::size_t points) {
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const std::string reason = checkSpring(springs[i], points);
    if (!reason.empty()) return numbered("spring", i) + reason;
    if (i == 0) continue;
    const Edge previous{springs[i - 1].a, springs[i - 1].b}, pair{springs[i].a, springs[i].b};
    if (pair == previous) return numbered("spring", i) + " joins the same points as the one before";
    if (pair < previous) return numbered("spring", i) + " is not in the order of its points";
  }
  return {};
}

std::string checkCornersDiffer(const std::vector<Triangle>& triangles) {
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      return numbered("surface triangle", i) + " has one corner twice";
  }
  return {};
}

std::string checkNoTetrahedronTwice(std::vector<Tetrahedron> tetrahedra) {
  for (Tetrahedron& t : tetrahedra) std::sort(t.begin(), t.end());
  std::sort(tetrahedra.begin(), tetrahedra.end());
  const auto twice = std::adjacent_find(tetrahedra.begin(), tetrahedra.end());
  if (twice == tetrahedra.end()) return {};
  return "a tetrahedron of " + numbered("point", (*twice)[0]) + ", " + std::to_string((*twice)[1]) + ", " +
         std::to_string((*twice)[2]) + " and " + std::to_string((*twice)[3]) + " occurs twice";
}

std::string checkTetrahedra(const std::vector<Tetrahedron>& tetrahedra,
                            const std::vector<Eigen::Vector3d>& points) {
  for (std::size_t i = 0; i < tetrahedra.size(); ++i) {
    if (!(volumeOf(points, tetrahedra[i]) > 0.0))
      return numbered("tetrahedron", i) + " has a volume that is not above 0";
  }
  return {};
}

std::string checkNotNegative(double value, const char* name) {
  const bool valid = std::isfinite(value) && value >= 0.0;
  return valid ? std::string() : std::string("the ") + name + " is not a finite number of 0 or more";
}

std::string checkSkinSizes(const Skin& skin) {
  if (skin.points.size() != skin.weights.size()) {
    return "the skin has " + std::to_string(skin.weights.size()) + " weights for " +
           std::to_string(skin.points.size()) + " points";
  }
  const std::size_t last = skin.firstWeight.empty() ? 0 : skin.firstWeight.back();
  if (last != skin.weights.size()) {
    return "the skinned points have " + std::to_string(last) + " weights, there are " +
           std::to_string(skin.weights.size());
  }
  if (!skin.firstWeight.empty() && skin.firstWeight.front() != 0)
    return "the first skinned point does not begin at weight 0";
  for (std::size_t i = 0; i < skin.size(); ++i) {
    if (skin.firstWeight[i] >= skin.firstWeight[i + 1])
      return numbered("skinned point", i) + " has no weights";
  }
  return {};
}

std::string checkSkinnedPoint(const Skin& skin, std::size_t index, std::size_t points) {
  double sum = 0.0;
  for (std::uint32_t w = skin.firstWeight[index]; w < skin.firstWeight[index + 1]; ++w) {
    if (skin.points[w] >= points)
      return " follows " + numbered("point", skin.points[w]) + " of " + std::to_string(points);
    if (!std::isfinite(skin.weights[w])) return " has a weight that is not finite";
    sum += static_cast<double>(skin.weights[w]);
  }
  if (std::abs(sum - 1.0) > kWeightRounding) return " has weights that do not sum to 1";
  return {};
}

std::string checkSkin(const Skin& skin, std::size_t points) {
  std::string reason = checkSkinSizes(skin);
  for (std::size_t i = 0; reason.empty() && i < skin.size(); ++i) {
    const std::string problem = checkSkinnedPoint(skin, i, points);
    if (!problem.empty()) reason = numbered("skinned point", i) + problem;
  }
  return reason;
}

/// `target`: what the vertices follow, points or skinned points.
std::string checkVertexToPoint(const std::vector<std::uint32_t>& vertexToPoint, std::size_t count,
                               const char* target) {
  for (std::size_t i = 0; i < vertexToPoint.size(); ++i) {
    if (vertexToPoint[i] < count || vertexToPoint[i] == kNoPoint) continue;
    return numbered("render vertex", i) + " follows " + numbered(target, vertexToPoint[i]) + " of " +
           std::to_string(count);
  }
  return {};
}

std::string checkPointless(const RenderSurface& render) {
  for (std::size_t i = 0; i < render.triangles.size(); ++i) {
    for (const std::uint32_t vertex : render.triangles[i]) {
      if (render.vertexToPoint[vertex] != kNoPoint) continue;
      return numbered("render triangle", i) + " uses " + numbered("vertex", vertex) +
             ", which follows no point";
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
  const bool noSkin = render.skin.firstWeight.empty();
  std::string reason = checkSkin(render.skin, points);
  if (reason.empty()) {
    reason = checkVertexToPoint(render.vertexToPoint, noSkin ? points : render.skin.size(),
                                noSkin ? "point" : "skinned point");
  }
  if (reason.empty()) reason = checkCorners(render.triangles, vertices, "render triangle", "vertex");
  if (reason.empty()) reason = checkPointless(render);
  return reason;
}

std::string checkRopeHasNoSurface(const SpringNetwork& network) {
  const RenderSurface& render = network.render;
  const bool noSurface = network.surface.empty() && render.triangles.empty() &&
                         render.vertexToPoint.empty() && render.skin.firstWeight.empty() &&
                         network.tetrahedra.empty();
  return network.kind != NetworkKind::Rope || noSurface ? std::string()
                                                        : "a rope has no surface, skin or tetrahedra";
}

/// Checks that indices ascend and are below `count`.
std::string checkMembers(const std::vector<std::uint32_t>& members, std::size_t count, const char* what) {
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (members[i] >= count) return " has " + numbered(what, members[i]) + " of " + std::to_string(count);
    if (i > 0 && members[i] <= members[i - 1])
      return " has " + numbered(what, members[i]) + " after " + std::to_string(members[i - 1]);
  }
  return {};
}

std::string checkGroups(const SpringNetwork& network) {
  for (std::size_t i = 0; i < network.groups.size(); ++i) {
    const NamedGroup& group = network.groups[i];
    const auto same = [&](const NamedGroup& other) { return other.name == group.name; };
    const auto here = network.groups.begin() + static_cast<std::ptrdiff_t>(i);
    std::string reason;
    if (group.name.empty())
      reason = " has no name";
    else if (std::any_of(network.groups.begin(), here, same))
      reason = " has the name of an earlier one";
    if (reason.empty()) reason = checkMembers(group.springs, network.springs.size(), "spring");
    if (reason.empty()) reason = checkMembers(group.points, network.restPoints.size(), "point");
    if (!reason.empty()) return numbered("group", i) + " (" + group.name + ")" + reason;
  }
  return {};
}

}  // namespace

Result<SharedNetwork> withGroup(const SpringNetwork& network, const std::string& name,
                                std::vector<std::uint32_t> points) {
  sortUnique(points);
  const auto isMember = [&](std::uint32_t point) {
    return std::binary_search(points.begin(), points.end(), point);
  };
  auto result = std::make_shared<SpringNetwork>(network);
  NamedGroup group;
  group.name = name;
  for (std::uint32_t i = 0; i < network.springs.size(); ++i)
    if (isMember(network.springs[i].a) && isMember(network.springs[i].b)) group.springs.push_back(i);
  group.points = std::move(points);
  result->groups.push_back(std::move(group));
  if (std::string reason = checkGroups(*result); !reason.empty()) return Error{std::move(reason)};
  return SharedNetwork(std::move(result));
}

Result<void> validate(const SpringNetwork& network) {
  const std::size_t points = network.restPoints.size();
  std::string reason = network.kind > NetworkKind::Solid ? "the network has an unknown kind" : "";
  if (reason.empty()) reason = checkPoints(network.restPoints);
  if (reason.empty()) reason = checkMassFractions(network.massFractions, points);
  if (reason.empty()) reason = checkSprings(network.springs, points);
  if (reason.empty()) reason = checkCorners(network.surface, points, "surface triangle", "point");
  if (reason.empty()) reason = checkCornersDiffer(network.surface);
  if (reason.empty()) reason = checkCorners(network.tetrahedra, points, "tetrahedron", "point");
  if (reason.empty()) reason = checkTetrahedra(network.tetrahedra, network.restPoints);
  if (reason.empty()) reason = checkNoTetrahedronTwice(network.tetrahedra);
  if (reason.empty()) reason = checkNotNegative(network.stiffnessPerModulus, "stiffness per modulus");
  if (reason.empty()) reason = checkNotNegative(network.thickness, "thickness");
  if (reason.empty()) reason = checkNotNegative(network.volume, "volume");
  if (reason.empty()) reason = checkRender(network.render, points);
  if (reason.empty()) reason = checkRopeHasNoSurface(network);
  if (reason.empty()) reason = checkGroups(network);
  return reason.empty() ? Result<void>() : Error{std::move(reason)};
}

}  // namespace limber
