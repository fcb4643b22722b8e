// SPDX-License-Identifier: Zlib
#include "bullet/world_clock.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// btDiscreteDynamicsWorld has no getters for its clock; a derived class may name the protected members.
struct ClockReader : btDiscreteDynamicsWorld {
  static btScalar timeSinceTick(const btDiscreteDynamicsWorld& world) {
    return world.*(&ClockReader::m_localTime);
  }
  static btScalar fixedTick(const btDiscreteDynamicsWorld& world) {
    return world.*(&ClockReader::m_fixedTimeStep);
  }
  static bool showsThePast(const btDiscreteDynamicsWorld& world) {
    return world.*(&ClockReader::m_latencyMotionStateInterpolation);
  }
};

}  // namespace

// As btDiscreteDynamicsWorld::synchronizeSingleMotionState: from the state after the last tick it goes
// m_localTime - m_fixedTimeStep with latency and m_localTime without. With ticks of variable length the world
// sets m_fixedTimeStep to 0 and always shows the last tick.
double tickFraction(const btDiscreteDynamicsWorld& world) {
  const double tick = double(ClockReader::fixedTick(world));
  if (!(tick > 0.0)) return 1.0;
  const double share = double(ClockReader::timeSinceTick(world)) / tick;
  return ClockReader::showsThePast(world) ? share : 1.0 + share;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
