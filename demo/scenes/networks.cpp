// SPDX-License-Identifier: Zlib
#include "scenes/networks.h"

#include "mesh_reader.h"

#include <limber/mesh.h>
#include <limber/network_builder.h>
#include <limber/spring_network.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace limber::scenes {

bool isLimberFile(const std::string& file) {
  const std::string ending = ".limber";
  return file.size() > ending.size() && file.compare(file.size() - ending.size(), ending.size(), ending) == 0;
}

Result<SharedNetwork> readNetwork(const std::string& file) {
  if (isLimberFile(file)) return loadNetwork(file);
  const Result<TriangleMesh> mesh = demo::readMesh(file);
  if (!mesh) return Error{mesh.error()};
  Result<SharedNetwork> network = buildNetwork(*mesh);
  if (!network) return Error{file + ": " + network.error()};
  return network;
}

namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

using Positions = std::vector<Eigen::Vector3f>;

Eigen::Vector3f normalOf(const Positions& x, const Triangle& t) {
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
}

Positions restPoints(const SpringNetwork& network) {
  Positions points;
  for (const Eigen::Vector3d& p : network.restPoints) points.push_back(p.cast<float>());
  return points;
}

/// Returns the positions of the drawn vertices at rest: the places of the skin, or the points.
Positions restVertexPositions(const SpringNetwork& network) {
  const Positions points = restPoints(network);
  const Skin& skin = network.render.skin;
  if (skin.size() == 0) return points;
  Positions places(skin.size());
  applySkin(skin, points.front().data(), places.front().data());
  return places;
}

double angle(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::acos(std::clamp(double(a.dot(b)), -1.0, 1.0));
}

/// Returns the angles at the edges, ascending.
std::vector<double> bends(const SpringNetwork& network) {
  const Positions places = restVertexPositions(network);
  const auto& placeOf = network.render.vertexToPoint;
  std::map<Edge, Eigen::Vector3f> normals;  // of the first triangle at each edge
  std::vector<double> angles;
  for (const Triangle& drawn : network.render.triangles) {
    const Triangle t = {placeOf[drawn[0]], placeOf[drawn[1]], placeOf[drawn[2]]};
    const Eigen::Vector3f normal = normalOf(places, t);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Edge edge = std::minmax({t[corner], t[(corner + 1) % 3]});
      const auto [entry, isNew] = normals.try_emplace(edge, normal);
      if (!isNew) angles.push_back(angle(entry->second, normal));
    }
  }
  std::sort(angles.begin(), angles.end());
  return angles;
}

}  // namespace

double sharpestBend(const SpringNetwork& network) {
  const std::vector<double> angles = bends(network);
  return angles.empty() ? 0.0 : angles.back();
}

double usualBend(const SpringNetwork& network) {
  const std::vector<double> angles = bends(network);
  return angles.empty() ? 0.0 : angles[9 * angles.size() / 10];
}

}  // namespace limber::scenes
