// SPDX-License-Identifier: Zlib
// Shows the soft and rigid bodies of a world, debug drawings and arrows.

#include "limber/view/rigid_view.h"

#include "limber/view/convert.h"
#include "limber/view/debug_drawer.h"
#include "limber/view/shape_mesh.h"
#include "limber/view/soft_view.h"
#include "limber/view/velocity_arrows.h"

#include <limber/soft_body.h>

#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <unordered_map>
#include <utility>
#include <vector>

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Removes the entries for which `gone` is true from the map and calls `hide` for them, in the order of their
/// instances. The order of addresses would differ from run to run, and so would the ids of new instances.
template <class Key, class Shown, class Gone, class Hide>
void removeInOrder(std::unordered_map<Key, Shown>& shown, Gone gone, Hide hide) {
  std::vector<Shown> removed;
  for (auto it = shown.begin(); it != shown.end();) {
    if (gone(it->second)) removed.push_back(it->second);
    it = gone(it->second) ? shown.erase(it) : std::next(it);
  }
  std::sort(removed.begin(), removed.end(),
            [](const Shown& a, const Shown& b) { return a.instance.index < b.instance.index; });
  for (const Shown& one : removed) hide(one);
}

/// Adds an instance of a shape with the look that `look()` returns. If this fails and the instance would be
/// the first one, the shape goes, too.
template <class Shape, class Look>
render::InstanceId addUser(render::Renderer& renderer, Shape& shape, Look look) {
  try {
    const render::InstanceId instance = renderer.addInstance(shape.id, look());
    ++shape.users;
    return instance;
  } catch (...) {
    if (shape.users == 0) renderer.removeShape(shape.id);
    throw;
  }
}

constexpr render::Vec3 kStaticColour{0.78f, 0.79f, 0.82f}, kDynamicColour{0.76f, 0.62f, 0.45f};

bool isShown(const btCollisionObject& object) {
  const int hidden =
      btCollisionObject::CF_DISABLE_VISUALIZE_OBJECT | btCollisionObject::CF_NO_CONTACT_RESPONSE;
  return (object.getCollisionFlags() & hidden) == 0;
}

/// All boxes share one box of half extent 1, all spheres one sphere of radius 1; their frames are scaled.
bool isBox(const btCollisionShape& shape) { return shape.getShapeType() == BOX_SHAPE_PROXYTYPE; }
bool isSphere(const btCollisionShape& shape) { return shape.getShapeType() == SPHERE_SHAPE_PROXYTYPE; }

btVector3 sizeOf(const btCollisionShape& shape) {
  if (isBox(shape)) return static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin();
  if (!isSphere(shape)) return btVector3(1, 1, 1);
  const btScalar radius = static_cast<const btSphereShape&>(shape).getRadius();
  return btVector3(radius, radius, radius);
}

/// Shapes with more triangles than a box may be curved. Edges that bend by more than this are sharp, rad.
constexpr std::size_t kBoxTriangles = 12;
constexpr float kSharpAngle = 0.75f;

render::Scenery unitMeshOf(const btCollisionShape& shape) {
  if (isBox(shape)) return render::makeBox({}, {1.0f, 1.0f, 1.0f});
  if (isSphere(shape)) return render::makeUvSphere({}, 1.0f);
  return meshOf(shape);
}

/// Returns the transform that a motion state would get from Bullet: extrapolated from the end of the tick
/// along the velocity.
btTransform transformAt(const btCollisionObject& object, double secondsLater) {
  const btRigidBody* body = btRigidBody::upcast(&object);
  if (!body || body->isStaticOrKinematicObject() || secondsLater == 0.0) return object.getWorldTransform();
  btTransform transform;
  btTransformUtil::integrateTransform(
      body->getInterpolationWorldTransform(), body->getInterpolationLinearVelocity(),
      body->getInterpolationAngularVelocity(), btScalar(secondsLater), transform);
  return transform;
}

render::InstanceLook defaultLook(const btCollisionObject& object) {
  render::InstanceLook look;
  look.colour = object.isStaticOrKinematicObject() ? kStaticColour : kDynamicColour;
  return look;
}

/// A number that no other object in the world has had: a new one may have the address of an old one.
int numberOf(const btCollisionObject& object) {
  const btBroadphaseProxy* proxy = object.getBroadphaseHandle();
  return proxy ? proxy->m_uniqueId : -1;
}

}  // namespace

bool RigidView::ShapeKey::operator==(const ShapeKey& other) const {
  return shape == other.shape && type == other.type && low == other.low && high == other.high;
}

RigidView::ShapeKey RigidView::keyOf(const btCollisionShape& shape) {
  ShapeKey key{nullptr, shape.getShapeType(), btVector3(0, 0, 0), btVector3(0, 0, 0)};
  if (isBox(shape) || isSphere(shape)) return key;
  key.shape = &shape;
  shape.getAabb(btTransform::getIdentity(), key.low, key.high);
  return key;
}

RigidView::RigidView(render::Renderer& renderer, const btDiscreteDynamicsWorld& world, Look look)
    : renderer_(renderer), world_(world), look_(look ? std::move(look) : Look(defaultLook)) {
  update();
}

RigidView::~RigidView() {
  removeInOrder(
      shown_, [](const Shown&) { return true; }, [this](const Shown& shown) { hide(shown); });
}

void RigidView::update() {
  for (auto& [object, shown] : shown_) shown.present = false;
  const btCollisionObjectArray& objects = world_.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    const btCollisionObject& object = *objects[i];
    if (!isShown(object)) continue;
    const auto found = shown_.find(&object);
    if (found != shown_.end() && found->second.number == numberOf(object) &&
        surfaces_[found->second.surface].key == keyOf(*object.getCollisionShape())) {
      found->second.present = true;
      continue;
    }
    Shown added;
    if (found != shown_.end()) hide(found->second), shown_.erase(found);
    if (show(object, added)) shown_.emplace(&object, added);
  }
  removeInOrder(
      shown_, [](const Shown& shown) { return !shown.present; }, [this](const Shown& shown) { hide(shown); });
}

void RigidView::write(const render::FrameWriter& frame, double tickFraction, double tick) const {
  const btCollisionObjectArray& objects = world_.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    const auto found = shown_.find(objects[i]);
    if (found == shown_.end()) continue;
    const btTransform transform = transformAt(*objects[i], (tickFraction - 1.0) * tick);
    const Shown& shown = found->second;
    render::writeFrame(surfaces_[shown.surface].reach,
                       toFrame(transform, sizeOf(*objects[i]->getCollisionShape())),
                       frame.points(shown.instance));
  }
}

bool RigidView::show(const btCollisionObject& object, Shown& shown) {
  const std::optional<std::size_t> surface = surfaceFor(*object.getCollisionShape());
  if (!surface) return false;
  const auto look = [&] { return look_(object); };
  shown = {addUser(renderer_, surfaces_[*surface], look), *surface, numberOf(object), true};
  return true;
}

std::optional<std::size_t> RigidView::surfaceFor(const btCollisionShape& shape) {
  const ShapeKey key = keyOf(shape);
  std::size_t unused = surfaces_.size();
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    if (surfaces_[s].users > 0 && surfaces_[s].key == key) return s;
    if (surfaces_[s].users == 0) unused = s;
  }
  render::Scenery mesh = unitMeshOf(shape);
  if (mesh.shape.triangles.empty()) return std::nullopt;
  if (mesh.shape.triangles.size() > 3 * kBoxTriangles && mesh.shape.shading == render::Shading::Flat &&
      mesh.shape.pattern == render::Pattern::Plain) {
    mesh.shape.shading = render::Shading::Smooth;
    render::sharpenEdges(mesh.shape, mesh.points, kSharpAngle);
  }
  const render::RigidShape rigid = render::makeRigid(mesh);
  const render::ShapeId id = renderer_.addShape(rigid.shape);
  if (unused == surfaces_.size()) surfaces_.emplace_back();
  surfaces_[unused] = {key, id, rigid.reach, 0};
  return unused;
}

void RigidView::hide(const Shown& shown) {
  renderer_.removeInstance(shown.instance);
  Surface& surface = surfaces_[shown.surface];
  if (--surface.users == 0) renderer_.removeShape(surface.id);
}

namespace {

/// `mirrored`: triangles then show their other side, and need the opposite order to face outwards.
void addSurface(render::ShapeDesc& shape, const RenderSurface& surface, bool mirrored) {
  shape.skin = {surface.skin.firstWeight, surface.skin.points, surface.skin.weights};
  shape.vertexToPoint = surface.vertexToPoint;
  // a vertex without triangles has no point, but the renderer needs a valid index
  for (std::uint32_t& point : shape.vertexToPoint) {
    if (point == kNoPoint) point = 0;
  }
  for (const Eigen::Vector2f& uv : surface.uvs) shape.uvs.insert(shape.uvs.end(), {uv.x(), uv.y()});
  for (const Triangle& t : surface.triangles) {
    shape.triangles.insert(shape.triangles.end(), {t[0], t[mirrored ? 2 : 1], t[mirrored ? 1 : 2]});
  }
}

/// Bending springs are left out: they lie over the others and hide them.
void addSprings(render::ShapeDesc& shape, const SoftBody& body) {
  const SpringNetwork& network = body.network();
  const Eigen::Vector3d& scale = body.settings().scale;
  for (const NetworkSpring& spring : network.springs) {
    if (spring.kind == SpringKind::Bending) continue;
    const Eigen::Vector3d displacement = network.restPoints[spring.b] - network.restPoints[spring.a];
    shape.lines.insert(shape.lines.end(), {spring.a, spring.b});
    shape.lineRestLengths.push_back(static_cast<float>(displacement.cwiseProduct(scale).norm()));
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
    addSurface(shape, network.render, body.settings().scale.prod() < 0.0);
  addSprings(shape, body);
  return shape;
}

namespace {

/// Returns the places of the surface at rest, 3 floats each.
std::vector<float> restPlaces(const SoftBody& body) {
  const SpringNetwork& network = body.network();
  const Skin& skin = network.render.skin;
  std::vector<Eigen::Vector3d> places = network.restPoints;
  if (skin.size() > 0) {
    places.assign(skin.size(), Eigen::Vector3d::Zero());
    for (std::size_t p = 0; p < places.size(); ++p)
      for (std::uint32_t k = skin.firstWeight[p]; k < skin.firstWeight[p + 1]; ++k)
        places[p] += double{skin.weights[k]} * network.restPoints[skin.points[k]];
  }
  std::vector<float> xyz;
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Vector3f scaled = place.cwiseProduct(body.settings().scale).cast<float>();
    xyz.insert(xyz.end(), {scaled.x(), scaled.y(), scaled.z()});
  }
  return xyz;
}

bool visible(const SoftBody& body) { return body.alive() && body.pointCount() > 0; }

}  // namespace

render::ShapeDesc shapeOf(const SoftBody& body, const SoftLook& look) {
  render::ShapeDesc desc = shapeOf(body, look.shading);
  desc.hideBackFaces = look.hideBackFaces;
  if (look.shading == render::Shading::Smooth && look.sharpAngle > 0.0f && !desc.triangles.empty())
    render::sharpenEdges(desc, restPlaces(body), look.sharpAngle);
  return desc;
}

SoftView::SoftView(render::Renderer& renderer, const SoftBodySystem& system, Look look)
    : renderer_(renderer), system_(system), look_(std::move(look)) {
  update();
}

SoftView::~SoftView() {
  removeInOrder(
      shown_, [](const Shown&) { return true; }, [this](const Shown& shown) { hide(shown); });
}

void SoftView::update() {
  for (auto& [body, shown] : shown_) shown.present = false;
  for (std::size_t b = 0; b < system_.bodyCount(); ++b) {
    SoftBody& body = *system_.body(b);
    if (!visible(body)) continue;
    const auto found = shown_.find(&body);
    // a new body may have the address of an old one
    if (found != shown_.end() && found->second.body && hasShapeOf(found->second, body)) {
      found->second.present = true;
      continue;
    }
    if (found != shown_.end()) hide(found->second), shown_.erase(found);
    shown_.emplace(&body, show(body));
  }
  removeInOrder(
      shown_, [](const Shown& shown) { return !shown.present; }, [this](const Shown& shown) { hide(shown); });
}

void SoftView::updateLooks() {
  if (!look_) return;
  for (const auto& [body, shown] : shown_) renderer_.setLook(shown.instance, look_(*body).instance);
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

SoftView::Shown SoftView::show(SoftBody& body) {
  const SoftLook look = look_ ? look_(body) : SoftLook{};
  const std::size_t shape = shapeFor(body, look);
  return {addUser(renderer_, shapes_[shape], [&] { return look.instance; }), shape, body.handle(), true};
}

std::size_t SoftView::shapeFor(const SoftBody& body, const SoftLook& look) {
  const double radius = pointRadius(body.network(), body.settings());
  std::size_t unused = shapes_.size();
  for (std::size_t s = 0; s < shapes_.size(); ++s) {
    const Shape& shape = shapes_[s];
    if (shape.users == 0) unused = s;
    if (shape.users > 0 && shape.network == body.sharedNetwork() && shape.scale == body.settings().scale &&
        shape.radius == radius && shape.shading == look.shading &&
        shape.hideBackFaces == look.hideBackFaces && shape.sharpAngle == look.sharpAngle)
      return s;
  }
  const render::ShapeId id = renderer_.addShape(shapeOf(body, look));
  if (unused == shapes_.size()) shapes_.emplace_back();
  shapes_[unused] = {body.sharedNetwork(), body.settings().scale, radius, look.shading,
                     look.hideBackFaces,   look.sharpAngle,       id,     0};
  return unused;
}

bool SoftView::hasShapeOf(const Shown& shown, const SoftBody& body) const {
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

// --- overlays ----------------------------------------------------------------------------------------------

void DebugDrawer::drawLine(const btVector3& from, const btVector3& to, const btVector3& colour) {
  overlay.push_back({toVec3(from), toVec3(to), toVec3(colour)});
}

void DebugDrawer::drawContactPoint(const btVector3& at, const btVector3& normal, btScalar, int,
                                   const btVector3& colour) {
  const render::Vec3 tip = toVec3(at + btScalar(contactSize) * normal);
  overlay.push_back({toVec3(at), tip, toVec3(colour), contactWidth});
  render::addCross(overlay, toVec3(at), 0.2f * contactSize, toVec3(colour), contactWidth);
}

void DebugDrawer::reportErrorWarning(const char* text) {
  if (onWarning) return onWarning(text);
  std::fprintf(stderr, "bullet: %s\n", text);
}

namespace {

render::Vec3 vec3Of(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

render::Legend speedLegend(const VelocityArrows& arrows) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g m/s", arrows.fullSpeed);
  return {render::ColourMap::Share, "0", "", text.data()};
}

void addVelocities(render::Overlay& overlay, const SoftBody& body, const VelocityArrows& arrows,
                   render::Vec3 eye) {
  for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
    const Eigen::Vector3d from = body.position(i), velocity = body.velocity(i);
    const double speed = velocity.norm();
    if (speed < arrows.leastSpeed) continue;
    const Eigen::Vector3d to = from + arrows.seconds * velocity;
    const render::Vec3 colour = render::shareColour(static_cast<float>(speed / arrows.fullSpeed));
    render::addArrow(overlay, vec3Of(from), vec3Of(to), colour, eye);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view
