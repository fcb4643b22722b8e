// SPDX-License-Identifier: Zlib
#include "renderer_parts.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <thread>

#include "frame_passes.h"
#include "limber/render/gl_context.h"
#include "limber/render/gl_functions.h"

namespace limber::render {
namespace {

constexpr unsigned kMaxThreads = 4;  // Unless the program wants more.

std::size_t pointsPerBlock(const Gl& gl) {
  GLint64 bytes = 0;
  gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
  return static_cast<std::size_t>(bytes) / (3 * sizeof(float));
}

std::unique_ptr<StreamBuffer> makeStream(const Gl& gl, std::size_t points, const RendererDesc& rendererDesc,
                                         bool readable) {
  StreamBufferDesc desc;
  desc.floatsPerFrame = 3 * points;
  desc.fenceTimeout = rendererDesc.fenceTimeout;
  desc.readable = readable;
  return std::make_unique<StreamBuffer>(gl, desc);
}

void requireTaps(int taps) {
  if (taps != 1 && taps != 4) {
    throw std::runtime_error("shadowTaps is " + std::to_string(taps) + ", but must be 1 or 4");
  }
}

/// Returns a number of texels per side that the driver can store.
int requireTexels(const Gl& gl, const char* field, int size) {
  GLint largest = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (size < 1 || size > largest) {
    throw std::runtime_error(std::string(field) + " is " + std::to_string(size) + ", but must be 1 to " +
                             std::to_string(largest));
  }
  return size;
}

unsigned computeThreads(int wanted) {
  if (wanted < 0) {
    throw std::runtime_error("computeThreads is " + std::to_string(wanted) + ", but must be 0 or more");
  }
  const unsigned cores = std::thread::hardware_concurrency();
  return wanted > 0 ? static_cast<unsigned>(wanted) : std::clamp(cores, 1u, kMaxThreads);
}

std::optional<CpuPasses> makeCpuPasses(const Gl& gl, const RendererDesc& desc) {
  const unsigned threads = computeThreads(desc.computeThreads);
  const bool isAuto = desc.computeOn == ComputeOn::Auto;
  const bool onCpu = isAuto ? isSoftwareRasteriser(gl) : desc.computeOn == ComputeOn::Cpu;
  return onCpu ? std::make_optional<CpuPasses>(threads) : std::nullopt;
}

}  // namespace

Renderer::Parts::Parts(GlContext& context, const RendererDesc& rendererDesc)
    : gl(loadGl(context)),
      sharedContext(context.shared()),
      desc(rendererDesc),
      messages(sharedContext ? nullptr : std::make_unique<DebugMessages>(gl)),
      cpu(makeCpuPasses(gl, desc)),
      programs(gl, desc.shadowTaps, desc.quality),
      target(std::make_unique<RenderTarget>(gl, desc.width, desc.height, desc.samples)),
      textures(gl, requireTexels(gl, "textureSize", desc.textureSize)),
      emptyLayout(makeVertexArray(gl)),
      uniforms(makeBuffer(gl, sizeof(FrameUniforms), nullptr, GL_DYNAMIC_STORAGE_BIT)),
      stream(makeStream(gl, desc.initialPoints, desc, cpu.has_value())),
      overlayLines(gl),
      numbers(gl),
      maxPoints(pointsPerBlock(gl)) {
  requireTaps(desc.shadowTaps);
  requireTexels(gl, "shadowMapSize", desc.shadowMapSize);
  if (!sharedContext) {
    setRendererState(gl);
  }
  checkGlErrors(gl, "making the renderer");
}

void Renderer::Parts::requireLook(const InstanceLook& look) const {
  requireFinite("look.colour", look.colour);
  const Material& material = look.material;
  for (const float value :
       {material.roughness, material.metalness, material.translucency, material.threads}) {
    requireFinite("look.material", value);
  }
  if (look.texture.index != UINT32_MAX && look.texture.index >= textures.count()) {
    throw std::runtime_error("there is no texture with this id");
  }
}

void Renderer::Parts::layOutInstances() {
  if (!instances.changed()) {
    return;
  }
  instances.layOut(shapes.extents(), layout);
  recordsStale = true;
}

void Renderer::Parts::reserveComputed() {
  if (streamedPoints() > maxPoints) {
    throw std::runtime_error("one frame has " + std::to_string(streamedPoints()) +
                             (cpu ? " points, places and normals" : " points") +
                             ", but this driver can bind " + std::to_string(maxPoints));
  }
  if (!cpu) {
    reserveComputed(places, layout.skinnedPointCount);
    reserveComputed(normals, layout.normalCount);
  }
}

std::size_t Renderer::Parts::streamedPoints() const {
  return cpu ? CpuPasses::streamedPoints(layout) : layout.pointCount;
}

void Renderer::Parts::reserveRing() {
  const std::size_t points = streamedPoints();
  if (stream->floatsPerFrame() >= 3 * points) {
    return;
  }
  // The GPU may still read the old buffer, so wait for its fences first.
  stream->drain();
  auto larger = makeStream(gl, std::min(points + points / 2, maxPoints), desc, cpu.has_value());
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

void Renderer::Parts::openFrame() {
  const StreamFrame region = stream->beginFrame();
  frame = {true, frame.serial + 1, region.data, region.byteOffset};
}

void Renderer::Parts::closeFrame() {
  frame.open = false;
  shapes.freeRemoved();
  stream->endFrame();
}

void Renderer::Parts::cancelFrame() {
  frame.open = false;
  shapes.freeRemoved();
  stream->cancelFrame();
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

PointRange Renderer::Parts::pointRange() const {
  return {stream->name(), frame.byteOffset, static_cast<GLsizeiptr>(3 * sizeof(float) * streamedPoints()), 0};
}

PointRange Renderer::Parts::placeRange() const {
  return cpu ? pointRange().from(CpuPasses::firstPlace(layout)) : wholeOf(places);
}

PointRange Renderer::Parts::normalRange() const {
  return cpu ? pointRange().from(CpuPasses::firstNormal(layout)) : wholeOf(normals);
}

void Renderer::Parts::fillItems() {
  items.clear();
  stats.bytesStreamed = 3 * sizeof(float) * streamedPoints();
  for (const InstanceGroup& group : layout.groups) {
    const GpuShape& shape = shapes[group.shape];
    const PointRange points = pointRange().from(group.firstPoint);
    items.push_back({&shape, group.firstInstance, group.instanceCount, points,
                     shape.skinned() ? placeRange().from(group.firstPlace) : points,
                     normalRange().from(group.firstNormal), group.textured});
  }
}

void Renderer::Parts::uploadFrameData(const Camera& camera, const Light& light, const DrawOptions& options,
                                      const Overlay& overlay) {
  stats.shapeDrawCalls = stats.drawCalls = stats.dispatches = 0;
  uploadRecords();
  const FrameUniforms values =
      makeFrameUniforms(camera, light, options, {target->width(), target->height(), desc.shadowMapSize});
  overlayLines.upload(overlay);
  gl.NamedBufferSubData(uniforms.name(), 0, sizeof values, &values);
}

void Renderer::Parts::submit(const Camera& camera, const Light& light, const DrawOptions& options,
                             const Overlay& overlay) {
  Stopwatch watch;
  const GlStateGuard guard(gl, sharedContext);
  if (cpu) {
    cpu->compute(layout, shapes, frame.points);
  }
  stats.computeMs = watch.lap();
  fillItems();
  uploadFrameData(camera, light, options, overlay);
  stats.uploadMs = watch.lap();
  drawPicture(options, light.shadows);
  stats.submitMs = watch.lap();
}

const ShadowMap& Renderer::Parts::requireShadowMap() {
  if (shadowMap == nullptr) {
    shadowMap = std::make_unique<ShadowMap>(gl, desc.shadowMapSize, !gallery());
  }
  return *shadowMap;
}

void Renderer::Parts::drawLegends(const DrawOptions& options) {
  std::size_t row = 0;
  strokes.clear();
  const auto add = [&](const Legend& legend) {
    const BarRectangle bar = barRectangle(row++, target->width(), target->height());
    drawLegend(pass(), legend.map, bar);
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
    drawStrokes(pass(), numbers);
  }
}

void Renderer::Parts::bindFrameData() {
  gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, uniforms.name());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kInstances, records.name());
}

void Renderer::Parts::beginTarget(bool castsShadows) {
  target->begin();
  gl.BindTextureUnit(0, textures.name());
  if (castsShadows) {
    gl.BindTextureUnit(1, shadowMap->texture());
  }
  if (openness != nullptr) {
    gl.BindTextureUnit(2, openness->texture());
  }
}

void Renderer::Parts::finishTarget(const DrawOptions& options) {
  drawBackdrop(pass());
  if (overlayLines.count() > 0) {
    drawOverlay(pass(), overlayLines, options.hiddenOverlay);
  }
  drawLegends(options);
  target->resolve();
}

void Renderer::Parts::drawPicture(const DrawOptions& options, bool shadows) {
  bindFrameData();
  if (!cpu && layout.skinnedPointCount > 0) {
    computePlaces(pass());
  }
  if (!cpu && layout.normalCount > 0) {
    computeNormals(pass());
  }
  const bool castsShadows = shadows && !items.empty();
  if (castsShadows) {
    castShadows(pass(), requireShadowMap());
  }
  if (gallery()) {
    if (openness == nullptr) {
      openness = std::make_unique<OpennessMap>(gl, target->width(), target->height());
    }
    computeOpenness(pass(), *openness, options.mode);
  }
  beginTarget(castsShadows);
  drawSurfaces(pass(), options.mode, castsShadows);
  if (options.mode == DrawMode::Wireframe) {
    drawLines(pass());
  }
  finishTarget(options);
}

// --- skins and normals on the CPU --------------------------------------------------------------------------

std::uint32_t CpuPasses::firstPlace(const FrameLayout& layout) {
  return static_cast<std::uint32_t>(layout.pointCount);
}

std::uint32_t CpuPasses::firstNormal(const FrameLayout& layout) {
  return static_cast<std::uint32_t>(layout.pointCount + layout.skinnedPointCount);
}

std::size_t CpuPasses::streamedPoints(const FrameLayout& layout) {
  return layout.pointCount + layout.skinnedPointCount + layout.normalCount;
}

void CpuPasses::compute(const FrameLayout& layout, const ShapeTable& shapes, float* stream) {
  for (const InstanceGroup& group : layout.groups) {
    const GpuShape& shape = shapes[group.shape];
    const float* points = stream + 3 * std::size_t{group.firstPoint};
    if (shape.skinned()) {
      float* places = stream + 3 * (std::size_t{firstPlace(layout)} + group.firstPlace);
      applySkin(shape.cpu.skin, {group.instanceCount, points, places}, lanes_, threads_);
      points = places;
    }
    if (!shape.needsNormals()) {
      continue;
    }
    float* normals = stream + 3 * (std::size_t{firstNormal(layout)} + group.firstNormal);
    const CpuInstances instances{group.instanceCount, points, normals};
    if (shape.tube) {
      computeTubeFrames(shape.pointCount, instances);
    } else {
      computeMeshNormals(shape.cpu.triangles, instances, sums_, threads_);
    }
  }
}

}  // namespace limber::render
