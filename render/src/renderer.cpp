// SPDX-License-Identifier: Zlib
#include "limber/render/renderer.h"

#include <stdexcept>
#include <utility>

#include "frame_passes.h"
#include "renderer_parts.h"

namespace limber::render {

Renderer::Renderer(GlContext& context, const RendererDesc& desc)
    : parts_(std::make_unique<Parts>(context, desc)) {}

Renderer::~Renderer() = default;

void Renderer::resize(int width, int height) {
  if (parts_->frame.open) {
    throw std::logic_error("resize() while a frame is open");
  }
  parts_->target = std::make_unique<RenderTarget>(parts_->gl, width, height, parts_->desc.samples);
  parts_->openness.reset();
}

int Renderer::width() const { return parts_->target->width(); }
int Renderer::height() const { return parts_->target->height(); }
Quality Renderer::quality() const { return parts_->desc.quality; }

ShapeId Renderer::addShape(const ShapeDesc& desc) {
  return parts_->shapes.add(makeGpuShape(parts_->gl, desc, parts_->cpu.has_value()));
}

void Renderer::removeShape(ShapeId shape) {
  parts_->shapes.require(shape, "removeShape");
  if (parts_->instances.uses(shape.index)) {
    throw std::runtime_error("removeShape: the shape still has instances");
  }
  parts_->shapes.remove(shape);
  if (!parts_->frame.open) {
    parts_->shapes.freeRemoved();
  }
}

TextureId Renderer::addTexture(int width, int height, const std::uint8_t* rgba) {
  const GlStateGuard guard(parts_->gl, parts_->sharedContext);
  return {parts_->textures.add(width, height, rgba)};
}

InstanceId Renderer::addInstance(ShapeId shape, const InstanceLook& look) {
  parts_->shapes.require(shape, "addInstance");
  parts_->requireLook(look);
  return parts_->instances.add(shape, look);
}

void Renderer::setLook(InstanceId instance, const InstanceLook& look) {
  parts_->requireLook(look);
  parts_->instances.setLook(instance, look);
}

void Renderer::removeInstance(InstanceId instance) { parts_->instances.remove(instance); }

std::size_t Renderer::instanceCount() const { return parts_->instances.size(); }

FrameWriter Renderer::beginFrame() {
  Parts& parts = *parts_;
  if (parts.frame.open) {
    throw std::logic_error("beginFrame() while a frame is open; draw or destroy it first");
  }
  Stopwatch watch;
  parts.layOutInstances();
  parts.reserveComputed();
  parts.reserveRing();
  parts.openFrame();
  parts.stats.waitMs = watch.lap();
  return {*this, parts.frame.serial};
}

void Renderer::draw(FrameWriter& frame, const Camera& camera, const Light& light, const DrawOptions& options,
                    const Overlay& overlay) {
  if (frame.renderer_ != this || !parts_->frame.open || parts_->frame.serial != frame.serial_) {
    throw std::logic_error("draw() of a frame that is not open in this renderer");
  }
  requireUsable(camera, light, options);
  try {
    parts_->submit(camera, light, options, overlay);
  } catch (...) {
    // Some commands may already read the region, so it needs its fence.
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
  const GlStateGuard guard(parts_->gl, parts_->sharedContext);
  parts_->target->read(image);
  parts_->stats.readMs = watch.lap();
}

void Renderer::blitTo(unsigned framebuffer, int x, int y, int width, int height) {
  const GlStateGuard guard(parts_->gl, parts_->sharedContext);
  parts_->target->blitTo(framebuffer, x, y, width, height);
}

bool Renderer::computesOnCpu() const { return parts_->cpu.has_value(); }

unsigned Renderer::texture() const { return parts_->target->texture(); }

const FrameStats& Renderer::lastFrame() const { return parts_->stats; }

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
  memory.shapes = parts.shapes.bytes();
  memory.scratch = parts.places.bytes() + parts.normals.bytes() + parts.records.bytes() +
                   parts.uniforms.bytes() + parts.overlayLines.bytes() + parts.numbers.bytes();
  memory.textures = parts.textures.bytes();
  memory.targets = parts.target->bytes() + (parts.shadowMap == nullptr ? 0 : parts.shadowMap->bytes()) +
                   (parts.openness == nullptr ? 0 : parts.openness->bytes());
  return memory;
}

const DebugMessages* Renderer::debugMessages() const { return parts_->messages.get(); }
const Gl& Renderer::gl() const { return parts_->gl; }

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
  parts.cancelFrame();
}

float* FrameWriter::points(InstanceId instance) const {
  if (renderer_ == nullptr) {
    throw std::logic_error("points() of a frame that was moved elsewhere");
  }
  const Renderer::Parts& parts = *renderer_->parts_;
  if (!parts.frame.open || parts.frame.serial != serial_) {
    throw std::logic_error("points() of a frame that was already drawn");
  }
  const FrameLayout::Slice* slice = parts.layout.find(instance);
  if (slice == nullptr) {
    throw std::runtime_error(
        "points(): this instance is not part of the frame; it was removed, or added after "
        "beginFrame()");
  }
  return parts.frame.points + 3 * std::size_t{slice->firstPoint};
}

}  // namespace limber::render
