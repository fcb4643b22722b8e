// SPDX-License-Identifier: Zlib
#include "limber/view/soft_view.h"

#include "limber/view/soft_surface.h"

#include "leave_in_order.h"

#include <utility>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

bool visible(const SoftBody& body) { return body.alive() && body.pointCount() > 0; }

}  // namespace

SoftView::SoftView(render::Renderer& renderer, const SoftBodySystem& system, Look look)
    : renderer_(renderer), system_(system), look_(std::move(look)) {
  update();
}

SoftView::~SoftView() {
  leaveInOrder(
      shown_, [](const Shown&) { return true; }, [this](const Shown& shown) { hide(shown); });
}

void SoftView::update() {
  for (auto& [body, shown] : shown_) shown.present = false;
  for (std::size_t b = 0; b < system_.bodyCount(); ++b) {
    const SoftBody& body = *system_.body(b);
    if (!visible(body)) continue;
    const auto found = shown_.find(&body);
    if (found != shown_.end() && isStill(found->second, body)) {
      found->second.present = true;
      continue;
    }
    // a new body may lie where an old one lay in memory
    if (found != shown_.end()) hide(found->second);
    shown_[&body] = show(body);
  }
  leaveInOrder(
      shown_, [](const Shown& shown) { return !shown.present; }, [this](const Shown& shown) { hide(shown); });
}

void SoftView::write(const render::FrameWriter& frame, double tickFraction) const {
  for (std::size_t b = 0; b < system_.bodyCount(); ++b) {
    const SoftBody* body = system_.body(b);
    const auto found = shown_.find(body);
    if (found != shown_.end()) body->writePositions(frame.points(found->second.instance), tickFraction);
  }
}

std::size_t SoftView::pointCount() const {
  std::size_t sum = 0;
  for (const auto& [body, shown] : shown_) sum += shapes_[shown.shape].network->restPoints.size();
  return sum;
}

SoftView::Shown SoftView::show(const SoftBody& body) {
  const SoftLook look = look_ ? look_(body) : SoftLook{};
  const std::size_t shape = shapeFor(body, look.shading);
  ++shapes_[shape].users;
  return {renderer_.addInstance(shapes_[shape].id, look.instance), shape, true};
}

std::size_t SoftView::shapeFor(const SoftBody& body, render::Shading shading) {
  const double radius = pointRadius(body.network(), body.settings());
  std::size_t unused = shapes_.size();
  for (std::size_t s = 0; s < shapes_.size(); ++s) {
    const Shape& shape = shapes_[s];
    if (shape.users == 0) unused = s;
    if (shape.users > 0 && shape.network == body.sharedNetwork() && shape.scale == body.settings().scale &&
        shape.radius == radius && shape.shading == shading)
      return s;
  }
  const render::ShapeId id = renderer_.addShape(shapeOf(body, shading));
  if (unused == shapes_.size()) shapes_.emplace_back();
  shapes_[unused] = {body.sharedNetwork(), body.settings().scale, radius, shading, id, 0};
  return unused;
}

bool SoftView::isStill(const Shown& shown, const SoftBody& body) const {
  const Shape& shape = shapes_[shown.shape];
  return shape.network == body.sharedNetwork() && shape.scale == body.settings().scale;
}

void SoftView::hide(const Shown& shown) {
  renderer_.removeInstance(shown.instance);
  Shape& shape = shapes_[shown.shape];
  if (--shape.users > 0) return;
  renderer_.removeShape(shape.id);
  shape.network.reset();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view
