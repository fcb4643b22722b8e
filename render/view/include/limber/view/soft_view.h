// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/renderer.h>
#include <limber/render/shape_desc.h>
#include <limber/soft_body.h>
#include <limber/soft_body_system.h>

#include <functional>
#include <unordered_map>
#include <vector>

namespace limber::view {

inline namespace LIMBER_BULLET_PRECISION {

/// How a renderer sees a soft body: its surface, skinned if it has a skin, a tube for a rope, and its springs
/// but the bending ones as lines with their rest lengths. Its points are the point masses, in their order:
/// SoftBody::writePositions() writes them. Bodies with the same network, scale and point radius may share it.
/// Surfaces are two-sided, for an open one shows its inside, and so does a body that is turned inside out.
render::ShapeDesc shapeOf(const SoftBody& body, render::Shading shading);

}  // namespace LIMBER_BULLET_PRECISION

inline namespace LIMBER_BULLET_PRECISION {

struct SoftLook {
  render::InstanceLook instance;
  render::Shading shading = render::Shading::Smooth;
};

/// Shows the soft bodies of a system. Bodies of one network, scale and point radius share a shape and are
/// drawn together. Renderer and system must outlive it. Thread rule: the thread of the renderer, and no step
/// of the world meanwhile.
class SoftView {
 public:
  using Look = std::function<SoftLook(const SoftBody&)>;

  /// `look` is asked once for each body.
  SoftView(render::Renderer& renderer, const SoftBodySystem& system, Look look = {});
  /// Takes its instances and shapes out of the renderer.
  ~SoftView();
  SoftView(const SoftView&) = delete;
  SoftView& operator=(const SoftView&) = delete;

  /// Takes in bodies that have come and drops those that have gone: before Renderer::beginFrame().
  void update();
  /// Writes all points, see SoftBody::writePositions(): straight into the memory that the GPU reads.
  void write(const render::FrameWriter& frame, double tickFraction = 1.0) const;

  /// Points streamed in a frame.
  std::size_t pointCount() const;

 private:
  struct Shape {
    SharedNetwork network;  // held, so that its address means it for as long as the shape lives
    Eigen::Vector3d scale;
    double radius;
    render::Shading shading;
    render::ShapeId id;
    std::size_t users;
  };
  struct Shown {
    render::InstanceId instance;
    std::size_t shape;
    bool present;
  };

  Shown show(const SoftBody& body);
  std::size_t shapeFor(const SoftBody& body, render::Shading shading);
  bool isStill(const Shown& shown, const SoftBody& body) const;
  void hide(const Shown& shown);

  render::Renderer& renderer_;
  const SoftBodySystem& system_;
  Look look_;
  std::vector<Shape> shapes_;
  std::unordered_map<const SoftBody*, Shown> shown_;
};

}  // namespace LIMBER_BULLET_PRECISION

}  // namespace limber::view
