// SPDX-License-Identifier: Zlib
#include "render/skin_cost.h"

#include "clocks.h"
#include "csv_table.h"
#include "sample_stats.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace limber::bench {
namespace {

constexpr float kRadius = 2.0f;  // m

template <class Value>
Value required(Result<Value> result) {
  if (!result) throw std::runtime_error(result.error());
  return std::move(*result);
}

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
  return required(buildNetwork(meshOf(render::makeUvSphere({}, kRadius, 8, 14)), settings));
}

Eigen::Matrix3Xf restOf(const SpringNetwork& network) {
  Eigen::Matrix3Xf rest(3, static_cast<Eigen::Index>(network.restPoints.size()));
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    rest.col(i) = network.restPoints[static_cast<std::size_t>(i)].cast<float>();
  return rest;
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
  scene.rest = restOf(network);
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

/// Who computes the places: the renderer on the GPU or on the CPU, or the program, which streams them.
enum class SkinWay { Gpu, Cpu, Streamed };
constexpr std::array<const char*, 3> kWayNames{"gpu", "cpu", "streamed"};

/// One way of showing the bodies, frame after frame.
class SkinStage {
 public:
  SkinStage(SkinWay way, const FrameScene& skinned, const Skin& skin, const DrawContext& context)
      : way_(way),
        skinned_(skinned),
        skin_(skin),
        drawn_(way == SkinWay::Streamed ? streamedScene(skinned, skin) : skinned),
        stage_({&drawn_, 1280, 720, false,
                way == SkinWay::Gpu ? render::ComputeOn::Gpu : render::ComputeOn::Cpu},
               drawPaths()[0], context) {
    stage_.addBodies(skinned.bodies());
  }

  FrameTimes play(int frame) {
    pose(skinned_, frame, points_);
    if (way_ != SkinWay::Streamed) return stage_.play(points_);
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

  const char* name() const { return kWayNames[static_cast<std::size_t>(way_)]; }
  std::size_t bytes() const { return stage_.lastFrame().bytesStreamed; }
  std::size_t bufferBytes() const { return stage_.bufferBytes(); }

 private:
  void applyToAll() {
    const auto perBody = static_cast<Eigen::Index>(skin_.size());
    places_.resize(3, perBody * skinned_.centres.cols());
    for (Eigen::Index b = 0; b < skinned_.centres.cols(); ++b)
      applySkin(skin_, points_.col(b * skinned_.rest.cols()).data(), places_.col(b * perBody).data());
  }

  SkinWay way_;
  const FrameScene& skinned_;
  const Skin& skin_;
  FrameScene drawn_;
  FrameStage stage_;
  Eigen::Matrix3Xf points_, places_;
};

FrameTimes medians(const std::vector<FrameTimes>& all) {
  const auto of = [&](double FrameTimes::*member) {
    std::vector<double> values;
    for (const FrameTimes& times : all) values.push_back(times.*member);
    return median(values);
  };
  return {of(&FrameTimes::upload), of(&FrameTimes::submit), of(&FrameTimes::finish), of(&FrameTimes::read),
          of(&FrameTimes::frame),  of(&FrameTimes::own),    of(&FrameTimes::process)};
}

std::vector<SkinCostRow> measureWeights(const char* name, const FrameScene& scene, const Skin& skin,
                                        const DrawContext& context, const SkinLimits& limits) {
  std::array<SkinStage, 3> stages{SkinStage(SkinWay::Gpu, scene, skin, context),
                                  SkinStage(SkinWay::Cpu, scene, skin, context),
                                  SkinStage(SkinWay::Streamed, scene, skin, context)};
  std::array<std::vector<FrameTimes>, 3> samples;
  for (SkinStage& stage : stages) stage.play(0);  // compiles shaders
  for (int block = 0; block < limits.blocks; ++block)
    for (std::size_t way = 0; way < stages.size(); ++way)
      for (int i = 0; i < limits.framesPerBlock; ++i)
        samples[way].push_back(stages[way].play(block * limits.framesPerBlock + i));
  std::vector<SkinCostRow> rows;
  for (std::size_t way = 0; way < stages.size(); ++way)
    rows.push_back({name, stages[way].name(), scene.bodies(), skin.size(), scene.shape.pointCount,
                    skin.weights.size(), medians(samples[way]), stages[way].bytes(),
                    stages[way].bufferBytes()});
  return rows;
}

}  // namespace

std::vector<SkinCostRow> measureSkinCost(const DrawContext& context, const SkinLimits& limits,
                                         RowProgress& progress) {
  const SharedNetwork coarse = coarseNetwork();
  std::vector<SkinCostRow> all;
  for (const SkinnedBodies& bodies : limits.cases) {
    const TriangleMesh mesh = meshOf(render::makeUvSphere({}, kRadius, bodies.rings, bodies.segments));
    FrameScene plain = makeBallScene(true);
    arrange(plain, bodies.count);
    for (const SkinKind kind : {SkinKind::Dense, SkinKind::Sparse}) {
      const char* name = kind == SkinKind::Dense ? "dense" : "sparse";
      SkinSettings settings;
      settings.kind = kind;
      const SharedNetwork network = required(withSkin(*coarse, mesh, settings));
      const FrameScene scene = skinnedScene(plain, *network);
      for (SkinCostRow& row : measureWeights(name, scene, network->render.skin, context, limits))
        all.push_back(std::move(row));
      progress.finish(std::to_string(bodies.count) + " with skins, " + name + " weights");
    }
  }
  return all;
}

std::vector<std::string> skinColumns() {
  return {"weights",      "way",       "bodies",     "vertices",        "points",
          "weight_count", "upload_ms", "submit_ms",  "finish_ms",       "read_ms",
          "frame_ms",     "own_ms",    "process_ms", "bytes_per_frame", "buffer_mb"};
}

std::vector<std::string> skinCells(const SkinCostRow& r) {
  return {r.weights,
          r.way,
          countCell(r.bodies),
          countCell(r.vertices),
          countCell(r.points),
          countCell(r.weightCount),
          numberCell(r.times.upload),
          numberCell(r.times.submit),
          numberCell(r.times.finish),
          numberCell(r.times.read),
          numberCell(r.times.frame),
          numberCell(r.times.own),
          numberCell(r.times.process),
          countCell(r.bytes),
          numberCell(1e-6 * static_cast<double>(r.bufferBytes))};
}

}  // namespace limber::bench
