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
/// each a frame. Left out: objects without contact response (ghosts), those flagged
/// CF_DISABLE_VISUALIZE_OBJECT, and what soft bodies are made of. Boxes share a shape, and so do spheres;
/// others share theirs if they share their btCollisionShape, whose dimensions must not change but by scaling
/// before the next update(). Renderer and world must outlive it. Thread rule: that of SoftView.
class RigidView {
 public:
  using Look = std::function<render::InstanceLook(const btCollisionObject&)>;

  /// `look` is asked once for each object. Default: light grey for what stands, wood for what moves.
  RigidView(render::Renderer& renderer, const btDiscreteDynamicsWorld& world, Look look = {});
  /// Takes its instances and shapes out of the renderer.
  ~RigidView();
  RigidView(const RigidView&) = delete;
  RigidView& operator=(const RigidView&) = delete;

  /// Takes in objects that have come and drops those that have gone: before Renderer::beginFrame().
  void update();
  /// Writes where all are at a time between the last two ticks, see SoftBodySystem::tickFraction(). `tick` is
  /// the length of a tick in seconds.
  void write(const render::FrameWriter& frame, double tickFraction = 1.0, double tick = 1.0 / 60.0) const;

  std::size_t objectCount() const { return shown_.size(); }

 private:
  /// What tells that a shape is another, though it lies where an old one lay in memory.
  struct Kind {
    const btCollisionShape* shape;
    int type;
    btVector3 low, high;
    bool operator==(const Kind& other) const;
  };
  struct Surface {
    Kind kind;
    render::ShapeId id;
    float reach;
    std::size_t users;
  };
  struct Shown {
    render::InstanceId instance;
    std::size_t surface;
    bool present;
  };

  static Kind kindOf(const btCollisionShape& shape);
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
