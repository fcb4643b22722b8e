// SPDX-License-Identifier: Zlib
#pragma once

#include "cpu_passes.h"
#include "frame_passes.h"
#include "gl_state.h"
#include "gpu_shape.h"
#include "gpu_textures.h"
#include "instance_table.h"
#include "limber/render/gl_debug_messages.h"
#include "limber/render/renderer.h"
#include "limber/render/stream_buffer.h"
#include "overlay_lines.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace limber::render {

/// Computes skins, normals and side vectors of tubes on the CPU. With a software rasteriser this is several
/// times faster than its compute shaders, which run on the same processor.
class CpuPasses {
 public:
  explicit CpuPasses(unsigned threads) : threads_(threads) {}

  /// The number of points, places and normals of a frame. They follow one another in this order.
  static std::size_t streamedPoints(const FrameLayout& layout);
  static std::uint32_t firstPlace(const FrameLayout& layout);
  static std::uint32_t firstNormal(const FrameLayout& layout);

  /// `stream` has streamedPoints() x 3 floats. Reads the points and writes the rest.
  void compute(const FrameLayout& layout, const ShapeTable& shapes, float* stream);

 private:
  RowThreads threads_;
  std::vector<Lanes> lanes_;  // These two are scratch memory.
  std::vector<Vec3> sums_;
};

/// Milliseconds since construction or since the last call of lap().
class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

struct OpenFrame {
  bool open = false;
  std::uint64_t serial = 0;
  float* points = nullptr;
  GLintptr byteOffset = 0;
};

// The order matters: members are destroyed from the last to the first.
struct Renderer::Parts {
  Parts(GlContext& context, const RendererDesc& rendererDesc);

  // Beginning of a frame.
  void layOutInstances();
  // Buffers for skins and normals if the GPU computes them. Throws if there are more points than the driver
  // can bind.
  void reserveComputed();
  void reserveComputed(GlBuffer& buffer, std::size_t count);
  void reserveRing();
  std::size_t streamedPoints() const;
  void openFrame();
  void closeFrame();
  void cancelFrame();

  // Drawing. The picture is that of `items`.
  void submit(const Camera& camera, const Light& light, const DrawOptions& options, const Overlay& overlay);
  void fillItems();
  // All of a frame: `first` is that of the first instance.
  PointRange pointRange() const;
  PointRange placeRange() const;
  PointRange normalRange() const;
  void uploadRecords();
  void uploadFrameData(const Camera& camera, const Light& light, const DrawOptions& options,
                       const Overlay& overlay);
  void bindFrameData();
  void drawPicture(const DrawOptions& options, bool shadows);
  void beginTarget(bool castsShadows);
  void finishTarget(const DrawOptions& options);  // All that is drawn after the shapes.
  void drawLegends(const DrawOptions& options);

  bool gallery() const { return desc.quality == Quality::Gallery; }
  PassContext pass() { return {gl, programs, stats, items, gallery(), emptyLayout.name()}; }
  const ShadowMap& requireShadowMap();
  void requireLook(const InstanceLook& look) const;

  Gl gl;
  bool sharedContext;
  RendererDesc desc;
  std::unique_ptr<DebugMessages> messages;  // Null in a shared context.
  std::optional<CpuPasses> cpu;             // If skins and normals are computed on the CPU.
  ProgramSet programs;
  std::unique_ptr<RenderTarget> target;
  std::unique_ptr<ShadowMap> shadowMap;   // Created with the first shadow.
  std::unique_ptr<OpennessMap> openness;  // Of the gallery, made for the size of the target.
  TextureArray textures;
  GlVertexArray emptyLayout;
  GlBuffer uniforms;
  GlBuffer records;
  GlBuffer places;  // Of skins. These two are empty if the CPU computes.
  GlBuffer normals;
  ShapeTable shapes;
  InstanceTable instances;
  FrameLayout layout;
  bool recordsStale = true;
  std::unique_ptr<StreamBuffer> stream;
  OverlayLines overlayLines;
  OverlayLines numbers;  // Of legends.
  Overlay strokes;       // Memory for their strokes.
  std::vector<DrawItem> items;
  OpenFrame frame;
  FrameStats stats;
  RingStats pastRings;  // Of stream buffers that were replaced by larger ones.
  std::size_t maxPoints = 0;
};

/// The parts of a renderer, for code outside the library that includes this private header.
struct RendererAccess {
  using Parts = Renderer::Parts;

  static Parts& parts(Renderer& renderer) { return *renderer.parts_; }
};

}  // namespace limber::render
