// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"

#include <limber/render/image.h>
#include <limber/render/rigid_shape.h>

#include <vector>

namespace limber::demo {

/// How the renderer shall see a soft body: its surface, or a tube for a rope, and its springs as lines.
/// Its points are the point masses; a skin is computed from them on the GPU.
render::ShapeDesc shapeOf(const SoftBody& body, const scenes::BodyLook& look);

/// Writes where they are, 3 floats each; only writes.
void writePoints(const SoftBody& body, float* xyz);

/// The rigid things, with their colours.
struct Prop {
  render::RigidShape surface;
  render::Vec3 colour;
  const btRigidBody* body = nullptr;  ///< it moves with this one; nullptr: it stands still
};
std::vector<Prop> propsOf(const scenes::Scene& scene);

/// Writes where a prop's points are, 3 floats each; only writes.
void writePoints(const Prop& prop, float* xyz);

/// White and grey squares, to be multiplied with a body's colour.
render::Image checkerTexture();

inline render::Vec3 toVec3(const Eigen::Vector3d& v) {
  const Eigen::Vector3f f = v.cast<float>();
  return {f.x(), f.y(), f.z()};
}
inline render::Vec3 toVec3(const btVector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
inline render::Vec3 toVec3(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace limber::demo
