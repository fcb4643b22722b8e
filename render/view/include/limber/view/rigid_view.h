// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/render/renderer.h>

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {

/// Shows the rigid bodies and other collision objects of a world as shaded surfaces (shape_mesh.h), 48 bytes
/// each a frame. It leaves out objects without contact response (ghosts), objects with the flag
/// CF_DISABLE_VISUALIZE_OBJECT, and the points and surfaces of soft bodies. All boxes share one shape, and so
/// do all spheres. Other objects share a shape if they share their btCollisionShape; its dimensions may
/// change only by scaling, before the next update(). Renderer and world must outlive it. Thread rule: that of
/// SoftView.
class RigidView {
 public:
  using Look = std::function<render::InstanceLook(const btCollisionObject&)>;

  /// `look` is called once for each object. Default: light grey for static and kinematic objects, the colour
  /// of wood for dynamic ones.
  RigidView(render::Renderer& renderer, const btDiscreteDynamicsWorld& world, Look look = {});
  /// Removes its instances and shapes from the renderer.
  ~RigidView();
  RigidView(const RigidView&) = delete;
  RigidView& operator=(const RigidView&) = delete;

  /// Adds new objects and drops removed ones. Call it before Renderer::beginFrame().
  void update();
  /// Writes the transforms of all objects at a time between the last two ticks, see
  /// SoftBodySystem::tickFraction(). `tick` is the length of a tick, s.
  void write(const render::FrameWriter& frame, double tickFraction = 1.0, double tick = 1.0 / 60.0) const;

  std::size_t objectCount() const { return shown_.size(); }

 private:
  /// Identifies a collision shape. The address alone is not enough: a new shape may have the address of an
  /// old one.
  struct ShapeKey {
    const btCollisionShape* shape;
    int type;
    btVector3 low, high;
    bool operator==(const ShapeKey& other) const;
  };
  struct Surface {
    ShapeKey key;
    render::ShapeId id;
    float reach;
    std::size_t users;
  };
  struct Shown {
    render::InstanceId instance;
    std::size_t surface;
    int number;
    bool present;
  };

  static ShapeKey keyOf(const btCollisionShape& shape);
  std::optional<std::size_t> surfaceFor(const btCollisionShape& shape);
  bool show(const btCollisionObject& object, Shown& shown);
  void hide(const Shown& shown);

  render::Renderer& renderer_;
  const btDiscreteDynamicsWorld& world_;
  Look look_;
  std::vector<Surface> surfaces_;
  std::unordered_map<const btCollisionObject*, Shown> shown_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view
