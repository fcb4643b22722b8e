// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/rigid_shape.h>
#include <limber/render/vec3.h>

#include <LinearMath/btTransform.h>

namespace limber::view {

inline render::Vec3 toVec3(const btVector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

/// Returns the frame of a transform, with its axes scaled by `size`.
inline render::Frame toFrame(const btTransform& transform, const btVector3& size = btVector3(1, 1, 1)) {
  const btMatrix3x3& basis = transform.getBasis();
  return {toVec3(transform.getOrigin()), toVec3(basis.getColumn(0) * size.x()),
          toVec3(basis.getColumn(1) * size.y()), toVec3(basis.getColumn(2) * size.z())};
}

}  // namespace limber::view
