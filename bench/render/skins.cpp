// SPDX-License-Identifier: Zlib
#include "render/frames.h"
#include "timing.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace limber::bench {
namespace {

constexpr float kRadius = 2.0f;  // m

TriangleMesh meshOf(const render::Scenery& body) {
  TriangleMesh mesh;
  for (std::size_t i = 0; i < body.points.size(); i += 3)
    mesh.positions.push_back(Eigen::Map<const Eigen::Vector3f>(body.points.data() + i).cast<double>());
  const std::vector<std::uint32_t>& riding = body.shape.vertexToPoint;
  for (std::size_t t = 0; t < body.shape.triangles.size(); t += 3) {
    Triangle corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = riding[body.shape.triangles[t + k]];
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

/// A hundred points: 7 circles of 14, and the poles.
SharedNetwork coarseNetwork() {
  NetworkSettings settings;
  settings.braces = BraceRule::None;  // nothing is simulated
  return valueOf(buildNetwork(meshOf(render::makeUvSphere({}, kRadius, 8, 14)), settings));
}

/// The scene with its body's points and surface replaced by those of the network.
FrameScene skinnedScene(const FrameScene& plain, const SpringNetwork& network) {
  FrameScene scene = plain;
  scene.shape = render::ShapeDesc();
  scene.shape.name = "skinned body";
  scene.shape.shading = render::Shading::Smooth;
  scene.shape.pointCount = static_cast<std::uint32_t>(network.restPoints.size());
  const Skin& skin = network.render.skin;
  scene.shape.skin = {skin.firstWeight, skin.points, skin.weights};
  scene.shape.vertexToPoint = network.render.vertexToPoint;
  for (const Triangle& t : network.render.triangles)
    scene.shape.triangles.insert(scene.shape.triangles.end(), t.begin(), t.end());
  const double* points = network.restPoints.front().data();
  scene.rest = Eigen::Map<const Eigen::Matrix3Xd>(points, 3, scene.shape.pointCount).cast<float>();
  return scene;
}

/// The same surface for one who streams all places.
FrameScene streamedScene(const FrameScene& skinned, const Skin& skin) {
  FrameScene scene = skinned;
  scene.shape.skin = {};
  scene.shape.pointCount = static_cast<std::uint32_t>(skin.size());
  scene.rest.resize(3, static_cast<Eigen::Index>(skin.size()));
  applySkin(skin, skinned.rest.data(), scene.rest.data());
  return scene;
}

/// A square of bodies instead of the scene's one.
void arrange(FrameScene& scene, std::size_t bodies) {
  constexpr float kDistance = 2.5f * kRadius;
  const auto columns = static_cast<Eigen::Index>(std::ceil(std::sqrt(static_cast<double>(bodies))));
  const Eigen::Vector3f first = scene.centres.col(0);
  scene.centres.resize(3, static_cast<Eigen::Index>(bodies));
  for (Eigen::Index i = 0; i < scene.centres.cols(); ++i)
    scene.centres.col(i) = first + kDistance * Eigen::Vector3f(float(i % columns), 0.0f, float(i / columns));
}

/// Where vertices are computed: by the renderer on the GPU or on the CPU, or by the program, which streams
/// them.
enum class SkinMethod { Gpu, Cpu, Streamed };
const char* const kMethodNames[] = {"compute shader", "renderer on the CPU", "applySkin() and streamed"};

/// One method of showing the bodies, frame after frame.
class SkinStage {
 public:
  SkinStage(SkinMethod method, const FrameScene& skinned, const Skin& skin, const DrawContext& context)
      : method_(method),
        skinned_(skinned),
        skin_(skin),
        drawn_(method == SkinMethod::Streamed ? streamedScene(skinned, skin) : skinned),
        stage_({&drawn_, 1280, 720, false,
                method == SkinMethod::Gpu ? render::ComputeOn::Gpu : render::ComputeOn::Cpu},
               drawPaths()[0], context) {
    stage_.addBodies(skinned.bodies());
  }

  FrameTimes play(int frame) {
    pose(skinned_, frame, points_);
    if (method_ != SkinMethod::Streamed) return stage_.play(points_);
    const Stopwatch watch;
    applyToAll();
    const WorkTime skinning = watch.time();
    FrameTimes times = stage_.play(places_);
    times.upload += skinning.wallMs;
    times.frame += skinning.wallMs;
    times.own += skinning.cpuMs;
    times.process += skinning.cpuMs;
    return times;
  }

  std::size_t bytes() const { return stage_.lastFrame().bytesStreamed; }
  std::size_t bufferBytes() const { return stage_.bufferBytes(); }

 private:
  void applyToAll() {
    const auto perBody = static_cast<Eigen::Index>(skin_.size());
    places_.resize(3, perBody * skinned_.centres.cols());
    for (Eigen::Index b = 0; b < skinned_.centres.cols(); ++b)
      applySkin(skin_, points_.col(b * skinned_.rest.cols()).data(), places_.col(b * perBody).data());
  }

  SkinMethod method_;
  const FrameScene& skinned_;
  const Skin& skin_;
  FrameScene drawn_;
  FrameStage stage_;
  Eigen::Matrix3Xf points_, places_;
};

void measureWeights(const char* weights, const FrameScene& scene, const Skin& skin,
                    const DrawContext& context, const Turns& turns, Results& results) {
  std::array<SkinStage, 3> stages{SkinStage(SkinMethod::Gpu, scene, skin, context),
                                  SkinStage(SkinMethod::Cpu, scene, skin, context),
                                  SkinStage(SkinMethod::Streamed, scene, skin, context)};
  std::array<std::vector<FrameTimes>, 3> samples;
  for (SkinStage& stage : stages)
    for (int frame = 0; frame < kWarmUp; ++frame) stage.play(frame);
  for (int block = 0; block < turns.blocks; ++block)
    for (std::size_t turn = 0; turn < stages.size(); ++turn) {
      const std::size_t m = (turn + static_cast<std::size_t>(block)) % stages.size();
      for (int i = 0; i < turns.framesPerBlock; ++i) {
        const FrameTimes times = stages[m].play(block * turns.framesPerBlock + i);
        if (i > 0) samples[m].push_back(times);
      }
    }
  const std::string name =
      format("%zu bodies of %zu vertices, %s weights", scene.bodies(), skin.size(), weights);
  for (std::size_t m = 0; m < stages.size(); ++m) {
    const Subject subject{"skins", name, "Limber", kMethodNames[m]};
    results.add(subject, "bodies", "", double(scene.bodies()));
    results.add(subject, "vertices", "", double(skin.size()));
    results.add(subject, "points", "", double(scene.shape.pointCount));
    results.add(subject, "weights", "", double(skin.weights.size()));
    addTimes(subject, samples[m], results);
    results.add(subject, "sent per frame", "B", double(stages[m].bytes()));
    results.add(subject, "buffers", "B", double(stages[m].bufferBytes()));
  }
}

}  // namespace

void measureSkins(const DrawContext& context, bool quick, const Turns& turns, Results& results) {
  // bodies, and rings and segments of each: (rings - 1) x segments + 2 vertices
  const std::vector<std::array<std::uint32_t, 3>> full = {{1, 251, 400}, {9, 141, 250}},
                                                  few = {{1, 51, 100}, {2, 21, 40}};
  const SharedNetwork coarse = coarseNetwork();
  for (const auto& [count, rings, segments] : quick ? few : full) {
    const TriangleMesh mesh = meshOf(render::makeUvSphere({}, kRadius, rings, segments));
    FrameScene plain = makeBallScene(true);
    arrange(plain, count);
    for (const SkinKind kind : {SkinKind::Dense, SkinKind::Sparse}) {
      SkinSettings settings;
      settings.kind = kind;
      const SharedNetwork network = valueOf(withSkin(*coarse, mesh, settings));
      measureWeights(kind == SkinKind::Dense ? "dense" : "sparse", skinnedScene(plain, *network),
                     network->render.skin, context, turns, results);
    }
  }
}

}  // namespace limber::bench
