// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/surface.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <array>
#include <map>
#include <memory>
#include <utility>

namespace limber {

/// The surfaces of networks at the scales that bodies have: equal bodies share one. Those that no body has
/// any more are forgotten.
class SharedTopologies {
 public:
  /// Its points are those of the network; without triangles its structural springs are its edges.
  std::shared_ptr<const SurfaceTopology> of(const SharedNetwork& network, const SoftBodySettings& settings);

 private:
  using Key = std::pair<const SpringNetwork*, std::array<double, 3>>;
  struct Entry {
    SharedNetwork network;  ///< so that no other takes its address
    std::weak_ptr<const SurfaceTopology> topology;
  };
  std::map<Key, Entry> entries_;
};

}  // namespace limber
