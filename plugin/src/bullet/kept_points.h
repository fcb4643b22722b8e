// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A point of a manifold as it was found.
struct KeptPoint {
  const btPersistentManifold* manifold;
  const btCollisionObject *a, *b;
  std::uint32_t order;  ///< in which it was kept
  btManifoldPoint point;
};

/// The contact points of the last tick. Bullet has four points at most in a manifold, of eight that boxes
/// upon each other may have, and from tick to tick others: now and then four on one side, from which the
/// upper box falls for a tick. With those of the ticks before that are still near, it does not.
struct KeptPoints {
  std::vector<KeptPoint> last;  ///< by manifold
  std::vector<KeptPoint> now;
};

/// Keeps the points of `manifold`, then those of it in kept.last that it has no more and that still hold.
/// Returns where the latter begin in kept.now; they go to its end.
std::size_t keepPoints(const btPersistentManifold& manifold, KeptPoints& kept);

/// Ends a tick: what was kept becomes what is known.
void turnOver(KeptPoints& kept);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
