// SPDX-License-Identifier: Zlib
#include "limber/view/rigid_view.h"

#include "limber/view/convert.h"
#include "limber/view/shape_mesh.h"

#include "leave_in_order.h"

#include <limber/soft_body.h>

#include <LinearMath/btTransformUtil.h>

namespace limber::view {
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
}  // namespace limber::view
