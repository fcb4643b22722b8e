// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet_soft/bullet_twin.h"
#include "scene_renderer.h"

#include <limber/render/renderer.h>
#include <limber/view/rigid_view.h>

#include <vector>

namespace limber::demo {

/// Shows a BulletTwin with a renderer of its own, as SceneView shows a scene; both must outlive it. Of a Shot
/// it has camera, mode, shadows, marks and the time.
class TwinView {
 public:
  TwinView(const bullet_soft::BulletTwin& twin, render::Renderer& renderer, render::TextureId checker);
  ~TwinView();
  TwinView(const TwinView&) = delete;
  TwinView& operator=(const TwinView&) = delete;

  void draw(const Shot& shot);

 private:
  void addBodies(render::TextureId checker);

  const bullet_soft::BulletTwin& twin_;
  render::Renderer& renderer_;
  view::RigidView rigidBodies_;
  FloorView floor_;
  std::vector<render::ShapeId> shapes_;        // #bodies
  std::vector<render::InstanceId> instances_;  // #bodies
};

}  // namespace limber::demo
