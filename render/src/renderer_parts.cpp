// SPDX-License-Identifier: Zlib
#include "renderer_parts.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "frame_passes.h"
#include "limber/render/gl_context.h"

namespace limber::render {
namespace {

std::size_t pointsPerBlock(const Gl& gl) {
  GLint64 bytes = 0;
  gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
  return static_cast<std::size_t>(bytes) / (3 * sizeof(float));
}

std::unique_ptr<StreamBuffer> makeStream(const Gl& gl, std::size_t points, std::chrono::nanoseconds timeout) {
  StreamBufferDesc desc;
  desc.floatsPerFrame = 3 * points;
  desc.fenceTimeout = timeout;
  return std::make_unique<StreamBuffer>(gl, desc);
}

void requireTaps(int taps) {
  if (taps != 1 && taps != 4) {
    throw std::runtime_error("shadowTaps is " + std::to_string(taps) + ", but must be 1 or 4");
  }
}

}  // namespace

Renderer::Parts::Parts(GlContext& context, const RendererDesc& rendererDesc)
    : gl(loadGl(context)),
      sharedContext(context.shared()),
      desc(rendererDesc),
      messages(sharedContext ? nullptr : std::make_unique<DebugMessages>(gl)),
      programs(gl, desc.shadowTaps),
      target(std::make_unique<RenderTarget>(gl, desc.width, desc.height, desc.samples)),
      textures(gl, std::max(desc.textureSize, 1)),
      emptyLayout(makeVertexArray(gl)),
      uniforms(makeBuffer(gl, sizeof(FrameUniforms), nullptr, GL_DYNAMIC_STORAGE_BIT)),
      stream(makeStream(gl, desc.initialPoints, desc.fenceTimeout)),
      naive(gl),
      unshared(gl),
      overlayLines(gl),
      numbers(gl),
      maxPoints(pointsPerBlock(gl)) {
  requireTaps(desc.shadowTaps);
  if (!sharedContext) {
    setRendererState(gl);
  }
  checkGlErrors(gl, "making the renderer");
}

void Renderer::Parts::requireTexture(const InstanceLook& look) const {
  if (look.texture.index != UINT32_MAX && look.texture.index >= textures.count()) {
    throw std::runtime_error("there is no texture with this id");
  }
}

std::vector<float> Renderer::Parts::readComputed(const GlBuffer& buffer, std::uint32_t first,
                                                 InstanceId instance) const {
  std::vector<float> values(std::size_t{3} * shapes[instances.shapeOf(instance)].skinnedPointCount);
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl.GetNamedBufferSubData(buffer.name(), static_cast<GLintptr>(3 * sizeof(float) * first),
                           static_cast<GLsizeiptr>(values.size() * sizeof(float)), values.data());
  return values;
}

void Renderer::Parts::layOutInstances() {
  if (!instances.changed()) {
    return;
  }
  instances.layOut(shapes.extents(), layout);
  recordsStale = true;
}

void Renderer::Parts::reservePoints(StreamPath path) {
  if (path == StreamPath::Unshared) {
    return;
  }
  if (layout.pointCount > maxPoints) {
    throw std::runtime_error("one frame has " + std::to_string(layout.pointCount) +
                             " points, but this driver can bind " + std::to_string(maxPoints));
  }
  reserveComputed(places, layout.skinnedPointCount);
  reserveComputed(normals, layout.normalCount);
  if (path != StreamPath::Ring || stream->floatsPerFrame() >= 3 * layout.pointCount) {
    return;
  }
  // The GPU may still read the old buffer, so wait for its fences first.
  stream->drain();
  auto larger =
      makeStream(gl, std::min(layout.pointCount + layout.pointCount / 2, maxPoints), desc.fenceTimeout);
  pastRings.waits += stream->counters().waits;
  pastRings.stalls += stream->counters().stalls;
  ++pastRings.growths;
  stream = std::move(larger);
}

void Renderer::Parts::reserveComputed(GlBuffer& buffer, std::size_t count) {
  if (count > maxPoints) {
    throw std::runtime_error("one frame computes " + std::to_string(count) +
                             " places or normals, but this driver can bind " + std::to_string(maxPoints));
  }
  const std::size_t bytes = 3 * sizeof(float) * count;
  if (buffer.bytes() < bytes) {
    buffer = makeBuffer(gl, std::min(bytes + bytes / 2, 3 * sizeof(float) * maxPoints), nullptr);
  }
}

void Renderer::Parts::openFrame(StreamPath path) {
  OpenFrame next{true, frame.serial + 1, path, nullptr, 0};
  if (path == StreamPath::Ring) {
    const StreamFrame region = stream->beginFrame();
    next.points = region.data;
    next.byteOffset = region.byteOffset;
  } else {
    next.points = path == StreamPath::Naive ? naive.begin(layout) : unshared.begin(layout, shapes);
  }
  frame = next;
}

void Renderer::Parts::uploadRecords() {
  if (!recordsStale || layout.records.empty()) {
    return;
  }
  const std::size_t bytes = layout.records.size() * sizeof(InstanceRecord);
  if (records.bytes() < bytes) {
    records = makeBuffer(gl, bytes + bytes / 2, nullptr, GL_DYNAMIC_STORAGE_BIT);
  }
  gl.NamedBufferSubData(records.name(), 0, static_cast<GLsizeiptr>(bytes), layout.records.data());
  recordsStale = false;
}

void Renderer::Parts::fillRingItems() {
  items.clear();
  const auto bytes = static_cast<GLsizeiptr>(3 * sizeof(float) * layout.pointCount);
  for (const InstanceGroup& group : layout.groups) {
    const GpuShape& shape = shapes[group.shape];
    const PointRange points{stream->name(), frame.byteOffset, bytes, group.firstPoint};
    const PointRange skinned{places.name(), 0, static_cast<GLsizeiptr>(places.bytes()), group.firstPlace};
    items.push_back({&shape, group.firstInstance, group.instanceCount, group.firstNormal, points,
                     shape.skinned() ? skinned : points, group.textured});
  }
}

void Renderer::Parts::fillItems() {
  stats.bytesStreamed = 3 * sizeof(float) * layout.pointCount;
  if (frame.path == StreamPath::Ring) {
    fillRingItems();
  } else if (frame.path == StreamPath::Naive) {
    naive.upload(layout, shapes, places, items);
  } else {
    unshared.upload(layout, shapes, items);
    stats.bytesStreamed = unshared.uploadedBytes();
  }
}

void Renderer::Parts::closeFrame() {
  frame.open = false;
  if (frame.path == StreamPath::Ring) {
    stream->endFrame(stats.bytesStreamed);
  }
}

void Renderer::Parts::submit(const Camera& camera, const Light& light, const DrawOptions& options,
                             const Overlay& overlay) {
  if (frame.path == StreamPath::Unshared && options.mode == DrawMode::Wireframe) {
    throw std::runtime_error("StreamPath::Unshared cannot draw lines");
  }
  Stopwatch watch;
  const GlStateGuard guard(gl, sharedContext);
  stats.shapeDrawCalls = stats.drawCalls = stats.dispatches = 0;
  uploadRecords();
  fillItems();
  const FrameUniforms values =
      makeFrameUniforms(camera, light, options, {target->width(), target->height(), desc.shadowMapSize});
  overlayLines.upload(overlay);
  gl.NamedBufferSubData(uniforms.name(), 0, sizeof values, &values);
  stats.uploadMs = watch.lap();
  drawPicture({gl, programs, stats, items, emptyLayout.name()}, options, light.shadows);
  stats.submitMs = watch.lap();
}

void Renderer::Parts::drawLegends(const PassContext& pass, const DrawOptions& options) {
  std::size_t row = 0;
  strokes.clear();
  const auto add = [&](const Legend& legend) {
    const BarRectangle bar = barRectangle(row++, target->width(), target->height());
    drawLegend(pass, legend.map, bar);
    addNumbers(strokes, legend, bar);
  };
  if (options.mode == DrawMode::Wireframe && options.legend) {
    add(strainLegend(options.strainRange));
  }
  for (const Legend& legend : options.legends) {
    add(legend);
  }
  numbers.upload(strokes);
  if (numbers.count() > 0) {
    drawStrokes(pass, numbers);
  }
}

void Renderer::Parts::drawPicture(const PassContext& pass, const DrawOptions& options, bool shadows) {
  gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, uniforms.name());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kNormals, normals.name());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kInstances, records.name());
  if (layout.skinnedPointCount > 0) {
    computePlaces(pass);
  }
  if (layout.normalCount > 0) {
    computeNormals(pass);
  }
  const bool castsShadows = shadows && !items.empty();
  if (castsShadows) {
    if (shadowMap == nullptr) {
      shadowMap = std::make_unique<ShadowMap>(gl, desc.shadowMapSize);
    }
    castShadows(pass, *shadowMap);
  }
  target->begin();
  gl.BindTextureUnit(0, textures.name());
  if (castsShadows) {
    gl.BindTextureUnit(1, shadowMap->texture());
  }
  drawSurfaces(pass, options.mode, castsShadows);
  if (options.mode == DrawMode::Wireframe) {
    drawLines(pass);
  }
  drawBackdrop(pass);
  if (overlayLines.count() > 0) {
    drawOverlay(pass, overlayLines, options.hiddenOverlay);
  }
  drawLegends(pass, options);
  target->resolve();
}

}  // namespace limber::render
