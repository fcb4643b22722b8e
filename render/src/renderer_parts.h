// SPDX-License-Identifier: Zlib
#pragma once

#include "baseline_streams.h"
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
#include <vector>

namespace limber::render {

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
  StreamPath path = StreamPath::Ring;
  float* points = nullptr;
  GLintptr byteOffset = 0;
};

// The order matters: members are destroyed from the last to the first.
struct Renderer::Parts {
  Parts(GlContext& context, const RendererDesc& rendererDesc);

  void layOutInstances();
  void reservePoints(StreamPath path);
  void reserveComputed(GlBuffer& buffer, std::size_t count);
  void openFrame(StreamPath path);
  void uploadRecords();
  void fillRingItems();
  void fillItems();
  void closeFrame();
  void submit(const Camera& camera, const Light& light, const DrawOptions& options, const Overlay& overlay);
  void drawLegends(const PassContext& pass, const DrawOptions& options);
  void drawPicture(const PassContext& pass, const DrawOptions& options, bool shadows);
  void requireTexture(const InstanceLook& look) const;
  std::vector<float> readComputed(const GlBuffer& buffer, std::uint32_t first, InstanceId instance) const;

  Gl gl;
  bool sharedContext;
  RendererDesc desc;
  std::unique_ptr<DebugMessages> messages;  // Null in a shared context.
  ProgramSet programs;
  std::unique_ptr<RenderTarget> target;
  std::unique_ptr<ShadowMap> shadowMap;  // Created with the first shadow.
  TextureArray textures;
  GlVertexArray emptyLayout;
  GlBuffer uniforms;
  GlBuffer records;
  GlBuffer places;  // Of skins.
  GlBuffer normals;
  ShapeTable shapes;
  InstanceTable instances;
  FrameLayout layout;
  bool recordsStale = true;
  std::unique_ptr<StreamBuffer> stream;
  NaiveStream naive;
  UnsharedStream unshared;
  OverlayLines overlayLines;
  OverlayLines numbers;  // Of legends.
  Overlay strokes;       // Memory for their strokes.
  std::vector<DrawItem> items;
  OpenFrame frame;
  FrameStats stats;
  RingStats pastRings;  // Of stream buffers that were replaced by larger ones.
  std::size_t maxPoints = 0;
};

}  // namespace limber::render
