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

/// Returns the shape of a soft body for the renderer: its surface (with the skin if it has one), or a tube
/// for a rope. All springs but the bending ones are lines with their rest lengths. The points are the point
/// masses in their order, as SoftBody::writePositions() writes them. Bodies with the same network, scale and
/// point radius may share a shape. Surfaces are two-sided, because the inside of an open surface is visible,
/// and that of a body that is turned inside out, too.
render::ShapeDesc shapeOf(const SoftBody& body, render::Shading shading);

struct SoftLook {
  render::InstanceLook instance;
  render::Shading shading = render::Shading::Smooth;
  bool hideBackFaces = false;  ///< See render::ShapeDesc.
  /// Smooth shading has sharp edges where the body at rest bends by more than this, radians. See
  /// render::sharpenEdges(). Default, 0: none; the shape's corners are shaded as round.
  float sharpAngle = 0.0f;
};

/// Returns the shape with all of a look, but for what each instance has of its own.
render::ShapeDesc shapeOf(const SoftBody& body, const SoftLook& look);

/// Shows the soft bodies of a system. Bodies of one network, scale and point radius share a shape and are
/// drawn together. Renderer and system must outlive it. Thread rule: use it on the renderer's thread, and not
/// while the world is stepped.
class SoftView {
 public:
  using Look = std::function<SoftLook(const SoftBody&)>;

  /// `look` is called once for each body, and in updateLooks().
  SoftView(render::Renderer& renderer, const SoftBodySystem& system, Look look = {});
  /// Removes its instances and shapes from the renderer.
  ~SoftView();
  SoftView(const SoftView&) = delete;
  SoftView& operator=(const SoftView&) = delete;

  /// Adds new bodies and drops removed ones. Call it before Renderer::beginFrame().
  void update();
  /// Asks for the colours and textures of all bodies again. They change at the next beginFrame().
  void updateLooks();
  /// Writes all points straight into the memory that the GPU reads, see SoftBody::writePositions().
  void write(const render::FrameWriter& frame, double tickFraction = 1.0) const;

  /// Number of points streamed in a frame.
  std::size_t pointCount() const;

 private:
  struct Shape {
    SharedNetwork network;  // keeps the network alive, so that its address stays unique
    Eigen::Vector3d scale;
    double radius;
    render::Shading shading;
    bool hideBackFaces;
    float sharpAngle;
    render::ShapeId id;
    std::size_t users;
  };
  struct Shown {
    render::InstanceId instance;
    std::size_t shape;
    Handle<SoftBody> body;
    bool present;
  };

  Shown show(SoftBody& body);
  std::size_t shapeFor(const SoftBody& body, const SoftLook& look);
  bool hasShapeOf(const Shown& shown, const SoftBody& body) const;
  void hide(const Shown& shown);

  render::Renderer& renderer_;
  const SoftBodySystem& system_;
  Look look_;
  std::vector<Shape> shapes_;
  std::unordered_map<const SoftBody*, Shown> shown_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view
