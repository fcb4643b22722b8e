// SPDX-License-Identifier: Zlib
#include "bullet/shared_topologies.h"

namespace limber {
namespace {

/// A scale that mirrors the network turns its triangles inside out: here they are turned back.
SurfaceFeatures featuresOf(const SpringNetwork& network, const SoftBodySettings& settings) {
  SurfaceFeatures features;
  features.triangles = network.surface;
  if (settings.scale.prod() < 0.0)
    for (Triangle& t : features.triangles) std::swap(t[1], t[2]);
  if (!features.triangles.empty()) return features;
  for (const NetworkSpring& spring : network.springs)
    if (spring.kind == SpringKind::Structural) features.segments.push_back({spring.a, spring.b});
  if (features.segments.empty())
    for (std::uint32_t i = 0; i < network.restPoints.size(); ++i) features.vertices.push_back(i);
  return features;
}

std::shared_ptr<const SurfaceTopology> makeTopology(const SpringNetwork& network,
                                                    const SoftBodySettings& settings) {
  Points rest(3, static_cast<Eigen::Index>(network.restPoints.size()));
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    rest.col(i) = network.restPoints[static_cast<std::size_t>(i)].cwiseProduct(settings.scale);
  Result<SurfaceTopology> topology = makeSurfaceTopology(rest, featuresOf(network, settings));
  return topology ? std::make_shared<const SurfaceTopology>(std::move(*topology)) : nullptr;
}

}  // namespace

std::shared_ptr<const SurfaceTopology> SharedTopologies::of(const SharedNetwork& network,
                                                            const SoftBodySettings& settings) {
  const Key key{network.get(), {settings.scale.x(), settings.scale.y(), settings.scale.z()}};
  Entry& entry = entries_[key];
  std::shared_ptr<const SurfaceTopology> topology = entry.topology.lock();
  if (topology) return topology;
  topology = makeTopology(*network, settings);
  entry.network = network;
  entry.topology = topology;
  for (auto it = entries_.begin(); it != entries_.end();)
    it = it->second.topology.expired() ? entries_.erase(it) : std::next(it);
  return topology;
}

}  // namespace limber
