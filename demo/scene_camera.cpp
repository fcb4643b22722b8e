// SPDX-License-Identifier: Zlib
#include "scene_camera.h"

#include "scene_looks.h"

namespace limber::demo {
namespace {

constexpr double kFullTurn = 6.283185307179586;

}  // namespace

render::Camera cameraAt(const scenes::View& view, const DemoOptions& options, double share) {
  const float aspect = static_cast<float>(options.width) / static_cast<float>(options.height);
  const render::Vec3 low = toVec3(view.box.min()), high = toVec3(view.box.max());
  const render::Vec3 direction = toVec3(view.direction);
  if (options.camera.path == CameraPath::Orbit)
    return render::orbitBox(low, high, direction, aspect, static_cast<float>(kFullTurn * share));
  render::Camera camera = render::frameBox(low, high, direction, aspect);
  if (options.camera.path == CameraPath::Fixed) {
    camera.eye = toVec3(options.camera.eye);
    camera.target = toVec3(options.camera.target);
  }
  return camera;
}

render::Light lightOf(const scenes::View& view) {
  render::Light light;
  light.towards = {-0.35f, 0.85f, 0.45f};
  return render::lightBox(toVec3(view.box.min()), toVec3(view.box.max()), light);
}

}  // namespace limber::demo
