// SPDX-License-Identifier: Zlib
#include "render/frames.h"

#include "timing.h"

#include <limber/render/gl_functions.h>

#include <algorithm>
#include <cmath>

namespace limber::bench {

// --- scenes ---

namespace {

constexpr float kSpacing = 1.6f;       // m, of cubes 1 m wide
constexpr float kMiddleHeight = 0.8f;  // m, of their middles
constexpr float kBallRadius = 2.0f, kBallHeight = 2.4f;

constexpr float kSwell = 0.08f;     // of the distance from the middle
constexpr float kWavesPerM = 6.0f;  // radians per metre of height
constexpr float kPhasePerFrame = 0.2f, kPhasePerBody = 0.7f;

render::Vec3 toVec3(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

FrameScene makeScene(std::string name, render::Scenery body, Eigen::Matrix3Xf centres) {
  FrameScene scene;
  scene.name = std::move(name);
  scene.rest = Eigen::Map<const Eigen::Matrix3Xf>(body.points.data(), 3, body.shape.pointCount);
  scene.shape = std::move(body.shape);
  scene.centres = std::move(centres);
  const float reach = scene.centres.row(0).cwiseAbs().maxCoeff() + 8.0f * kSpacing;
  scene.floor = render::makeFloor({}, 1.5f * reach);
  return scene;
}

}  // namespace

std::size_t FrameScene::points() const { return bodies() * shape.pointCount + floor.shape.pointCount; }

std::size_t FrameScene::triangles() const {
  return (bodies() * shape.triangles.size() + floor.shape.triangles.size()) / 3;
}

Eigen::AlignedBox3f FrameScene::box() const {
  const float radius = (1.0f + kSwell) * rest.colwise().norm().maxCoeff();
  Eigen::AlignedBox3f box(centres.rowwise().minCoeff(), centres.rowwise().maxCoeff());
  box.min().array() -= radius;
  box.max().array() += radius;
  return box;
}

render::Camera FrameScene::camera(float aspect) const {
  return render::frameBox(toVec3(box().min()), toVec3(box().max()), {0.4f, 0.55f, 1.0f}, aspect);
}

render::Light FrameScene::light(bool shadows) const {
  render::Light light = render::lightBox(toVec3(box().min()), toVec3(box().max()));
  light.shadows = shadows;
  return light;
}

FrameScene makeCubeScene(std::size_t count) {
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  const float middle = 0.5f * static_cast<float>(columns - 1);
  Eigen::Matrix3Xf centres(3, static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const float column = static_cast<float>(i % columns), row = static_cast<float>(i / columns);
    centres.col(static_cast<Eigen::Index>(i)) << kSpacing * (column - middle), kMiddleHeight,
        kSpacing * (row - middle);
  }
  return makeScene("cubes", render::makeBox({}, {0.5f, 0.5f, 0.5f}), std::move(centres));
}

FrameScene makeBallScene(bool tenth) {
  // 2 (rings - 1) segments triangles
  const std::uint32_t rings = tenth ? 51 : 126, segments = tenth ? 100 : 400;
  return makeScene("ball", render::makeUvSphere({}, kBallRadius, rings, segments),
                   Eigen::Vector3f(0.0f, kBallHeight, 0.0f));
}

void pose(const FrameScene& scene, int frame, Eigen::Matrix3Xf& points) {
  const Eigen::Index count = scene.rest.cols();
  points.resize(3, count * scene.centres.cols());
  for (Eigen::Index b = 0; b < scene.centres.cols(); ++b) {
    const float phase = kPhasePerFrame * static_cast<float>(frame) + kPhasePerBody * static_cast<float>(b);
    const auto wave = (kWavesPerM * scene.rest.row(1).array() + phase).sin();
    points.middleCols(b * count, count) =
        (scene.rest * (1.0f + kSwell * wave).matrix().asDiagonal()).colwise() + scene.centres.col(b);
  }
}

// --- paths and stages ---

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

render::InstanceLook lookOf(std::size_t body) {
  const auto shade = [body](std::size_t factor) {
    return 0.35f + 0.05f * static_cast<float>(body * factor % 11);
  };
  return {{shade(3), shade(5), shade(7)}, {}};
}

}  // namespace

const std::vector<DrawPath>& drawPaths() {
  static const std::vector<DrawPath> kPaths = {{"Limber", nullptr, true},
                                               {"points body by body", makeNaivePoints, true},
                                               {"vertices body by body", makeUnsharedBodies, false}};
  return kPaths;
}

std::unique_ptr<render::GlContext> makeContext(const DrawContext& context) {
  render::ContextDesc desc;
  desc.backend = context.backend;
  return render::createContext(desc);
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

FrameTimes FrameStage::play(const Eigen::Matrix3Xf& points) {
  context_->makeCurrent();
  const Stopwatch watch;
  const double processStart = processCpuMs();
  double written = 0.0;  // ms
  if (baseline_) {
    baseline_->beginFrame();
    write(*baseline_, points);
    written = watch.time().wallMs;
    baseline_->draw(camera_, light_);
  } else {
    render::FrameWriter frame = renderer_->beginFrame();
    write(frame, points);
    written = watch.time().wallMs;
    renderer_->draw(frame, camera_, light_);
  }
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

void addTimes(const Subject& subject, const std::vector<FrameTimes>& samples, Results& results) {
  const std::pair<const char*, double FrameTimes::*> parts[] = {
      {"upload", &FrameTimes::upload},
      {"submit", &FrameTimes::submit},
      {"finish", &FrameTimes::finish},
      {"read", &FrameTimes::read},
      {"frame", &FrameTimes::frame},
      {"upload and submit, own time", &FrameTimes::own},
      {"frame, all threads", &FrameTimes::process}};
  for (const auto& [name, part] : parts) {
    std::vector<double> values;
    for (const FrameTimes& times : samples) values.push_back(times.*part);
    results.add(subject, name, "ms", values);
  }
}

}  // namespace limber::bench
