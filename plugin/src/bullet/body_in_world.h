// SPDX-License-Identifier: Zlib

// These functions make a body, bring it into the world and out of it, and take it through the stages of a
// tick, in either of the two ways in which bodies live there.

#pragma once

#include "bullet/soft_body_data.h"
#include "collide/surface.h"

#include <limber/result.h>
#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <array>
#include <map>
#include <memory>
#include <utility>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- a new body --------------------------------------------------------------------------------------------

/// A body at its starting place, not yet in a world. Errors as SoftBodySystem::createBody.
Result<std::unique_ptr<SoftBodyData>> makeBodyData(SharedNetwork network, const SoftBodySettings& settings);

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

// --- in the world ------------------------------------------------------------------------------------------

// The two ways a body lives in the world, point_masses.h and surface_body.h, by its settings.

void addToWorld(SoftBodyData& body);
void removeFromWorld(SoftBodyData& body);

/// Whether anything of the body is in a world that still exists.
bool anyInWorld(const SoftBodyData& body);

/// Whether everything of it is.
bool wholeInWorld(const SoftBodyData& body);

/// Wakes it; `insideTick`: it also gets the gravity of this step that it missed while asleep.
void wakeBody(SoftBodyData& body, bool insideTick);

/// Whether it moves too much to sleep, see anyPointMoves().
bool movesTooFast(const SoftBodyData& body, btScalar tick);

// The stages of a tick.
void gatherBody(SoftBodyData& body, btScalar tick);
void writeBodyToBullet(SoftBodyData& body, btScalar tick);
void finishBody(SoftBodyData& body, btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
