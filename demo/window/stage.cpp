// SPDX-License-Identifier: Zlib
// Draws a session: its scene, and beside it the same with btSoftBody.

#include "window/stage.h"

#include <algorithm>
#include <cstring>

namespace limber::demo {

// --- the view of btSoftBody --------------------------------------------------------------------------------

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
  renderer_.draw(frame, shot.camera, shot.light, drawOptions(shot, renderer_.quality()), shot.marks);
}

// --- the stage ---------------------------------------------------------------------------------------------

namespace {

const render::Vec3 kPullColour{0.85f, 0.15f, 0.10f}, kPinColour{0.10f, 0.25f, 0.75f};
constexpr float kPullWidth = 3.0f;   // pixels
constexpr float kMarkShare = 0.01f;  // of the distance of the camera

/// A software rasteriser spends most of its time on pixels: those get what is cheap.
render::RendererDesc rendererDesc(const render::GlContext& context, const WindowSize& size,
                                  render::Quality quality) {
  render::RendererDesc desc;
  desc.width = size.width;
  desc.height = size.height;
  desc.quality = quality;
  const bool software = render::isSoftwareRasteriser(render::loadGl(context));
  desc.samples = software ? 1 : 4;
  desc.shadowMapSize = software ? 1024 : 2048;
  desc.shadowTaps = software ? 1 : 4;
  return desc;
}

float markSize(const Session& session) { return kMarkShare * static_cast<float>(session.camera().distance); }

/// Adds the line from what is held to the place to which it is pulled.
void addPull(render::Overlay& marks, const Session& session, const Eigen::Vector3d& held) {
  const render::Vec3 place = toVec3(session.hand().place());
  marks.push_back({toVec3(held), place, kPullColour, kPullWidth});
  render::addCross(marks, place, markSize(session), kPullColour, kPullWidth);
}

render::Overlay marksOf(const Session& session) {
  render::Overlay marks;
  const float size = markSize(session);
  const SoftBodySystem& soft = *session.scene().soft;
  for (std::size_t b = 0; b < soft.bodyCount(); ++b) {
    const SoftBody& body = *soft.body(b);
    for (std::uint32_t i = 0; i < body.pointCount(); ++i)
      if (body.pinned(i)) render::addCross(marks, toVec3(body.position(i)), size, kPinColour);
  }
  if (session.hand().holds()) addPull(marks, session, session.hand().held());
  return marks;
}

/// The same for btSoftBody's view.
render::Overlay twinMarksOf(const Session& session) {
  render::Overlay marks;
  const float size = markSize(session);
  const bullet_soft::BulletTwin& twin = *session.bulletTwin();
  for (std::size_t b = 0; b < twin.bodyCount(); ++b)
    for (std::uint32_t i = 0; i < twin.pointCount(b); ++i)
      if (twin.isPinned(b, i)) render::addCross(marks, toVec3(twin.position(b, i)), size, kPinColour);
  const Hand& hand = session.hand();
  if (!hand.soft()) return marks;
  const std::size_t body = indexOf(session.scene(), hand.soft());
  // btSoftBody has no points that a cut has made
  if (body < twin.bodyCount() && hand.point() < twin.pointCount(body))
    addPull(marks, session, twin.position(body, hand.point()));
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
  shot.light = lightOf(session.scene().view);
  shot.light.shadows = session.shows(Layer::Shadows);
  shot.marks = marksOf(session);
  return shot;
}

}  // namespace

Stage::Pane::Pane(render::GlContext& context, const WindowSize& size, render::Quality quality)
    : renderer(context, rendererDesc(context, size, quality)), checker(addCheckerTexture(renderer)) {}

void Stage::Pane::resize(const WindowSize& size) {
  if (renderer.width() != size.width || renderer.height() != size.height)
    renderer.resize(size.width, size.height);
}

Stage::Stage(std::function<void*(const char*)> getProcAddress, const WindowSize& size)
    : context_(render::adoptContext(std::move(getProcAddress), "the window's")),
      left_(std::make_unique<Pane>(*context_, size, quality_)) {}

/// A renderer has one quality: another one needs new renderers.
void Stage::choose(render::Quality quality, const WindowSize& size) {
  if (quality == quality_) return;
  quality_ = quality;
  view_.reset();
  twinView_.reset();
  right_.reset();
  left_.reset();
  left_ = std::make_unique<Pane>(*context_, size, quality_);
  sceneNumber_ = 0;
}

/// Follows changes of the scene, of the split, of the quality and of the window's size.
void Stage::update(const Session& session, const WindowSize& size) {
  choose(session.shows(Layer::Gallery) ? render::Quality::Gallery : render::Quality::Fast, size);
  const bullet_soft::BulletTwin* twin = session.bulletTwin();
  const bool newScene = sceneNumber_ != session.sceneNumber();
  sceneNumber_ = session.sceneNumber();
  if (newScene) {
    view_.reset();
    view_.emplace(session.scene(), left_->renderer, left_->checker);
  }
  left_->resize(size);
  if (!newScene && twin == twin_) {
    if (twin) right_->resize(size);
    return;
  }
  twinView_.reset();
  twin_ = twin;
  if (!twin) return;
  if (!right_) right_ = std::make_unique<Pane>(*context_, size, quality_);
  right_->resize(size);
  twinView_.emplace(*twin, right_->renderer, right_->checker);
}

void Stage::draw(const Session& session, double tickFraction, const WindowSize& size, double scale) {
  const ViewLayout layout = layoutOf(size, session.shows(Layer::Split), session.shows(Layer::Panel), scale);
  const WindowSize& view = layout.view;
  update(session, view);
  Shot shot = shotOf(session, tickFraction);
  view_->draw(shot);
  left_->renderer.blitTo(0, layout.left, 0, view.width, view.height);
  if (!twinView_) return;
  shot.marks = twinMarksOf(session);
  twinView_->draw(shot);
  right_->renderer.blitTo(0, layout.left + view.width, 0, view.width, view.height);
}

render::Image Stage::readWindow(const WindowSize& size) const {
  render::Image upsideDown, image;
  upsideDown.resize(size.width, size.height);
  image.resize(size.width, size.height);
  left_->renderer.gl().ReadPixels(0, 0, size.width, size.height, GL_RGBA, GL_UNSIGNED_BYTE,
                                  upsideDown.rgba.data());
  for (int y = 0; y < size.height; ++y)
    std::memcpy(image.pixel(0, y), upsideDown.pixel(0, size.height - 1 - y),
                4u * static_cast<std::size_t>(size.width));
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
  return image;
}

}  // namespace limber::demo
