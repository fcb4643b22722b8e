// SPDX-License-Identifier: Zlib

// This file implements the user's interface of a system: bodies, what surrounds them, contact listeners and
// debug drawing. The ticks are in tick.cpp.

#include <limber/soft_body_system.h>

#include "bullet/body_in_world.h"
#include "bullet/contact_report.h"
#include "bullet/system_impl.h"
#include "bullet/tick_hook.h"

#include <LinearMath/btIDebugDraw.h>

#include <algorithm>
#include <cstdio>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

bool isSystemObject(const btCollisionObject* object) { return isSoft(object) || StepBoundary::isOne(object); }

void warnOnStandardError(const std::string& text) { std::fprintf(stderr, "limber: %s\n", text.c_str()); }

// --- the system in the world -------------------------------------------------------------------------------

void SoftBodySystem::Impl::hookUp() {
  if (hook) return;
  const bool isFirst = std::none_of(step->systems.begin(), step->systems.end(),
                                    [](const Impl* system) { return system->hook != nullptr; });
  const bool known = isFirst || worldAlive();
  hook = &TickHook::listen(*world, *this, hookKind == Hook::PreTick, known);
  if (isFirst || !known) step->kinematic.start(*world);
}

/// Removes the hook of a system without bodies and springs, if the world is known to exist. Otherwise the
/// hook stays until the next tick, which proves that the world exists.
void SoftBodySystem::Impl::unhookIfIdle(bool alive) {
  if (!hook || !alive || !bodies.empty() || !springs.empty()) return;
  step->restoreBulletState();
  hook->leave(*this, true);
  hook = nullptr;
}

/// Returns whether the world is known to exist. Its destructor removes the broadphase handle of every body in
/// it, which is the only sign. Returns false if no body of a system is in the world, because nothing is known
/// then.
bool SoftBodySystem::Impl::worldAlive() const {
  const auto isIn = [](const auto& body) { return anyInWorld(*body->data_); };
  return std::any_of(step->systems.begin(), step->systems.end(), [&](const Impl* system) {
    return (system->stepBoundary && system->stepBoundary->isInWorld()) ||
           std::any_of(system->bodies.begin(), system->bodies.end(), isIn);
  });
}

SoftBodySystem::Impl::Impl(btDiscreteDynamicsWorld& w, Hook h)
    : world(&w), hookKind(h), step(WorldStep::of(w)) {
  step->systems.push_back(this);
}

SoftBodySystem::Impl::~Impl() {
  step->forgetGroups();
  if (step->stepped == this) step->stepped = nullptr;
  step->systems.erase(std::find(step->systems.begin(), step->systems.end(), this));
}

SoftBodySystem::SoftBodySystem(btDiscreteDynamicsWorld& world, Hook hook)
    : impl_(std::make_unique<Impl>(world, hook)) {}

SoftBodySystem::~SoftBodySystem() {
  const bool alive = impl_->worldAlive();
  impl_->step->forgetGroups();
  impl_->stepBoundary.reset();
  impl_->springs.clear();
  for (auto& body : impl_->bodies) {
    for (btRigidBody* point : body->data_->masses.bodies)
      if (point) impl_->dropSprings(*point);
    wakeNeighbours(*body->data_, false);
    removeFromWorld(*body->data_);
  }
  if (alive) impl_->step->restoreBulletState();
  if (impl_->hook) impl_->hook->leave(*impl_, alive);
}

void SoftBodySystem::removeAll() {
  impl_->step->forgetGroups();
  for (const auto& spring : impl_->springs) impl_->wakeEnds(*spring, nullptr);
  impl_->springs.clear();
  for (std::size_t i = impl_->bodies.size(); i-- > 0;) impl_->step->addPending(impl_->bodies[i].get());
  impl_->destroyPending();
}

HookState SoftBodySystem::hookState() const {
  if (!impl_->hook || (impl_->bodies.empty() && impl_->springs.empty())) return HookState::Idle;
  if (impl_->hookKind == Hook::Manual) return HookState::Attached;
  return impl_->hook->inPlace() && !impl_->overwritten ? HookState::Attached : HookState::Overwritten;
}

void SoftBodySystem::rehook() {
  if (hookState() == HookState::Overwritten) impl_->step->kinematic.start(*impl_->world);
  impl_->overwritten = false;
  if (impl_->hook && impl_->hookKind == Hook::PreTick) impl_->hook->takeSlot();
}

void SoftBodySystem::onWarning(std::function<void(const std::string&)> handler) {
  impl_->warn = std::move(handler);
}

// --- bodies ------------------------------------------------------------------------------------------------

Result<SoftBody*> SoftBodySystem::createBody(const SharedNetwork& network, const SoftBodySettings& settings) {
  Result<std::unique_ptr<SoftBodyData>> data = makeBodyData(network, settings, impl_->models);
  if (!data) return Error{data.error()};
  impl_->hookUp();
  (*data)->world = impl_->world;
  (*data)->system = impl_->step.get();
  (*data)->shapes = &impl_->step->shapes;
  (*data)->worldLock = &impl_->step->lock;
  (*data)->links = &impl_->step->links;
  (*data)->groupsStale = &impl_->step->groupsStale;
  (*data)->filter = &impl_->filter;
  (*data)->surroundings = &impl_->surroundings;
  (*data)->onPointsExposed = [impl = impl_.get()] { impl->watchSteps(); };
  (*data)->onPointDeleted = [impl = impl_.get()](const btRigidBody& point) { impl->dropSprings(point); };
  impl_->bodies.push_back(std::unique_ptr<SoftBody>(new SoftBody(std::move(*data))));
  SoftBody* body = impl_->bodies.back().get();
  addToWorld(*body->data_);
  impl_->step->groupsStale = true;
  return body;
}

Result<void> SoftBodySystem::destroyBody(SoftBody* body) {
  if (!impl_->owns(body)) return Error{"the soft body is not, or no longer, one of this system"};
  impl_->step->addPending(body);
  impl_->destroyPending();
  return {};
}

bool SoftBodySystem::Impl::owns(const SoftBody* body) const {
  return findOwner(bodies, body) != bodies.end();
}

/// Not within a listener's call: it may hold pointers to the bodies.
void SoftBodySystem::Impl::destroyPending() {
  if (step->callsListeners()) return;
  const bool alive = worldAlive();
  step->destroyPending();
  unhookIfIdle(alive);
}

/// The callbacks of contacts that end may ask for more bodies, of any system, to be destroyed.
void SoftBodySystem::Impl::WorldStep::destroyPending() {
  while (!pendingDestruction.empty()) {
    SoftBody* body = pendingDestruction.front();
    pendingDestruction.erase(pendingDestruction.begin());
    for (Impl* system : systems) system->destroyNow(body);
  }
}

/// A body that is listed twice would be one that no longer exists, or a new one at its address.
void SoftBodySystem::Impl::WorldStep::addPending(SoftBody* body) {
  if (std::find(pendingDestruction.begin(), pendingDestruction.end(), body) == pendingDestruction.end())
    pendingDestruction.push_back(body);
}

void SoftBodySystem::Impl::destroyNow(SoftBody* body) {
  if (!owns(body)) return;
  endPairsOf(body);
  dropFields(*body->data_);
  for (btRigidBody* point : body->data_->masses.bodies)
    if (point) forget(*point);
  step->forgetGroups();
  wakeNeighbours(*body->data_, false);
  removeFromWorld(*body->data_);
  bodies.erase(findOwner(bodies, body));
  const auto isPushed = [](const auto& other) {
    return isSurfaceBody(*other->data_) && (other->data_->masses.exposed || other->data_->surface.pushed);
  };
  if (std::none_of(bodies.begin(), bodies.end(), isPushed)) stepBoundary.reset();
}

std::size_t SoftBodySystem::bodyCount() const { return impl_->bodies.size(); }
SoftBody* SoftBodySystem::body(std::size_t i) const {
  return i < impl_->bodies.size() ? impl_->bodies[i].get() : nullptr;
}

bool SoftBodySystem::Impl::WorldStep::callsListeners() const {
  return std::any_of(systems.begin(), systems.end(),
                     [](const Impl* system) { return system->events.calling(); });
}

void SoftBodySystem::Impl::WorldStep::forgetGroups() {
  groups.clear();
  awake.clear();
  moving.clear();
  islands.count = 0;
  pairs.clear();
  living.clear();
  absent.clear();
  springs.clear();
  groupsStale = true;
}

std::size_t SoftBodySystem::springCount() const { return impl_->springs.size(); }

bool SoftBodySystem::Impl::WorldStep::owns(const SoftBody* body) const {
  return std::any_of(systems.begin(), systems.end(), [&](const Impl* system) { return system->owns(body); });
}

void SoftBodySystem::forget(const btRigidBody& body) {
  impl_->forget(body);
  impl_->unhookIfIdle(impl_->worldAlive());
}

void SoftBodySystem::Impl::forget(const btRigidBody& body) {
  dropSprings(body);
  for (Impl* system : step->systems)
    for (auto& softBody : system->bodies)
      for (std::size_t i = softBody->data_->anchors.size(); i-- > 0;)
        if (softBody->data_->anchors[i].body == &body)
          system->detach(softBody.get(), softBody->data_->anchors[i].point);
}

// --- surroundings ------------------------------------------------------------------------------------------

void SoftBodySystem::Impl::wakeAll() {
  for (auto& body : bodies) body->wake();
}

void SoftBodySystem::Impl::dropFields(const SoftBodyData& body) {
  auto& fields = surroundings.fields;
  const auto actsOnIt = [&](const ActingField& field) { return field.body == &body; };
  fields.erase(std::remove_if(fields.begin(), fields.end(), actsOnIt), fields.end());
}

Result<void> SoftBodySystem::setAir(const Air& air) {
  if (Result<void> valid = validate(air); !valid) return Error{"air: " + valid.error()};
  Air& present = impl_->surroundings.air;
  const bool changes =
      air.windAt || present.windAt || air.density != present.density || air.wind != present.wind;
  // bodies without drag may have some in the other air
  const auto wakeIfBlown = [&] {
    for (auto& body : impl_->bodies)
      if (changes && hasDragInAir(*body->data_)) body->wake();
  };
  wakeIfBlown();
  present = air;
  wakeIfBlown();
  return {};
}

Result<void> SoftBodySystem::setWater(const std::optional<Water>& water) {
  if (water)
    if (Result<void> valid = validate(*water); !valid) return Error{"water: " + valid.error()};
  std::optional<Water>& present = impl_->surroundings.water;
  const bool same = water.has_value() == present.has_value() &&
                    (!water || (water->density == present->density && water->level == present->level &&
                                water->flow == present->flow));
  if (!same) impl_->wakeAll();
  present = water;
  return {};
}

const Air& SoftBodySystem::air() const { return impl_->surroundings.air; }
const std::optional<Water>& SoftBodySystem::water() const { return impl_->surroundings.water; }

Result<std::uint64_t> SoftBodySystem::addField(ForceField field, SoftBody* body) {
  if (!field) return Error{"the field is an empty function"};
  if (body && !impl_->owns(body)) return Error{"the soft body is not, or no longer, one of this system"};
  Surroundings& around = impl_->surroundings;
  around.fields.push_back({++around.lastField, std::move(field), body ? body->data_.get() : nullptr});
  if (body)
    body->wake();
  else
    impl_->wakeAll();
  return around.lastField;
}

Result<void> SoftBodySystem::removeField(std::uint64_t field) {
  auto& fields = impl_->surroundings.fields;
  const auto it =
      std::find_if(fields.begin(), fields.end(), [&](const ActingField& f) { return f.id == field; });
  if (it == fields.end()) return Error{"there is no field " + std::to_string(field)};
  for (auto& body : impl_->bodies)
    if (!it->body || it->body == body->data_.get()) body->wake();
  fields.erase(it);
  return {};
}

// --- contacts ----------------------------------------------------------------------------------------------

void SoftBodySystem::Impl::notifyListener() {
  if (showsManifolds)
    for (auto& body : bodies) reportManifold(*body->data_, strongest);
  if (!events.listening()) return;
  for (auto& body : bodies) events.collect(*body->data_);
  for (const Handle<SpringConstraint>& spring : step->brokenSprings)
    if (spring && findOwner(springs, spring.get()) != springs.end()) events.callBreak(*spring);
  for (std::size_t i = 0; i < bodies.size(); ++i) events.callBreaks(*bodies[i]);
  events.call(world);
  step->destroyPending();  // keeps the hook, which is calling this function
}

void SoftBodySystem::Impl::hideManifolds() {
  if (!showsManifolds) return;
  for (std::size_t i = bodies.size(); i-- > 0;) removeReportedManifolds(*bodies[i]->data_);
}

void SoftBodySystem::Impl::endPairsOf(SoftBody* body) {
  const bool alive = worldAlive();
  for (Impl* system : step->systems) {
    if (!system->events.listening()) continue;
    for (auto& other : system->bodies)
      if (other.get() == body)
        system->events.collectEnds(*body->data_);
      else
        system->events.collectEnds(*other->data_, body);
    system->events.call(alive ? world : nullptr);
  }
}

void SoftBodySystem::setContactListener(ContactListener* listener) {
  impl_->events.setListener(listener, impl_->bodies);
}

void SoftBodySystem::reportManifolds(bool report) {
  if (!report) impl_->hideManifolds();
  impl_->showsManifolds = report;
}

// --- ticks -------------------------------------------------------------------------------------------------

void SoftBodySystem::beforeTick(btScalar tick) { impl_->beforeTick(tick); }

void SoftBodySystem::setParallelFor(ParallelFor run, std::size_t fromSprings) {
  impl_->step->parallel.use(std::move(run), fromSprings);
}

const TickProfile& SoftBodySystem::profile() const { return impl_->step->profile; }

TickProfile& TickProfile::operator+=(const TickProfile& other) {
  for (auto time :
       {&TickProfile::readMs, &TickProfile::searchMs, &TickProfile::islandsMs, &TickProfile::chooseMs,
        &TickProfile::stepMs, &TickProfile::writeMs, &TickProfile::readBackMs})
    this->*time += other.*time;
  for (auto number : {&TickProfile::awakeBodies, &TickProfile::pointsStepped, &TickProfile::substeps,
                      &TickProfile::springSubsteps, &TickProfile::contacts, &TickProfile::islands,
                      &TickProfile::rigidParts})
    this->*number += other.*number;
  return *this;
}

double SoftBodySystem::tickFraction() const { return limber::tickFraction(*impl_->world); }

// --- debug drawing -----------------------------------------------------------------------------------------

namespace {

/// Strain at which the colour saturates.
constexpr double kMaxStrain = 0.1;

/// Size of a pin's cross, in radii of the points.
constexpr double kCrossSize = 2.0;

/// Returns blue for compression, red for extension and grey at rest.
btVector3 colourOf(double strain) {
  const btVector3 rest(btScalar(0.75), btScalar(0.75), btScalar(0.75));
  const btVector3 pressed(btScalar(0.12), btScalar(0.35), btScalar(0.8));
  const btVector3 stretched(btScalar(0.85), btScalar(0.15), btScalar(0.1));
  const double share = std::min(std::abs(strain) / kMaxStrain, 1.0);
  return lerp(rest, strain < 0.0 ? pressed : stretched, static_cast<btScalar>(share));
}

double strainOf(double length, double restLength) {
  return restLength > 0.0 ? length / restLength - 1.0 : length;
}

void drawSprings(const SoftBodyData& body, btIDebugDraw& drawer) {
  const Points& x = body.state.position;
  const SpringArrays& s = body.springs;
  for (std::size_t i = 0; i < s.size(); ++i) {
    if (s->extensionStiffness[i] == 0.0 && s->compressionStiffness[i] == 0.0) continue;
    const Eigen::Vector3d a = x.col(s->a[i]), b = x.col(s->b[i]);
    drawer.drawLine(toBullet(a), toBullet(b), colourOf(strainOf((b - a).norm(), s->restLength[i])));
  }
}

void drawPins(const SoftBodyData& body, btIDebugDraw& drawer) {
  const btScalar size = static_cast<btScalar>(kCrossSize) * body.masses.shape->getRadius();
  for (std::size_t i = 0; i < body.masses.held.size(); ++i) {
    if (!body.masses.held[i]) continue;
    const btVector3 at = toBullet(body.state.position.col(static_cast<Eigen::Index>(i)));
    for (int axis = 0; axis < 3; ++axis) {
      btVector3 arm(0, 0, 0);
      arm[axis] = size;
      drawer.drawLine(at - arm, at + arm, btVector3(1, 1, 0));
    }
  }
}

void drawContacts(SoftBodyData& body, btIDebugDraw& drawer) {
  for (const SoftContact& contact : readReport(body))
    drawer.drawContactPoint(contact.position, contact.normal, static_cast<btScalar>(contact.distance), 0,
                            drawer.getDefaultColors().m_contactPoint);
}

void drawAnchors(const SoftBodyData& body, btIDebugDraw& drawer) {
  for (const Anchor& anchor : body.anchors)
    drawer.drawLine(anchor.body->getCenterOfMassPosition(), anchor.body->getWorldTransform() * anchor.pivot,
                    btVector3(1, 1, 0));
}

bool hasMode(const btIDebugDraw& drawer, int mode) { return (drawer.getDebugMode() & mode) != 0; }

/// Draws the parts of a body that the drawer's modes select: springs coloured by strain and pinned points
/// (wireframe), the bounding box (AABB), contacts (contact points), anchors (constraints).
void debugDraw(SoftBodyData& body, btIDebugDraw& drawer) {
  if (!body.alive) return;
  if (hasMode(drawer, btIDebugDraw::DBG_DrawWireframe)) {
    drawSprings(body, drawer);
    drawPins(body, drawer);
  }
  if (hasMode(drawer, btIDebugDraw::DBG_DrawAabb)) {
    const Eigen::AlignedBox3d box = boxAround(body.state.position, radiusOf(body));
    drawer.drawAabb(toBullet(box.min()), toBullet(box.max()), drawer.getDefaultColors().m_aabb);
  }
  if (hasMode(drawer, btIDebugDraw::DBG_DrawContactPoints)) drawContacts(body, drawer);
  if (hasMode(drawer, btIDebugDraw::DBG_DrawConstraints)) drawAnchors(body, drawer);
}

/// Draws the springs that were added one by one, in the mode for constraints.
void debugDraw(const SpringList& springs, btIDebugDraw& drawer) {
  if (!hasMode(drawer, btIDebugDraw::DBG_DrawConstraints)) return;
  for (const auto& spring : springs) {
    const double strain = strainOf(double(spring->length()), *spring->settings().restLength);
    drawer.drawLine(SpringConstraint::worldPivot(spring->endA()),
                    SpringConstraint::worldPivot(spring->endB()), colourOf(strain));
  }
}

}  // namespace

void SoftBodySystem::debugDraw(btIDebugDraw& drawer) const { impl_->debugDraw(drawer); }

void SoftBodySystem::Impl::debugDraw(btIDebugDraw& drawer) {
  for (auto& body : bodies) limber::debugDraw(*body->data_, drawer);
  limber::debugDraw(springs, drawer);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
