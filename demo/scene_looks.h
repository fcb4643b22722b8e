// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"

#include <limber/render/image.h>
#include <limber/render/renderer.h>
#include <limber/view/rigid_view.h>
#include <limber/view/soft_view.h>

namespace limber::demo {

inline render::Vec3 toVec3(const Eigen::Vector3d& v) {
  const Eigen::Vector3f f = v.cast<float>();
  return {f.x(), f.y(), f.z()};
}
inline render::Vec3 toVec3(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

/// What the scene says of its bodies' looks; `checker` is for those that want one. The scene must outlive it.
view::SoftView::Look softLooks(const scenes::Scene& scene, render::TextureId checker);
view::RigidView::Look rigidLooks(const scenes::Scene& scene);

/// White and grey squares, to be multiplied with a body's colour.
render::Image checkerTexture();

}  // namespace limber::demo
