// SPDX-License-Identifier: Zlib
#include "window/twin_view.h"

namespace limber::demo {

TwinView::TwinView(const bullet_soft::BulletTwin& twin, render::Renderer& renderer, render::TextureId checker)
    : twin_(twin),
      renderer_(renderer),
      rigidBodies_(renderer, twin.world(), rigidLooks(twin.scene())),
      floor_(renderer, twin.scene()) {
  addBodies(checker);
}

// A node of btSoftBody is a point of Limber's body, so the shapes are those of the scene.
void TwinView::addBodies(render::TextureId checker) {
  const view::SoftView::Look looks = softLooks(twin_.scene(), checker);
  for (std::size_t b = 0; b < twin_.bodyCount(); ++b) {
    const SoftBody& body = *twin_.scene().soft->body(b);
    const view::SoftLook look = looks(body);
    shapes_.push_back(renderer_.addShape(view::shapeOf(body, look)));
    instances_.push_back(renderer_.addInstance(shapes_.back(), look.instance));
  }
}

TwinView::~TwinView() {
  for (const render::InstanceId instance : instances_) renderer_.removeInstance(instance);
  for (const render::ShapeId shape : shapes_) renderer_.removeShape(shape);
}

void TwinView::draw(const Shot& shot) {
  rigidBodies_.update();
  render::FrameWriter frame = renderer_.beginFrame();
  floor_.write(frame);
  for (std::size_t b = 0; b < instances_.size(); ++b)
    twin_.writePositions(b, frame.points(instances_[b]), shot.tickFraction);
  rigidBodies_.write(frame, shot.tickFraction, 1.0 / static_cast<double>(scenes::kTicksPerSecond));
  render::Light light = lightOf(twin_.scene().view);
  light.shadows = shot.shadows;
  renderer_.draw(frame, shot.camera, light, drawOptions(shot, renderer_.quality()), shot.marks);
}

}  // namespace limber::demo
