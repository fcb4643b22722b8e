// SPDX-License-Identifier: Zlib
#include "render/frame_stage.h"

#include "clocks.h"

#include <limber/render/gl_functions.h>

#include <algorithm>

namespace limber::bench {
namespace {

render::RendererDesc rendererDesc(const FrameCase& frameCase, const DrawPath& path) {
  render::RendererDesc desc;
  desc.width = frameCase.width;
  desc.height = frameCase.height;
  desc.computeOn = path.makeBaseline ? render::ComputeOn::Gpu : frameCase.computeOn;
  // baselines need no ring, which is then as small as can be
  desc.initialPoints = path.makeBaseline ? 1 : frameCase.scene->points();
  return desc;
}

float aspectOf(const FrameCase& frameCase) {
  return static_cast<float>(frameCase.width) / static_cast<float>(frameCase.height);
}

std::unique_ptr<render::GlContext> makeContext(const DrawContext& context) {
  render::ContextDesc desc;
  desc.backend = context.backend;
  return render::createContext(desc);
}

render::InstanceLook lookOf(std::size_t body) {
  const auto shade = [body](std::size_t factor) {
    return 0.35f + 0.05f * static_cast<float>(body * factor % 11);
  };
  return {{shade(3), shade(5), shade(7)}, {}};
}

}  // namespace

const std::vector<DrawPath>& drawPaths() {
  static const std::vector<DrawPath> kPaths = {{"limber", nullptr, true},
                                               {"naive_points", makeNaivePoints, true},
                                               {"naive", makeUnsharedBodies, false}};
  return kPaths;
}

const std::vector<DrawContext>& drawContexts() {
  static const std::vector<DrawContext> kContexts = {{"osmesa", render::Backend::OSMesa},
                                                     {"egl", render::Backend::Egl}};
  return kContexts;
}

FrameStage::FrameStage(const FrameCase& frameCase, const DrawPath& path, const DrawContext& context)
    : scene_(*frameCase.scene),
      path_(path),
      drawContext_(context),
      camera_(scene_.camera(aspectOf(frameCase))),
      light_(scene_.light(frameCase.shadows)),
      context_(makeContext(context)),
      renderer_(std::make_unique<render::Renderer>(*context_, rendererDesc(frameCase, path))) {
  floor_ = renderer_->addInstance(renderer_->addShape(scene_.floor.shape), {{0.93f, 0.92f, 0.90f}, {}});
  shape_ = renderer_->addShape(scene_.shape);
  if (path.makeBaseline) baseline_ = path.makeBaseline(*renderer_);
}
FrameStage::~FrameStage() {
  context_->makeCurrent();  // for the renderer to go
}

void FrameStage::addBodies(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    bodies_.push_back(renderer_->addInstance(shape_, lookOf(bodies_.size())));
}

template <class Frame>
void FrameStage::write(const Frame& frame, const Eigen::Matrix3Xf& points) const {
  std::copy(scene_.floor.points.begin(), scene_.floor.points.end(), frame.points(floor_));
  const Eigen::Index count = scene_.rest.cols();
  const float* next = points.data();
  for (const render::InstanceId body : bodies_) {
    std::copy(next, next + 3 * count, frame.points(body));
    next += 3 * count;
  }
}

/// The time at which all points were written, ms; so does the next.
double FrameStage::drawItself(const Eigen::Matrix3Xf& points, const Stopwatch& watch) {
  render::FrameWriter frame = renderer_->beginFrame();
  write(frame, points);
  const double written = watch.time().wallMs;
  renderer_->draw(frame, camera_, light_);
  return written;
}

double FrameStage::drawBaseline(const Eigen::Matrix3Xf& points, const Stopwatch& watch) {
  baseline_->beginFrame();
  write(*baseline_, points);
  const double written = watch.time().wallMs;
  baseline_->draw(camera_, light_);
  return written;
}

FrameTimes FrameStage::play(const Eigen::Matrix3Xf& points) {
  context_->makeCurrent();
  const Stopwatch watch;
  const double processStart = processCpuMs();
  const double written = baseline_ ? drawBaseline(points, watch) : drawItself(points, watch);
  const double own = watch.time().cpuMs;
  renderer_->readPixels(image_);
  const render::FrameStats& stats = renderer_->lastFrame();
  return {written + stats.computeMs + stats.uploadMs,
          stats.submitMs,
          stats.finishMs,
          stats.readMs,
          watch.time().wallMs,
          own,
          processCpuMs() - processStart};
}

std::size_t FrameStage::bufferBytes() const {
  const render::GpuMemory memory = renderer_->gpuMemory();
  const std::size_t ofRenderer = path_.usesShapes ? memory.buffers() : memory.scratch;
  return ofRenderer + (baseline_ ? baseline_->bytes() : 0);
}

std::string FrameStage::driver() const { return render::describeDriver(renderer_->gl()); }

}  // namespace limber::bench
