// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/shape_surface.h"

#include <memory>
#include <unordered_map>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The surfaces of convex shapes that soft bodies have come near. A shape that has been changed, or deleted
/// and another one made in its place, is seen by its type, size and number of vertices.
class ShapeCache {
 public:
  const ShapeSurface& surfaceOf(const btCollisionShape& shape);

 private:
  struct Look {
    int type = -1, vertices = 0;
    btVector3 low = btVector3(0, 0, 0), high = btVector3(0, 0, 0);
    btScalar margin = 0;
  };
  struct Entry {
    Look look;
    std::unique_ptr<ShapeSurface> surface;
  };
  static Look lookOf(const btCollisionShape& shape);

  std::unordered_map<const btCollisionShape*, Entry> entries_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
