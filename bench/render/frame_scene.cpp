// SPDX-License-Identifier: Zlib
#include "render/frame_scene.h"

#include <cmath>

namespace limber::bench {
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

}  // namespace limber::bench
