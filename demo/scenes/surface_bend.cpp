// SPDX-License-Identifier: Zlib
#include "scenes/surface_bend.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace limber::scenes {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

Eigen::Vector3d normalOf(const SpringNetwork& network, const Triangle& t) {
  const Eigen::Vector3d& a = network.restPoints[t[0]];
  return (network.restPoints[t[1]] - a).cross(network.restPoints[t[2]] - a).normalized();
}

double angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

}  // namespace

double sharpestBend(const SpringNetwork& network) {
  std::map<Edge, Eigen::Vector3d> normals;  // of the first triangle met at each edge
  double sharpest = 0.0;
  for (const Triangle& t : network.surface) {
    const Eigen::Vector3d normal = normalOf(network, t);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Edge edge = std::minmax({t[corner], t[(corner + 1) % 3]});
      const auto [entry, isNew] = normals.try_emplace(edge, normal);
      if (!isNew) sharpest = std::max(sharpest, angle(entry->second, normal));
    }
  }
  return sharpest;
}

}  // namespace limber::scenes
