// SPDX-License-Identifier: Zlib
#include "bullet/kept_points.h"

#include <algorithm>
#include <functional>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// As many as two faces of boxes have.
constexpr std::size_t kMostPoints = 8;

bool isBefore(const KeptPoint& x, const KeptPoint& y) {
  if (x.manifold != y.manifold) return std::less<const void*>()(x.manifold, y.manifold);
  return x.order < y.order;
}

bool has(const btPersistentManifold& manifold, const btManifoldPoint& point) {
  const btScalar same = manifold.getContactBreakingThreshold();
  for (int p = 0; p < manifold.getNumContacts(); ++p)
    if (manifold.getContactPoint(p).m_localPointA.distance2(point.m_localPointA) < same * same) return true;
  return false;
}

/// As btPersistentManifold::refreshContactPoints has it.
bool holds(const btPersistentManifold& manifold, const btManifoldPoint& point) {
  const btScalar most = manifold.getContactBreakingThreshold();
  const btVector3 apart = manifold.getBody0()->getWorldTransform() * point.m_localPointA -
                          manifold.getBody1()->getWorldTransform() * point.m_localPointB;
  const btScalar gap = apart.dot(point.m_normalWorldOnB);
  return gap <= most && (apart - gap * point.m_normalWorldOnB).length2() <= most * most;
}

void keep(const btPersistentManifold& manifold, const btManifoldPoint& point, std::vector<KeptPoint>& now) {
  now.push_back(
      {&manifold, manifold.getBody0(), manifold.getBody1(), static_cast<std::uint32_t>(now.size()), point});
}

}  // namespace

std::size_t keepPoints(const btPersistentManifold& manifold, KeptPoints& kept) {
  const std::size_t first = kept.now.size();
  for (int p = 0; p < manifold.getNumContacts(); ++p) keep(manifold, manifold.getContactPoint(p), kept.now);
  const std::size_t extra = kept.now.size();
  const auto isEarlier = [](const KeptPoint& k, const btPersistentManifold* m) {
    return std::less<const void*>()(k.manifold, m);
  };
  auto k = std::lower_bound(kept.last.begin(), kept.last.end(), &manifold, isEarlier);
  for (; k != kept.last.end() && k->manifold == &manifold; ++k) {
    if (k->a != manifold.getBody0() || k->b != manifold.getBody1()) continue;
    if (has(manifold, k->point) || !holds(manifold, k->point)) continue;
    if (kept.now.size() - first < kMostPoints) keep(manifold, k->point, kept.now);
  }
  return extra;
}

void turnOver(KeptPoints& kept) {
  kept.last.swap(kept.now);
  kept.now.clear();
  std::sort(kept.last.begin(), kept.last.end(), isBefore);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
