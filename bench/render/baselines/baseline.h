// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/renderer.h>

#include <cstddef>
#include <memory>

namespace limber::bench {

/// Another way of drawing the instances of a renderer, to compare the renderer's own way with. The picture,
/// its size and the figures of the frame are those of the renderer: see its readPixels() and lastFrame().
///
/// Use it while no frame of the renderer is open, and destroy it before the renderer. Shapes must not be
/// removed while it exists.
class Baseline {
 public:
  virtual ~Baseline() = default;
  Baseline() = default;
  Baseline(const Baseline&) = delete;
  Baseline& operator=(const Baseline&) = delete;

  /// Opens a frame with all instances that the renderer has now.
  virtual void beginFrame() = 0;
  /// Memory for the points of an instance: 3 floats each. Valid until draw().
  virtual float* points(render::InstanceId instance) const = 0;
  virtual void draw(const render::Camera& camera, const render::Light& light,
                    const render::DrawOptions& options = {}) = 0;
  /// Bytes of its own buffers on the GPU.
  virtual std::size_t bytes() const = 0;
};

/// The simplest way to draw many bodies: positions are written to plain memory, then each instance is
/// uploaded into its own buffer and has its own draw calls. The picture equals that of the renderer byte for
/// byte.
std::unique_ptr<Baseline> makeNaivePoints(render::Renderer& renderer);

/// As Bullet's example browser draws its soft bodies. In every frame the CPU computes three vertices of 36
/// bytes with normals for each triangle. Each body has its own vertices, indices and vertex array, one
/// upload, and one draw call for each pass. It does less work than that browser, which sets seven attributes
/// and some uniforms for each draw and puts its bodies into one buffer. The picture equals that of the
/// renderer except for rounding.
///
/// beginFrame() throws std::runtime_error for tubes and skins, draw() for wireframe.
std::unique_ptr<Baseline> makeUnsharedBodies(render::Renderer& renderer);

}  // namespace limber::bench
