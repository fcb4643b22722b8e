// SPDX-License-Identifier: Zlib
#include "limber/view/rigid_view.h"

#include "limber/view/convert.h"
#include "limber/view/shape_mesh.h"
#include "limber/view/soft_view.h"

#include <limber/soft_body.h>

#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <iterator>
#include <unordered_map>
#include <utility>
#include <vector>

namespace limber::view {

/// Takes what is `gone` out of the map and calls `hide` for it, in the order of the instances: that of
/// addresses differs from run to run, and with it would the places that new instances get.
template <class Key, class Shown, class Gone, class Hide>
void leaveInOrder(std::unordered_map<Key, Shown>& shown, Gone gone, Hide hide) {
  std::vector<Shown> leaving;
  for (auto it = shown.begin(); it != shown.end();) {
    if (gone(it->second)) leaving.push_back(it->second);
    it = gone(it->second) ? shown.erase(it) : std::next(it);
  }
  std::sort(leaving.begin(), leaving.end(),
            [](const Shown& a, const Shown& b) { return a.instance.index < b.instance.index; });
  for (const Shown& one : leaving) hide(one);
}

inline namespace LIMBER_BULLET_PRECISION {
namespace {

constexpr render::Vec3 kStands{0.78f, 0.79f, 0.82f}, kMoves{0.76f, 0.62f, 0.45f};

bool isShown(const btCollisionObject& object) {
  const int hidden =
      btCollisionObject::CF_DISABLE_VISUALIZE_OBJECT | btCollisionObject::CF_NO_CONTACT_RESPONSE;
  return (object.getCollisionFlags() & hidden) == 0;
}

/// Boxes and spheres are shown by one of each of size 1, stretched.
bool isBox(const btCollisionShape& shape) { return shape.getShapeType() == BOX_SHAPE_PROXYTYPE; }
bool isSphere(const btCollisionShape& shape) { return shape.getShapeType() == SPHERE_SHAPE_PROXYTYPE; }

btVector3 sizeOf(const btCollisionShape& shape) {
  if (isBox(shape)) return static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin();
  if (!isSphere(shape)) return btVector3(1, 1, 1);
  const btScalar radius = static_cast<const btSphereShape&>(shape).getRadius();
  return btVector3(radius, radius, radius);
}

render::Scenery unitMeshOf(const btCollisionShape& shape) {
  if (isBox(shape)) return render::makeBox({}, {1.0f, 1.0f, 1.0f});
  if (isSphere(shape)) return render::makeUvSphere({}, 1.0f);
  return meshOf(shape);
}

/// As Bullet's motion states: from where it is after the tick along its velocity.
btTransform placeAt(const btCollisionObject& object, double secondsLater) {
  const btRigidBody* body = btRigidBody::upcast(&object);
  if (!body || body->isStaticOrKinematicObject() || secondsLater == 0.0) return object.getWorldTransform();
  btTransform place;
  btTransformUtil::integrateTransform(body->getInterpolationWorldTransform(),
                                      body->getInterpolationLinearVelocity(),
                                      body->getInterpolationAngularVelocity(), btScalar(secondsLater), place);
  return place;
}

render::InstanceLook defaultLook(const btCollisionObject& object) {
  render::InstanceLook look;
  look.colour = object.isStaticOrKinematicObject() ? kStands : kMoves;
  return look;
}

}  // namespace

bool RigidView::Kind::operator==(const Kind& other) const {
  return shape == other.shape && type == other.type && low == other.low && high == other.high;
}

RigidView::Kind RigidView::kindOf(const btCollisionShape& shape) {
  Kind kind{nullptr, shape.getShapeType(), btVector3(0, 0, 0), btVector3(0, 0, 0)};
  if (isBox(shape) || isSphere(shape)) return kind;
  kind.shape = &shape;
  shape.getAabb(btTransform::getIdentity(), kind.low, kind.high);
  return kind;
}

RigidView::RigidView(render::Renderer& renderer, const btDiscreteDynamicsWorld& world, Look look)
    : renderer_(renderer), world_(world), look_(look ? std::move(look) : Look(defaultLook)) {
  update();
}

RigidView::~RigidView() {
  leaveInOrder(
      shown_, [](const Shown&) { return true; }, [this](const Shown& shown) { hide(shown); });
}

void RigidView::update() {
  for (auto& [object, shown] : shown_) shown.present = false;
  const btCollisionObjectArray& objects = world_.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    const btCollisionObject& object = *objects[i];
    if (!isShown(object)) continue;
    const auto found = shown_.find(&object);
    if (found != shown_.end() &&
        surfaces_[found->second.surface].kind == kindOf(*object.getCollisionShape())) {
      found->second.present = true;
      continue;
    }
    Shown fresh;
    if (found != shown_.end()) hide(found->second), shown_.erase(found);
    if (show(object, fresh)) shown_.emplace(&object, fresh);
  }
  leaveInOrder(
      shown_, [](const Shown& shown) { return !shown.present; }, [this](const Shown& shown) { hide(shown); });
}

void RigidView::write(const render::FrameWriter& frame, double tickFraction, double tick) const {
  const btCollisionObjectArray& objects = world_.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    const auto found = shown_.find(objects[i]);
    if (found == shown_.end()) continue;
    const btTransform place = placeAt(*objects[i], (tickFraction - 1.0) * tick);
    const Shown& shown = found->second;
    render::writeFrame(surfaces_[shown.surface].reach,
                       toFrame(place, sizeOf(*objects[i]->getCollisionShape())),
                       frame.points(shown.instance));
  }
}

bool RigidView::show(const btCollisionObject& object, Shown& shown) {
  const std::optional<std::size_t> surface = surfaceFor(*object.getCollisionShape());
  if (!surface) return false;
  ++surfaces_[*surface].users;
  shown = {renderer_.addInstance(surfaces_[*surface].id, look_(object)), *surface, true};
  return true;
}

std::optional<std::size_t> RigidView::surfaceFor(const btCollisionShape& shape) {
  const Kind kind = kindOf(shape);
  std::size_t unused = surfaces_.size();
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    if (surfaces_[s].users > 0 && surfaces_[s].kind == kind) return s;
    if (surfaces_[s].users == 0) unused = s;
  }
  const render::Scenery mesh = unitMeshOf(shape);
  if (mesh.shape.triangles.empty()) return std::nullopt;
  const render::RigidShape rigid = render::makeRigid(mesh);
  const render::ShapeId id = renderer_.addShape(rigid.shape);
  if (unused == surfaces_.size()) surfaces_.emplace_back();
  surfaces_[unused] = {kind, id, rigid.reach, 0};
  return unused;
}

void RigidView::hide(const Shown& shown) {
  renderer_.removeInstance(shown.instance);
  Surface& surface = surfaces_[shown.surface];
  if (--surface.users == 0) renderer_.removeShape(surface.id);
}

}  // namespace LIMBER_BULLET_PRECISION

inline namespace LIMBER_BULLET_PRECISION {
namespace {

void addSurface(render::ShapeDesc& shape, const RenderSurface& surface) {
  shape.skin = {surface.skin.firstWeight, surface.skin.points, surface.skin.weights};
  shape.vertexToPoint = surface.vertexToPoint;
  // a vertex no triangle uses rides on no point; the renderer wants one all the same
  for (std::uint32_t& point : shape.vertexToPoint) {
    if (point == kNoPoint) point = 0;
  }
  for (const Eigen::Vector2f& uv : surface.uvs) shape.uvs.insert(shape.uvs.end(), {uv.x(), uv.y()});
  for (const Triangle& t : surface.triangles) {
    shape.triangles.insert(shape.triangles.end(), t.begin(), t.end());
  }
}

/// Bending springs lie over the others and would only hide them.
void addSprings(render::ShapeDesc& shape, const SoftBody& body) {
  const SpringNetwork& network = body.network();
  const Eigen::Vector3d& scale = body.settings().scale;
  for (const NetworkSpring& spring : network.springs) {
    if (spring.kind == SpringKind::Bending) continue;
    const Eigen::Vector3d way = network.restPoints[spring.b] - network.restPoints[spring.a];
    shape.lines.insert(shape.lines.end(), {spring.a, spring.b});
    shape.lineRestLengths.push_back(static_cast<float>(way.cwiseProduct(scale).norm()));
  }
}

}  // namespace

render::ShapeDesc shapeOf(const SoftBody& body, render::Shading shading) {
  const SpringNetwork& network = body.network();
  render::ShapeDesc shape;
  shape.name = "soft body";
  shape.pointCount = body.pointCount();
  shape.shading = shading;
  shape.twoSided = true;
  if (network.kind == NetworkKind::Rope)
    shape.tubeRadius = static_cast<float>(pointRadius(network, body.settings()));
  else
    addSurface(shape, network.render);
  addSprings(shape, body);
  return shape;
}

}  // namespace LIMBER_BULLET_PRECISION

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
