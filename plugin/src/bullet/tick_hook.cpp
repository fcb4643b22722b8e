// SPDX-License-Identifier: Zlib

// This file installs the world's pre-tick callback, keeps a body in the world that detects the end of a step,
// and reads the clock.

#include "bullet/tick_hook.h"

#include "bullet/bullet_objects.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- ticks -------------------------------------------------------------------------------------------------

namespace {

struct HookList {
  std::mutex mutex;  // worlds may be stepped by several threads
  std::vector<std::pair<btDynamicsWorld*, std::unique_ptr<TickHook>>> hooks;
};

/// Returns the hooks of all worlds. The list is process-wide because the callback gets only the world, and
/// must find its hook. It is never deleted: systems and worlds of static lifetime may need it when the
/// program ends.
HookList& hookList() {
  static HookList& list = *new HookList;
  return list;
}

TickHook* findHook(HookList& list, btDynamicsWorld* world) {
  for (auto& [key, hook] : list.hooks)
    if (key == world) return hook.get();
  return nullptr;
}

}  // namespace

TickHook& TickHook::listen(btDynamicsWorld& world, TickListener& listener, bool pretick, bool known) {
  HookList& list = hookList();
  const std::lock_guard<std::mutex> lock(list.mutex);
  TickHook* hook = findHook(list, &world);
  if (!hook) {
    list.hooks.emplace_back(&world, std::unique_ptr<TickHook>(new TickHook(world)));
    hook = list.hooks.back().second.get();
  }
  auto& listeners = hook->listeners_;
  const auto isUsed = [](const Entry& entry) { return entry.listener; };
  const auto usesSlot = [](const Entry& entry) { return entry.listener && entry.pretick; };
  if (!known || std::none_of(listeners.begin(), listeners.end(), isUsed)) {
    // the hook may still be one of the world's actions, or belong to a world that was deleted
    world.removeAction(hook);
    world.addAction(hook);
  }
  if (pretick && (!known || std::none_of(listeners.begin(), listeners.end(), usesSlot))) hook->takeSlot();
  listeners.push_back({&listener, pretick});
  return *hook;
}

void TickHook::leave(TickListener& listener, bool worldAlive) {
  const std::lock_guard<std::mutex> lock(hookList().mutex);
  for (Entry& entry : listeners_)
    if (entry.listener == &listener) entry.listener = nullptr;
  if (calls_ == 0 && worldAlive) detachIfUnused();
}

/// The list must be locked. May delete `this`.
void TickHook::detachIfUnused() {
  const auto isGone = [](const Entry& entry) { return !entry.listener; };
  listeners_.erase(std::remove_if(listeners_.begin(), listeners_.end(), isGone), listeners_.end());
  if (!listeners_.empty()) return;
  world_->removeAction(this);
  // a callback that was set after ours may call it: then the hook stays, and calls the previous callback
  if (!inPlace() && previous_) return;
  if (inPlace()) world_->setInternalTickCallback(previous_, world_->getWorldUserInfo(), true);
  auto& hooks = hookList().hooks;
  const auto self = [&](const auto& entry) { return entry.second.get() == this; };
  hooks.erase(std::find_if(hooks.begin(), hooks.end(), self));
}

bool TickHook::inPlace() const { return world_->*WorldMembers::kPreTickCallback == &TickHook::preTick; }

void TickHook::takeSlot() {
  if (inPlace()) return;
  previous_ = world_->*WorldMembers::kPreTickCallback;
  world_->setInternalTickCallback(&TickHook::preTick, world_->getWorldUserInfo(), true);
}

void TickHook::preTick(btDynamicsWorld* world, btScalar tick) {
  HookList& list = hookList();
  TickHook* hook = nullptr;
  {
    const std::lock_guard<std::mutex> lock(list.mutex);
    hook = findHook(list, world);
  }
  // a callback that replaced ours and then became our previous one may call us again
  if (!hook || hook->ticks_ > 0) return;
  hook->beforeTick(tick);
  const std::lock_guard<std::mutex> lock(list.mutex);
  if (hook->calls_ == 0) hook->detachIfUnused();
}

/// Also calls listeners that are added during the calls.
template <class Call>
void TickHook::callEach(Call call) {
  const During called(calls_);
  for (std::size_t i = 0; i < listeners_.size(); ++i)
    if (const Entry entry = listeners_[i]; entry.listener) call(*entry.listener, entry.pretick);
}

void TickHook::beforeTick(btScalar tick) {
  const During inTick(ticks_), called(calls_);
  if (previous_) previous_(world_, tick);
  callEach([&](TickListener& listener, bool pretick) {
    if (pretick) listener.beforeTick(tick);
  });
  sawTick_ = true;
}

void TickHook::updateAction(btCollisionWorld*, btScalar tick) {
  const bool sawTick = sawTick_;
  sawTick_ = false;
  callEach([&](TickListener& listener, bool pretick) {
    if (sawTick || !pretick)
      listener.afterTick(tick);
    else if (!inPlace())
      listener.tickMissed();
    // otherwise it was added after the start of this tick
  });
}

void TickHook::debugDraw(btIDebugDraw* drawer) {
  callEach([&](TickListener& listener, bool) { listener.debugDraw(*drawer); });
}

// --- steps -------------------------------------------------------------------------------------------------

struct StepBoundary::State final : btMotionState {
  explicit State(StepBoundary* o) : owner(o) {}
  ~State() override {
    if (owner) owner->state_ = nullptr;
  }
  void getWorldTransform(btTransform& pose) const override { pose.setIdentity(); }
  void setWorldTransform(const btTransform&) override {
    if (owner) owner->motionStatesRequested_();
  }

  StepBoundary* owner;  ///< nullptr: it is being destroyed
};

struct StepBoundary::Body final : OwnBody<Body> {
  Body(StepBoundary* o, State* state, btCollisionShape* shape)
      : OwnBody(btRigidBodyConstructionInfo(0, state, shape)), owner(o) {
    // dynamic for Bullet: else it would not clear its forces or update its motion state
    setCollisionFlags(CF_NO_CONTACT_RESPONSE | CF_DISABLE_VISUALIZE_OBJECT);
    forceActivationState(DISABLE_DEACTIVATION);
  }
  ~Body() override {
    if (owner) owner->body_ = nullptr;
  }

  StepBoundary* owner;  ///< nullptr: it is being destroyed
};

StepBoundary::StepBoundary(btDiscreteDynamicsWorld& world, std::function<void()> motionStatesRequested)
    : world_(&world), motionStatesRequested_(std::move(motionStatesRequested)), state_(new State(this)) {
  body_ = new Body(this, state_, &shape_);
  world.addRigidBody(body_, 0, 0);
}

StepBoundary::~StepBoundary() {
  if (body_) {
    if (isInWorld()) world_->removeRigidBody(body_);
    body_->owner = nullptr;
    body_->setMotionState(nullptr);
    delete body_;
  }
  if (state_) {
    state_->owner = nullptr;
    delete state_;
  }
}

bool StepBoundary::stepHasEnded() {
  const btVector3 kMarkForce(1, 0, 0);  // N; any value except 0
  if (!isInWorld()) return true;
  const bool ended = body_->getTotalForce() != kMarkForce;
  body_->clearForces();
  body_->applyCentralForce(kMarkForce);
  return ended;
}

bool StepBoundary::isOne(const btCollisionObject* object) { return Body::from(object) != nullptr; }

bool StepBoundary::isInWorld() const { return body_ && body_->isInWorld(); }

// --- clock -------------------------------------------------------------------------------------------------

// As in btDiscreteDynamicsWorld::synchronizeSingleMotionState: the shown state is later than the last tick by
// m_localTime - m_fixedTimeStep with latency and by m_localTime without. With ticks of variable length the
// world sets m_fixedTimeStep to 0 and always shows the last tick.
double tickFraction(const btDiscreteDynamicsWorld& world) {
  const double tick = double(world.*WorldMembers::kFixedTick);
  if (!(tick > 0.0)) return 1.0;
  const double share = double(world.*WorldMembers::kTimeSinceTick) / tick;
  return world.*WorldMembers::kHasLatency ? share : 1.0 + share;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
