// SPDX-License-Identifier: Zlib
#include "scene_renderer.h"

#include "scene_camera.h"
#include "scene_looks.h"
#include "scenes/timeline.h"

namespace limber::demo {
namespace {

const render::Vec3 kFloorColour{0.78f, 0.79f, 0.82f};

render::RendererDesc rendererDesc(const scenes::Scene& scene, const DemoOptions& options) {
  render::RendererDesc desc;
  desc.width = options.width;
  desc.height = options.height;
  desc.samples = 4;
  desc.initialPoints = scenes::pointCount(scene) + 1024;  // and the rigid bodies
  return desc;
}

render::TextureId addTexture(render::Renderer& renderer, const render::Image& image) {
  return renderer.addTexture(image.width, image.height, image.rgba.data());
}

/// What hangs or rests in these scenes is strained by some per cent.
constexpr float kStrainRange = 0.03f;

render::DrawOptions drawOptions(const DemoOptions& options) {
  render::DrawOptions draw;
  if (options.mode == PictureMode::Wireframe) draw.mode = render::DrawMode::Wireframe;
  draw.strainRange = kStrainRange;
  if (options.overlay.velocities) draw.legends = {view::speedLegend(kVelocityArrows)};
  return draw;
}

}  // namespace

SceneRenderer::SceneRenderer(const scenes::Scene& scene, const DemoOptions& options)
    : scene_(scene),
      options_(options),
      context_(render::createContext(options.context)),
      renderer_(*context_, rendererDesc(scene, options)),
      checker_(addTexture(renderer_, checkerTexture())),
      softBodies_(renderer_, *scene.soft, softLooks(scene, checker_)),
      rigidBodies_(renderer_, scene.world->dynamics, rigidLooks(scene)),
      floor_(addFloor()),
      overlay_(scene, options.overlay) {}

render::InstanceId SceneRenderer::addFloor() {
  const render::Vec3 middle{0.0f, static_cast<float>(scene_.floor.height), 0.0f};
  const float halfSize = static_cast<float>(scene_.floor.halfSize);
  const render::RigidShape floor = render::makeRigid(render::makeFloor(middle, halfSize));
  floorReach_ = floor.reach;
  return renderer_.addInstance(renderer_.addShape(floor.shape), {kFloorColour, {}});
}

void SceneRenderer::draw(const Moment& moment, render::Image& image) {
  softBodies_.update();
  rigidBodies_.update();
  render::FrameWriter frame = renderer_.beginFrame();
  render::writeFrame(floorReach_, {}, frame.points(floor_));
  softBodies_.write(frame, moment.tickFraction);
  rigidBodies_.write(frame, moment.tickFraction, 1.0 / static_cast<double>(scenes::kTicksPerSecond));
  const render::Camera camera = cameraAt(scene_.view, options_, moment.share);
  renderer_.draw(frame, camera, lightOf(scene_.view), drawOptions(options_), overlay_.draw(camera.eye));
  renderer_.readPixels(image);
}

std::string SceneRenderer::driver() const { return render::describeDriver(renderer_.gl()); }

}  // namespace limber::demo
