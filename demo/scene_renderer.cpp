// SPDX-License-Identifier: Zlib
#include "scene_renderer.h"

#include <algorithm>

namespace limber::demo {
namespace {

render::RendererDesc rendererDesc(const scenes::Scene& scene, const DemoOptions& options) {
  render::RendererDesc desc;
  desc.width = options.width;
  desc.height = options.height;
  desc.samples = 4;
  desc.initialPoints = scenes::pointCount(scene) + 1024;  // and the props
  return desc;
}

render::Camera cameraOf(const scenes::View& view, const DemoOptions& options) {
  const float aspect = static_cast<float>(options.width) / static_cast<float>(options.height);
  return render::frameBox(toVec3(view.box.min()), toVec3(view.box.max()), toVec3(view.direction), aspect);
}

render::Light lightOf(const scenes::View& view) {
  render::Light light;
  light.towards = {-0.35f, 0.85f, 0.45f};
  return render::lightBox(toVec3(view.box.min()), toVec3(view.box.max()), light);
}

}  // namespace

SceneRenderer::SceneRenderer(const scenes::Scene& scene, const DemoOptions& options)
    : scene_(scene),
      context_(render::createContext()),
      renderer_(*context_, rendererDesc(scene, options)),
      camera_(cameraOf(scene.view, options)),
      light_(lightOf(scene.view)) {
  if (options.mode == PictureMode::Wireframe) drawOptions_.mode = render::DrawMode::Wireframe;
  // what hangs or rests in these scenes is strained by some per cent
  drawOptions_.strainRange = 0.03f;
  addProps();
  addBodies();
}

render::ShapeId SceneRenderer::shapeFor(const SoftBody& body, const scenes::BodyLook& look) {
  const SpringNetwork* network = &body.network();
  const auto same = [network](const BodyShape& shape) { return shape.first == network; };
  const auto found = std::find_if(shapes_.begin(), shapes_.end(), same);
  if (found != shapes_.end()) return found->second;
  shapes_.push_back({network, renderer_.addShape(shapeOf(body, look))});
  return shapes_.back().second;
}

void SceneRenderer::addBodies() {
  const render::Image checker = checkerTexture();
  render::TextureId texture;
  for (std::size_t b = 0; b < scene_.looks.size(); ++b) {
    const scenes::BodyLook& look = scene_.looks[b];
    render::InstanceLook instance;
    instance.colour = toVec3(look.colour);
    if (look.checkered) {
      if (texture.index == UINT32_MAX) {
        texture = renderer_.addTexture(checker.width, checker.height, checker.rgba.data());
      }
      instance.texture = texture;
    }
    bodies_.push_back(renderer_.addInstance(shapeFor(*scene_.soft->body(b), look), instance));
  }
}

void SceneRenderer::addProps() {
  for (Prop& prop : propsOf(scene_)) {
    render::InstanceLook look;
    look.colour = prop.colour;
    const render::ShapeId shape = renderer_.addShape(prop.surface.shape);
    props_.push_back({renderer_.addInstance(shape, look), std::move(prop)});
  }
}

void SceneRenderer::draw(render::Image& image) {
  render::FrameWriter frame = renderer_.beginFrame();
  for (const auto& [instance, prop] : props_) writePoints(prop, frame.points(instance));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    writePoints(*scene_.soft->body(b), frame.points(bodies_[b]));
  }
  renderer_.draw(frame, camera_, light_, drawOptions_);
  renderer_.readPixels(image);
}

std::string SceneRenderer::driver() const { return render::describeDriver(renderer_.gl()); }

}  // namespace limber::demo
