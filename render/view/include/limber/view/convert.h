// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/rigid_shape.h>
#include <limber/render/vec3.h>

#include <LinearMath/btTransform.h>

namespace limber::view {

inline render::Vec3 toVec3(const btVector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

/// With the unit vectors stretched by `size`.
inline render::Frame toFrame(const btTransform& place, const btVector3& size = btVector3(1, 1, 1)) {
  const btMatrix3x3& turn = place.getBasis();
  return {toVec3(place.getOrigin()), toVec3(turn.getColumn(0) * size.x()),
          toVec3(turn.getColumn(1) * size.y()), toVec3(turn.getColumn(2) * size.z())};
}

}  // namespace limber::view
