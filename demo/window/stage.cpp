// SPDX-License-Identifier: Zlib
#include "window/stage.h"

#include <algorithm>
#include <cstring>

namespace limber::demo {
namespace {

const render::Vec3 kPullColour{0.85f, 0.15f, 0.10f}, kPinColour{0.10f, 0.25f, 0.75f};
constexpr float kPullWidth = 3.0f;   // pixels
constexpr float kMarkShare = 0.01f;  // of the distance of the camera

/// A software rasteriser spends most of its time on pixels: those get what is cheap.
render::RendererDesc rendererDesc(const render::GlContext& context, const WindowSize& size) {
  render::RendererDesc desc;
  desc.width = size.width;
  desc.height = size.height;
  const bool software = render::isSoftwareRasteriser(render::loadGl(context));
  desc.samples = software ? 1 : 4;
  desc.shadowMapSize = software ? 1024 : 2048;
  desc.shadowTaps = software ? 1 : 4;
  return desc;
}

void addPins(render::Overlay& marks, const Session& session) {
  const float size = kMarkShare * static_cast<float>(session.camera().distance);
  const SoftBodySystem& soft = *session.scene().soft;
  for (std::size_t b = 0; b < soft.bodyCount(); ++b) {
    const SoftBody& body = *soft.body(b);
    for (std::uint32_t i = 0; i < body.pointCount(); ++i)
      if (body.pinned(i)) render::addCross(marks, toVec3(body.position(i)), size, kPinColour);
  }
}

render::Overlay marksOf(const Session& session) {
  render::Overlay marks;
  addPins(marks, session);
  const Hand& hand = session.hand();
  if (!hand.holds()) return marks;
  const render::Vec3 place = toVec3(hand.place());
  marks.push_back({toVec3(hand.held()), place, kPullColour, kPullWidth});
  const float size = kMarkShare * static_cast<float>(session.camera().distance);
  render::addCross(marks, place, size, kPullColour, kPullWidth);
  return marks;
}

Shot shotOf(const Session& session, double tickFraction) {
  Shot shot;
  shot.camera = session.camera().camera();
  shot.tickFraction = tickFraction;
  shot.mode = session.shows(Layer::Strain) ? PictureMode::Wireframe : PictureMode::Shaded;
  shot.overlay.contacts = session.shows(Layer::Contacts);
  shot.overlay.boxes = session.shows(Layer::Boxes);
  shot.overlay.velocities = session.shows(Layer::Velocities);
  shot.overlay.constraints = session.shows(Layer::Constraints);
  shot.overlay.islands = session.shows(Layer::Islands);
  shot.shadows = session.shows(Layer::Shadows);
  shot.marks = marksOf(session);
  return shot;
}

}  // namespace

Stage::Stage(std::function<void*(const char*)> getProcAddress, const WindowSize& size)
    : context_(render::adoptContext(std::move(getProcAddress), "the window's")),
      renderer_(std::make_unique<render::Renderer>(*context_, rendererDesc(*context_, size))),
      checker_(addCheckerTexture(*renderer_)) {}

void Stage::draw(const Session& session, double tickFraction, const WindowSize& size) {
  if (sceneNumber_ != session.sceneNumber()) {
    view_.reset();
    view_.emplace(session.scene(), *renderer_, checker_);
    sceneNumber_ = session.sceneNumber();
  }
  if (renderer_->width() != size.width || renderer_->height() != size.height)
    renderer_->resize(size.width, size.height);
  view_->draw(shotOf(session, tickFraction));
  renderer_->blitTo(0, 0, 0, size.width, size.height);
}

render::Image Stage::readWindow(const WindowSize& size) const {
  render::Image upsideDown, image;
  upsideDown.resize(size.width, size.height);
  image.resize(size.width, size.height);
  renderer_->gl().ReadPixels(0, 0, size.width, size.height, GL_RGBA, GL_UNSIGNED_BYTE,
                             upsideDown.rgba.data());
  for (int y = 0; y < size.height; ++y)
    std::memcpy(image.pixel(0, y), upsideDown.pixel(0, size.height - 1 - y),
                4u * static_cast<std::size_t>(size.width));
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
  return image;
}

}  // namespace limber::demo
