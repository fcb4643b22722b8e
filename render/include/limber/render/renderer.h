// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/camera.h"
#include "limber/render/image.h"
#include "limber/render/legend.h"
#include "limber/render/light.h"
#include "limber/render/overlay.h"
#include "limber/render/shape_desc.h"
#include "limber/render/vec3.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace limber::render {

class GlContext;
class DebugMessages;
class Renderer;
struct Gl;

struct ShapeId {
  std::uint32_t index = UINT32_MAX;
  std::uint32_t generation = 0;  ///< See InstanceId.
};
struct TextureId {
  std::uint32_t index = UINT32_MAX;  ///< The default is "no texture".
};
struct InstanceId {
  std::uint32_t index = UINT32_MAX;
  std::uint32_t generation = 0;  ///< Makes the id of a removed instance invalid for ever.
};

/// How a surface reflects light. Visible in Quality::Gallery only.
struct Material {
  float roughness = 0.5f;     ///< 0 (a mirror) to 1 (chalk); below 0.05 as 0.05.
  float metalness = 0.0f;     ///< 0, or 1: reflections have the surface's colour.
  float translucency = 0.0f;  ///< Metres inside the body after which a third of the sun's light is left.
  float threads = 0.0f;       ///< Of a weave, per unit of uv; 0: no cloth.

  static Material rubber() { return {0.55f, 0.0f, 0.0f, 0.0f}; }
  static Material jelly(float translucency) { return {0.12f, 0.0f, translucency, 0.0f}; }
  static Material cloth(float threads) { return {0.95f, 0.0f, 0.0f, threads}; }
  static Material metal() { return {0.28f, 1.0f, 0.0f, 0.0f}; }
};

/// Colour, texture and material of one instance of a shape.
struct InstanceLook {
  Vec3 colour{0.85f, 0.47f, 0.32f};  ///< sRGB, 0 to 1; multiplies the texture if there is one.
  TextureId texture;
  Material material{};
};

enum class Quality {
  Fast,  ///< For live use.
  /// Ambient occlusion, shadows that widen with distance, materials, a wall that meets the floor at the
  /// horizon, tones like those of film. For pictures: several times the time, see bench/README.md.
  Gallery
};

/// The processor that computes skins, normals and the side vectors of tubes in every frame. Both give the
/// same positions and normals up to rounding.
enum class ComputeOn {
  Auto,  ///< The CPU if the driver is a software rasteriser, else the GPU; see Renderer::computesOnCpu().
  Gpu,   ///< Compute shaders. Only points are streamed.
  Cpu    ///< draw() writes the results into the streamed memory, behind the points: 12 bytes for each place
         ///< of a skin and for each normal. A software rasteriser's compute shaders are several times slower.
};

struct RendererDesc {
  int width = 1280;
  int height = 720;
  int samples = 1;           ///< Multisampling; 1 is off.
  int shadowMapSize = 2048;  ///< Texels per side.
  int shadowTaps = 4;        ///< 1 or 4 filtered look-ups per pixel.
  Quality quality = Quality::Fast;
  int textureSize = 512;             ///< Every texture is resampled to a square of this many texels.
  std::size_t initialPoints = 4096;  ///< Capacity in points per frame before the buffer first grows.
  std::chrono::nanoseconds fenceTimeout = std::chrono::seconds(5);
  ComputeOn computeOn = ComputeOn::Auto;
  int computeThreads = 0;  ///< On the CPU, at most; they work in draw() only. 0: one per core, up to 4.
};

enum class DrawMode {
  Shaded,
  Wireframe  ///< Shapes with lines are drawn as lines, coloured by strain; others stay shaded.
};

struct DrawOptions {
  DrawMode mode = DrawMode::Shaded;
  float strainRange = 0.1f;     ///< Strain (length / rest - 1) drawn in full blue (-) or red (+); > 0.
  float lineWidth = 1.6f;       ///< Pixels.
  float hiddenOverlay = 0.25f;  ///< Opacity of overlay lines behind surfaces; 0: not drawn.
  bool legend = true;           ///< A bar of the strain colours, in wireframe mode only.
  std::vector<Legend> legends;  ///< Further legends, above that one.
  Vec3 backgroundTop{0.87f, 0.90f, 0.93f};     ///< sRGB.
  Vec3 backgroundBottom{0.97f, 0.96f, 0.94f};  ///< sRGB.
};

/// Figures of the last frame; times are milliseconds of this thread.
struct FrameStats {
  std::size_t bytesStreamed = 0;   ///< Points; with ComputeOn::Cpu also places of skins and normals.
  std::size_t shapeDrawCalls = 0;  ///< Draws of shapes, all passes together.
  std::size_t drawCalls = 0;       ///< The same with background, overlay and legends.
  std::size_t dispatches = 0;      ///< Compute dispatches (skins, normals, tube frames).
  double waitMs = 0.0;     ///< In beginFrame: until the memory is laid out and the GPU has finished with it.
  double computeMs = 0.0;  ///< In draw: skins and normals on the CPU.
  double uploadMs = 0.0;   ///< In draw: instance table, uniforms and overlay.
  double submitMs = 0.0;   ///< In draw: the rest.
  double finishMs = 0.0;   ///< In readPixels: waiting for the picture.
  double readMs = 0.0;     ///< In readPixels: copying it.
};

/// Figures since the renderer was made.
struct RingStats {
  std::uint64_t waits = 0;    ///< Times a region was still in flight when it was needed.
  std::uint64_t stalls = 0;   ///< Of these, how often the GPU had not yet finished with it.
  std::uint64_t growths = 0;  ///< Times the buffer was replaced by a larger one.
};

/// Bytes of GPU memory the renderer owns, by use.
struct GpuMemory {
  std::size_t stream = 0;    ///< The three regions of positions; with ComputeOn::Cpu also of normals.
  std::size_t shapes = 0;    ///< Static data of the shapes; the weights of skins only with ComputeOn::Gpu.
  std::size_t scratch = 0;   ///< Skinned points, normals, instance table, uniforms, overlay.
  std::size_t textures = 0;  ///< Textures of instances.
  std::size_t targets = 0;   ///< Colour, depth and shadow map.
  std::size_t buffers() const { return stream + shapes + scratch; }
  std::size_t total() const { return buffers() + textures + targets; }
};

/// One frame being written. Move-only; a frame destroyed without being drawn is cancelled.
/// It refers to its renderer and must not outlive it.
class FrameWriter {
 public:
  FrameWriter(FrameWriter&& other) noexcept;
  FrameWriter& operator=(FrameWriter&&) = delete;
  ~FrameWriter();

  /// Returns the memory for the points of an instance: 3 x pointCount floats (x y z, metres), packed. The GPU
  /// reads this memory, and its old content is undefined: write all of it in every frame before draw(), and
  /// do not read it. Several threads may write different instances. Throws std::runtime_error for an instance
  /// that was removed, or added after beginFrame().
  float* points(InstanceId instance) const;

 private:
  friend class Renderer;
  FrameWriter(Renderer& renderer, std::uint64_t serial) : renderer_(&renderer), serial_(serial) {}

  Renderer* renderer_;
  std::uint64_t serial_;
};

/// Draws many deforming bodies of few shapes into a picture of its own (never a window).
///
/// Errors: std::runtime_error with the reason for bad input or a failing driver, and
/// std::logic_error for calls in a wrong order (two open frames, ...). After an exception the
/// renderer is as it was before the call.
///
/// The context may belong to the program, see adoptContext(): the renderer then restores all OpenGL state
/// after use, and pauses transform feedback. Do not call it under conditional rendering, which it cannot see,
/// and call glGetError() before it: it clears older errors. blitTo() copies the picture into a framebuffer of
/// the program.
///
/// Threads: all calls on the thread on which the context is current. The context must outlive the
/// renderer and be current when it is destroyed.
class Renderer {
 public:
  Renderer(GlContext& context, const RendererDesc& desc = {});
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Sizes are 1 to 16384 or what the driver allows. Not while a frame is open.
  void resize(int width, int height);
  int width() const;
  int height() const;

  /// Uploads the shared data of a shape.
  ShapeId addShape(const ShapeDesc& desc);
  /// Frees a shape; it must have no instances. An open frame is drawn with it.
  void removeShape(ShapeId shape);
  /// `rgba`: 4 x width x height bytes, sRGB, top row first. The texture repeats, has mipmaps and exists as
  /// long as the renderer.
  TextureId addTexture(int width, int height, const std::uint8_t* rgba);

  /// These three take effect at the next beginFrame(), also while a frame is open or in flight.
  InstanceId addInstance(ShapeId shape, const InstanceLook& look = {});
  void setLook(InstanceId instance, const InstanceLook& look);
  void removeInstance(InstanceId instance);
  std::size_t instanceCount() const;

  /// Opens a frame. Waits for the GPU only if three frames are in flight, or if the buffer has
  /// to grow because of added instances.
  FrameWriter beginFrame();
  /// Submits the picture and closes the frame; returns without waiting for the GPU. Bad input leaves the
  /// frame open, other errors cancel it. `overlay` is drawn over the shapes and read before the call returns.
  void draw(FrameWriter& frame, const Camera& camera, const Light& light, const DrawOptions& options = {},
            const Overlay& overlay = {});

  /// Waits for the last picture and returns it; before the first draw(), and after resize(), its content is
  /// undefined. The second form reuses the image's memory.
  Image readPixels();
  void readPixels(Image& image);

  /// Copies the last picture into a framebuffer of the same context (0 is the window's), upright where y
  /// counts from the bottom, and scales it to `width` x `height` pixels. Does not wait.
  void blitTo(unsigned framebuffer, int x, int y, int width, int height);
  /// The last picture as an OpenGL texture (GL_TEXTURE_2D, sRGB, top row first), until the next resize().
  unsigned texture() const;

  Quality quality() const;
  /// Returns where skins and normals are computed, see ComputeOn.
  bool computesOnCpu() const;

  const FrameStats& lastFrame() const;
  RingStats ringStats() const;
  GpuMemory gpuMemory() const;
  /// All buffers, without textures and render targets.
  std::size_t gpuBufferBytes() const { return gpuMemory().buffers(); }

  /// Null in a shared context: its owner receives the messages.
  const DebugMessages* debugMessages() const;
  const Gl& gl() const;

 private:
  friend class FrameWriter;
  friend struct RendererAccess;  // src/renderer_parts.h
  struct Parts;

  std::unique_ptr<Parts> parts_;
};

}  // namespace limber::render
