// SPDX-License-Identifier: Zlib
#include <limber/soft_body_system.h>

#include "bullet/body_in_world.h"
#include "bullet/convert.h"
#include "bullet/debug_draw.h"
#include "bullet/new_body.h"
#include "bullet/surface_body.h"
#include "bullet/system_impl.h"
#include "bullet/world_clock.h"

#include <algorithm>
#include <cstdio>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

bool holdsOn(const SpringConstraint& spring, const btRigidBody* body) {
  return spring.endA().body == body || spring.endB().body == body;
}

}  // namespace

void warnOnStandardError(const std::string& text) { std::fprintf(stderr, "limber: %s\n", text.c_str()); }

// --- in and out of the world -------------------------------------------------------------------------------

void SoftBodySystem::Impl::hookUp() {
  if (!hook) hook = &TickHook::listen(*world, *this, hookKind == Hook::PreTick);
}

/// Stays in place while it is not known whether the world still exists: an idle hook does no harm.
void SoftBodySystem::Impl::unhookIfIdle(bool alive) {
  if (!hook || !alive || !bodies.empty() || !springs.empty()) return;
  hook->leave(*this, true);
  hook = nullptr;
}

/// A world that is deleted takes the broadphase handle of every body in it; nothing else tells of its end.
bool SoftBodySystem::Impl::worldAlive() const {
  for (const auto& body : bodies)
    if (anyInWorld(*body->data_)) return true;
  return false;
}

SoftBodySystem::SoftBodySystem(btDiscreteDynamicsWorld& world, Hook hook)
    : impl_(std::make_unique<Impl>(world, hook)) {}

SoftBodySystem::~SoftBodySystem() {
  const bool alive = impl_->worldAlive();
  impl_->stopWatching(alive);
  for (auto& body : impl_->bodies) removeFromWorld(*body->data_);
  if (impl_->hook) impl_->hook->leave(*impl_, alive);
}

void SoftBodySystem::removeAll() {
  impl_->forgetGroups();
  impl_->springs.clear();
  if (impl_->events.calling()) {
    for (auto& body : impl_->bodies) impl_->doomed.push_back(body.get());
    return;
  }
  while (!impl_->bodies.empty()) destroyBody(impl_->bodies.back().get());
}

HookState SoftBodySystem::hookState() const {
  if (!impl_->hook) return HookState::Idle;
  if (impl_->hookKind == Hook::Manual) return HookState::Attached;
  return impl_->hook->inPlace() && !impl_->overwritten ? HookState::Attached : HookState::Overwritten;
}

void SoftBodySystem::rehook() {
  impl_->overwritten = false;
  if (impl_->hook && impl_->hookKind == Hook::PreTick) impl_->hook->takeSlot();
}

void SoftBodySystem::onWarning(std::function<void(const std::string&)> handler) {
  impl_->warn = std::move(handler);
}

// --- bodies ------------------------------------------------------------------------------------------------

Result<SoftBody*> SoftBodySystem::createBody(SharedNetwork network, const SoftBodySettings& settings) {
  Result<std::unique_ptr<SoftBodyData>> data = makeBodyData(std::move(network), settings);
  if (!data) return Error{data.error()};
  impl_->hookUp();
  (*data)->world = impl_->world;
  (*data)->system = impl_.get();
  (*data)->onPointsShared = [impl = impl_.get()] { impl->watchSteps(); };
  (*data)->onPointDeleted = [impl = impl_.get()](const btRigidBody& point) { impl->dropSprings(point); };
  impl_->bodies.push_back(std::make_unique<SoftBody>(std::move(*data)));
  SoftBody* body = impl_->bodies.back().get();
  if (isSurfaceBody(*body->data_))
    body->data_->surface.topology = impl_->topologies.of(body->data_->network, settings);
  addToWorld(*body->data_);
  impl_->groupsStale = true;
  return body;
}

void SoftBodySystem::destroyBody(SoftBody* body) {
  if (impl_->events.calling()) {
    impl_->doomed.push_back(body);
    return;
  }
  const bool alive = impl_->worldAlive();
  impl_->destroyNow(body);
  for (std::size_t i = 0; i < impl_->doomed.size(); ++i) impl_->destroyNow(impl_->doomed[i]);
  impl_->doomed.clear();
  impl_->unhookIfIdle(alive);
}

void SoftBodySystem::Impl::destroyNow(SoftBody* body) {
  const auto isBody = [&](const auto& owned) { return owned.get() == body; };
  const auto it = std::find_if(bodies.begin(), bodies.end(), isBody);
  if (it == bodies.end()) return;
  const bool alive = worldAlive();
  endPairsOf(body);
  for (btRigidBody* point : body->data_->masses.bodies)
    if (point) forget(*point);
  forgetGroups();
  removeFromWorld(*body->data_);
  bodies.erase(std::find_if(bodies.begin(), bodies.end(), isBody));
  const auto isShared = [](const auto& other) {
    return isSurfaceBody(*other->data_) && other->data_->masses.shared;
  };
  if (std::none_of(bodies.begin(), bodies.end(), isShared)) stopWatching(alive);
}

std::size_t SoftBodySystem::bodyCount() const { return impl_->bodies.size(); }
SoftBody* SoftBodySystem::body(std::size_t i) const { return impl_->bodies[i].get(); }

// --- springs and anchors -----------------------------------------------------------------------------------

Result<SpringConstraint*> SoftBodySystem::addSpring(const SpringEnd& a, const SpringEnd& b,
                                                    const SpringSettings& settings) {
  if (std::string reason = validate(settings); !reason.empty()) return Error{reason};
  if (!a.body && !b.body) return Error{"a spring needs a body at one of its ends"};
  if (a.body == b.body && (a.pivot - b.pivot).length2() == btScalar(0))
    return Error{"both ends of the spring are the same place of one body"};
  impl_->hookUp();
  impl_->springs.push_back(std::make_unique<SpringConstraint>(a, b, settings));
  SpringConstraint* spring = impl_->springs.back().get();
  if (settings.restLength < 0.0) spring->settings_.restLength = double(spring->length());
  for (btRigidBody* end : {a.body, b.body})
    if (end) end->activate();
  impl_->groupsStale = true;
  return spring;
}

Result<SpringConstraint*> SoftBodySystem::changeSpring(SpringConstraint* spring,
                                                       const SpringSettings& settings) {
  if (std::string reason = validate(settings); !reason.empty()) return Error{reason};
  const double restLength = settings.restLength < 0.0 ? spring->settings_.restLength : settings.restLength;
  spring->settings_ = settings;
  spring->settings_.restLength = restLength;
  impl_->groupsStale = true;
  return spring;
}

void SoftBodySystem::removeSpring(SpringConstraint* spring) {
  const auto isSpring = [&](const auto& owned) { return owned.get() == spring; };
  impl_->forgetGroups();
  SpringList& springs = impl_->springs;
  springs.erase(std::remove_if(springs.begin(), springs.end(), isSpring), springs.end());
  impl_->unhookIfIdle(impl_->worldAlive());
}

void SoftBodySystem::Impl::dropSprings(const btRigidBody& body) {
  const auto isOn = [&](const auto& spring) { return holdsOn(*spring, &body); };
  forgetGroups();
  springs.erase(std::remove_if(springs.begin(), springs.end(), isOn), springs.end());
}

/// Groups hold pointers to bodies and springs: whoever removes one calls this first.
void SoftBodySystem::Impl::forgetGroups() {
  groups.clear();
  clusters.count = 0;
  pairs.clear();
  plan.clear();
  living.clear();
  groupsStale = true;
}

std::size_t SoftBodySystem::springCount() const { return impl_->springs.size(); }

Result<bool> SoftBodySystem::attach(SoftBody* softBody, std::uint32_t i, btRigidBody& body,
                                    const btVector3& pivot) {
  PointMass* point = i < softBody->pointCount() ? softBody->data_->masses.bodies[i] : nullptr;
  if (!point) return Error{"there is no point " + std::to_string(i)};
  if (point->attachedTo) return Error{"point " + std::to_string(i) + " is already attached"};
  if (softBody->pinned(i)) return Error{"point " + std::to_string(i) + " is pinned"};
  if (PointMass::from(&body))
    return Error{"a point can be attached to a rigid body only, not to a point mass"};
  point->attachedTo = &body;
  softBody->data_->anchors.push_back({i, &body, pivot});
  softBody->wake();
  impl_->groupsStale = true;
  return true;
}

Result<bool> SoftBodySystem::attach(SoftBody* softBody, std::uint32_t i, btRigidBody& body) {
  if (i >= softBody->pointCount()) return Error{"there is no point " + std::to_string(i)};
  const btVector3 place = toBullet(softBody->position(i));
  return attach(softBody, i, body, body.getWorldTransform().inverse() * place);
}

bool SoftBodySystem::detach(SoftBody* softBody, std::uint32_t i) { return impl_->detach(softBody, i); }

bool SoftBodySystem::Impl::detach(SoftBody* softBody, std::uint32_t i) {
  std::vector<Anchor>& anchors = softBody->data_->anchors;
  const auto isPoint = [&](const Anchor& anchor) { return anchor.point == i; };
  const auto it = std::find_if(anchors.begin(), anchors.end(), isPoint);
  if (it == anchors.end()) return false;
  anchors.erase(it);
  if (PointMass* point = softBody->data_->masses.bodies[i]) point->attachedTo = nullptr;
  softBody->wake();
  forgetGroups();
  return true;
}

void SoftBodySystem::forget(const btRigidBody& body) { impl_->forget(body); }

void SoftBodySystem::Impl::forget(const btRigidBody& body) {
  dropSprings(body);
  for (auto& softBody : bodies)
    for (std::size_t i = softBody->data_->anchors.size(); i-- > 0;)
      if (softBody->data_->anchors[i].body == &body)
        detach(softBody.get(), softBody->data_->anchors[i].point);
}

void SoftBodySystem::beforeTick(btScalar tick) { impl_->beforeTick(tick); }

const TickProfile& SoftBodySystem::profile() const { return impl_->profile; }

double SoftBodySystem::tickFraction() const { return limber::tickFraction(*impl_->world); }

void SoftBodySystem::debugDraw(btIDebugDraw& drawer) const { impl_->debugDraw(drawer); }

void SoftBodySystem::Impl::debugDraw(btIDebugDraw& drawer) {
  for (auto& body : bodies) limber::debugDraw(*body->data_, drawer);
  limber::debugDraw(springs, drawer);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
