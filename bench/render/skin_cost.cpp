// SPDX-License-Identifier: Zlib
#include "render/skin_cost.h"

#include "clocks.h"
#include "csv_table.h"
#include "sample_stats.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <array>
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
  scene.shape.pointCount = static_cast<std::uint32_t>(skinned.shape.skin.skinnedPointCount());
  scene.rest.resize(3, static_cast<Eigen::Index>(scene.shape.pointCount));
  applySkin(skin, skinned.rest.data(), scene.rest.data());
  return scene;
}

/// One way of showing the body, frame after frame.
class SkinStage {
 public:
  SkinStage(const FrameScene& skinned, const Skin* cpuSkin, const DrawContext& context)
      : skinned_(skinned),
        drawn_(cpuSkin ? streamedScene(skinned, *cpuSkin) : skinned),
        cpuSkin_(cpuSkin),
        stage_({&drawn_, 1280, 720, false}, drawPaths()[0], context),
        places_(3, static_cast<Eigen::Index>(skinned.shape.skin.skinnedPointCount())) {
    stage_.addBodies(1);
  }

  FrameTimes play(int frame) {
    pose(skinned_, frame, points_);
    if (!cpuSkin_) return stage_.play(points_);
    const Stopwatch watch;
    applySkin(*cpuSkin_, points_.data(), places_.data());
    const WorkTime skinning = watch.time();
    FrameTimes times = stage_.play(places_);
    times.upload += skinning.wallMs;
    times.frame += skinning.wallMs;
    times.own += skinning.cpuMs;
    times.process += skinning.cpuMs;
    return times;
  }

  std::size_t bytes() const { return 12 * drawn_.points(); }
  std::size_t bufferBytes() const { return stage_.bufferBytes(); }

 private:
  const FrameScene& skinned_;
  FrameScene drawn_;
  const Skin* cpuSkin_;
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
  std::array<SkinStage, 2> stages{SkinStage(scene, nullptr, context), SkinStage(scene, &skin, context)};
  std::array<std::vector<FrameTimes>, 2> samples;
  for (SkinStage& stage : stages) stage.play(0);  // compiles shaders
  for (int block = 0; block < limits.blocks; ++block)
    for (std::size_t way = 0; way < 2; ++way)
      for (int i = 0; i < limits.framesPerBlock; ++i)
        samples[way].push_back(stages[way].play(block * limits.framesPerBlock + i));
  std::vector<SkinCostRow> rows;
  for (std::size_t way = 0; way < 2; ++way)
    rows.push_back({name, way == 0 ? "gpu" : "cpu", skin.size(), scene.shape.pointCount, skin.weights.size(),
                    medians(samples[way]), stages[way].bytes(), stages[way].bufferBytes()});
  return rows;
}

}  // namespace

std::vector<SkinCostRow> measureSkinCost(const DrawContext& context, const SkinLimits& limits,
                                         RowProgress& progress) {
  const render::Scenery body = render::makeUvSphere({}, kRadius, limits.rings, limits.segments);
  const TriangleMesh mesh = meshOf(body);
  const SharedNetwork coarse = coarseNetwork();
  const FrameScene plain = makeBallScene(true);
  std::vector<SkinCostRow> all;
  for (const SkinKind kind : {SkinKind::Dense, SkinKind::Sparse}) {
    const char* name = kind == SkinKind::Dense ? "dense" : "sparse";
    SkinSettings settings;
    settings.kind = kind;
    const SharedNetwork network = required(withSkin(*coarse, mesh, settings));
    const FrameScene scene = skinnedScene(plain, *network);
    for (SkinCostRow& row : measureWeights(name, scene, network->render.skin, context, limits))
      all.push_back(std::move(row));
    progress.finish(std::string("skin, ") + name + " weights");
  }
  return all;
}

std::vector<std::string> skinColumns() {
  return {"weights",   "way",     "vertices", "points", "weight_count", "upload_ms",       "submit_ms",
          "finish_ms", "read_ms", "frame_ms", "own_ms", "process_ms",   "bytes_per_frame", "buffer_mb"};
}

std::vector<std::string> skinCells(const SkinCostRow& r) {
  return {r.weights,
          r.way,
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
