// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/shape_surface.h"

#include <cstdint>
#include <memory>
#include <unordered_map>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

inline void addToHash(std::uint64_t& hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
  hash ^= hash >> 29;
}

/// Of everything that makes a convex shape what it is now: type, margin, and corners, scaling included.
std::uint64_t hashOfShape(const btCollisionShape& shape);

/// The surfaces of convex shapes that soft bodies have come near, until nobody asks for them any more. A shape that
/// has been changed, or deleted and another one made in its place, is seen by its hash.
class ShapeCache {
 public:
  const ShapeSurface& surfaceOf(const btCollisionShape& shape);

  /// Before a tick, when nobody holds a surface: forgets those that nobody has asked for in a long time.
  void forgetOld();

 private:
  struct Entry {
    std::uint64_t hash = 0;
    std::unique_ptr<ShapeSurface> surface;
    std::uint64_t lastUsed = 0;
  };

  std::unordered_map<const btCollisionShape*, Entry> entries_;
  std::uint64_t tick_ = 0;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
