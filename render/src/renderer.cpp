// SPDX-License-Identifier: Zlib
#include "limber/render/renderer.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "frame_passes.h"
#include "frame_uniforms.h"
#include "instance_table.h"
#include "limber/render/gl_context.h"
#include "limber/render/gl_debug_messages.h"
#include "limber/render/stream_buffer.h"
#include "naive_stream.h"
#include "render_target.h"
#include "stopwatch.h"
#include "texture_array.h"

namespace limber::render {

struct OpenFrame {
  bool open = false;
  std::uint64_t serial = 0;
  StreamPath path = StreamPath::Ring;
  float* points = nullptr;
  GLintptr byteOffset = 0;
};

// Order matters: what is destroyed last comes first.
struct Renderer::Parts {
  Parts(GlContext& context, const RendererDesc& rendererDesc);

  void layOutInstances();
  void reservePoints();
  void uploadRecords();
  void fillRingItems();
  void closeFrame();
  void submit(const Camera& camera, const Light& light, const DrawOptions& options);
  void drawPicture(const PassContext& pass, const DrawOptions& options, bool shadows);
  void requireTexture(const InstanceLook& look) const;

  Gl gl;
  RendererDesc desc;
  DebugMessages messages;
  ProgramSet programs;
  std::unique_ptr<RenderTarget> target;
  std::unique_ptr<ShadowMap> shadowMap;  // Made when the first shadow is cast.
  TextureArray textures;
  GlVertexArray emptyLayout;
  GlBuffer uniforms;
  GlBuffer records;
  GlBuffer normals;
  std::vector<GpuShape> shapes;
  std::vector<ShapeExtent> extents;
  InstanceTable instances;
  FrameLayout layout;
  bool recordsStale = true;
  std::unique_ptr<StreamBuffer> stream;
  NaiveStream naive;
  std::vector<DrawItem> items;
  OpenFrame frame;
  FrameStats stats;
  RingStats pastRings;  // Of stream buffers that were outgrown.
  std::size_t mostPoints = 0;
};

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
      desc(rendererDesc),
      messages(gl),
      programs(gl, desc.shadowTaps),
      target(std::make_unique<RenderTarget>(gl, desc.width, desc.height, desc.samples)),
      textures(gl, std::max(desc.textureSize, 1)),
      emptyLayout(makeVertexArray(gl)),
      uniforms(makeBuffer(gl, sizeof(FrameUniforms), nullptr, GL_DYNAMIC_STORAGE_BIT)),
      stream(makeStream(gl, desc.initialPoints, desc.fenceTimeout)),
      naive(gl),
      mostPoints(pointsPerBlock(gl)) {
  requireTaps(desc.shadowTaps);
  // Rows then come top down, as PNG and video want them.
  gl.ClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
  gl.Enable(GL_FRAMEBUFFER_SRGB);
  checkGlErrors(gl, "making the renderer");
}

void Renderer::Parts::requireTexture(const InstanceLook& look) const {
  if (look.texture.index != UINT32_MAX && look.texture.index >= textures.count()) {
    throw std::runtime_error("there is no texture with this id");
  }
}

void Renderer::Parts::layOutInstances() {
  if (!instances.changed()) {
    return;
  }
  instances.layOut(extents, layout);
  recordsStale = true;
}

void Renderer::Parts::reservePoints() {
  if (layout.pointCount > mostPoints) {
    throw std::runtime_error("one frame has " + std::to_string(layout.pointCount) +
                             " points, but this driver can bind " + std::to_string(mostPoints));
  }
  if (normals.bytes() < 3 * sizeof(float) * layout.normalCount) {
    normals = makeBuffer(gl, 3 * sizeof(float) * (layout.normalCount + layout.normalCount / 2), nullptr);
  }
  if (stream->floatsPerFrame() >= 3 * layout.pointCount) {
    return;
  }
  // The old buffer may still be read, so it must not go before its fences have passed.
  stream->drain();
  auto larger =
      makeStream(gl, std::min(layout.pointCount + layout.pointCount / 2, mostPoints), desc.fenceTimeout);
  pastRings.waits += stream->counters().waits;
  pastRings.stalls += stream->counters().stalls;
  ++pastRings.growths;
  stream = std::move(larger);
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
    items.push_back({&shapes[group.shape], group.firstInstance, group.instanceCount, group.firstPoint,
                     group.firstNormal, stream->name(), frame.byteOffset, bytes});
  }
}

void Renderer::Parts::closeFrame() {
  frame.open = false;
  if (frame.path == StreamPath::Ring) {
    stream->endFrame(stats.bytesStreamed);
  }
}

void Renderer::Parts::submit(const Camera& camera, const Light& light, const DrawOptions& options) {
  Stopwatch watch;
  stats.bytesStreamed = 3 * sizeof(float) * layout.pointCount;
  stats.shapeDrawCalls = stats.drawCalls = stats.dispatches = 0;
  uploadRecords();
  if (frame.path == StreamPath::Ring) {
    fillRingItems();
  } else {
    naive.upload(layout, shapes, items);
  }
  const FrameUniforms values =
      makeFrameUniforms(camera, light, options, {target->width(), target->height(), desc.shadowMapSize});
  gl.NamedBufferSubData(uniforms.name(), 0, sizeof values, &values);
  stats.uploadMs = watch.lap();
  drawPicture({gl, programs, stats, items, emptyLayout.name()}, options, light.shadows);
  stats.submitMs = watch.lap();
}

void Renderer::Parts::drawPicture(const PassContext& pass, const DrawOptions& options, bool shadows) {
  gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, uniforms.name());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kNormals, normals.name());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kInstances, records.name());
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
  gl.BindTextureUnit(1, castsShadows ? shadowMap->texture() : 0);
  drawSurfaces(pass, options.mode, castsShadows);
  if (options.mode == DrawMode::Wireframe) {
    drawLines(pass);
  }
  drawBackdrop(pass);
  if (options.mode == DrawMode::Wireframe && options.legend) {
    drawLegend(pass);
  }
  target->resolve();
}

Renderer::Renderer(GlContext& context, const RendererDesc& desc)
    : parts_(std::make_unique<Parts>(context, desc)) {}

Renderer::~Renderer() = default;

void Renderer::resize(int width, int height) {
  if (parts_->frame.open) {
    throw std::logic_error("resize() while a frame is open");
  }
  parts_->target = std::make_unique<RenderTarget>(parts_->gl, width, height, parts_->desc.samples);
}

int Renderer::width() const {
  return parts_->target->width();
}
int Renderer::height() const {
  return parts_->target->height();
}

ShapeId Renderer::addShape(const ShapeDesc& desc) {
  GpuShape shape = makeGpuShape(parts_->gl, desc);
  parts_->extents.push_back({shape.pointCount, shape.needsNormals()});
  parts_->shapes.push_back(std::move(shape));
  return {static_cast<std::uint32_t>(parts_->shapes.size() - 1)};
}

TextureId Renderer::addTexture(int width, int height, const std::uint8_t* rgba) {
  return {parts_->textures.add(width, height, rgba)};
}

InstanceId Renderer::addInstance(ShapeId shape, const InstanceLook& look) {
  if (shape.index >= parts_->shapes.size()) {
    throw std::runtime_error("addInstance: there is no shape with this id");
  }
  parts_->requireTexture(look);
  return parts_->instances.add(shape, look);
}

void Renderer::setLook(InstanceId instance, const InstanceLook& look) {
  parts_->requireTexture(look);
  parts_->instances.setLook(instance, look);
}

void Renderer::removeInstance(InstanceId instance) {
  parts_->instances.remove(instance);
}

std::size_t Renderer::instanceCount() const {
  return parts_->instances.size();
}

FrameWriter Renderer::beginFrame(StreamPath path) {
  Parts& parts = *parts_;
  if (parts.frame.open) {
    throw std::logic_error("beginFrame() while a frame is open; draw or destroy it first");
  }
  Stopwatch watch;
  parts.layOutInstances();
  parts.reservePoints();
  OpenFrame frame{true, parts.frame.serial + 1, path, nullptr, 0};
  if (path == StreamPath::Ring) {
    const StreamFrame region = parts.stream->beginFrame();
    frame.points = region.data;
    frame.byteOffset = region.byteOffset;
  } else {
    frame.points = parts.naive.begin(parts.layout);
  }
  parts.frame = frame;
  parts.stats.waitMs = watch.lap();
  return {*this, frame.serial};
}

void Renderer::draw(FrameWriter& frame, const Camera& camera, const Light& light,
                    const DrawOptions& options) {
  if (frame.renderer_ != this || !parts_->frame.open || parts_->frame.serial != frame.serial_) {
    throw std::logic_error("draw() of a frame that is not open in this renderer");
  }
  try {
    parts_->submit(camera, light, options);
  } catch (...) {
    // Some commands may already read the region, so it needs its fence all the same.
    parts_->closeFrame();
    throw;
  }
  parts_->closeFrame();
}

Image Renderer::readPixels() {
  Image image;
  readPixels(image);
  return image;
}

void Renderer::readPixels(Image& image) {
  Stopwatch watch;
  parts_->gl.Finish();
  parts_->stats.finishMs = watch.lap();
  parts_->target->read(image);
  parts_->stats.readMs = watch.lap();
}

std::vector<float> Renderer::readNormals(InstanceId instance) {
  const Parts& parts = *parts_;
  const FrameLayout::Place* place = parts.layout.find(instance);
  if (place == nullptr || !parts.shapes[parts.instances.shapeOf(instance)].needsNormals()) {
    throw std::runtime_error("readNormals: the instance was not in the last frame or is not smooth");
  }
  std::vector<float> values(3 * std::size_t{place->pointCount});
  parts.gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  parts.gl.GetNamedBufferSubData(parts.normals.name(),
                                 static_cast<GLintptr>(3 * sizeof(float) * place->firstNormal),
                                 static_cast<GLsizeiptr>(values.size() * sizeof(float)), values.data());
  return values;
}

const FrameStats& Renderer::lastFrame() const {
  return parts_->stats;
}

RingStats Renderer::ringStats() const {
  RingStats sum = parts_->pastRings;
  sum.waits += parts_->stream->counters().waits;
  sum.stalls += parts_->stream->counters().stalls;
  return sum;
}

GpuMemory Renderer::gpuMemory() const {
  const Parts& parts = *parts_;
  GpuMemory memory;
  memory.stream = parts.stream->bytes();
  for (const GpuShape& shape : parts.shapes) {
    memory.shapes += shape.bytes();
  }
  memory.scratch =
      parts.normals.bytes() + parts.records.bytes() + parts.uniforms.bytes() + parts.naive.bytes();
  memory.textures = parts.textures.bytes();
  memory.targets = parts.target->bytes() + (parts.shadowMap == nullptr ? 0 : parts.shadowMap->bytes());
  return memory;
}

const DebugMessages& Renderer::debugMessages() const {
  return parts_->messages;
}
const Gl& Renderer::gl() const {
  return parts_->gl;
}

FrameWriter::FrameWriter(FrameWriter&& other) noexcept
    : renderer_(std::exchange(other.renderer_, nullptr)), serial_(other.serial_) {}

FrameWriter::~FrameWriter() {
  if (renderer_ == nullptr) {
    return;
  }
  Renderer::Parts& parts = *renderer_->parts_;
  if (!parts.frame.open || parts.frame.serial != serial_) {
    return;
  }
  parts.frame.open = false;
  if (parts.frame.path == StreamPath::Ring) {
    parts.stream->cancelFrame();
  }
}

float* FrameWriter::points(InstanceId instance) const {
  const Renderer::Parts& parts = *renderer_->parts_;
  if (!parts.frame.open || parts.frame.serial != serial_) {
    throw std::logic_error("points() of a frame that was already drawn");
  }
  const FrameLayout::Place* place = parts.layout.find(instance);
  if (place == nullptr) {
    throw std::runtime_error(
        "points(): this instance is not part of the frame; it was removed, or added after "
        "beginFrame()");
  }
  return parts.frame.points + 3 * std::size_t{place->firstPoint};
}

}  // namespace limber::render
