// SPDX-License-Identifier: Zlib

// This file installs the world's pre-tick callback, keeps a body in the world that detects the end of a step,
// and reads the clock.

#include "bullet/tick_hook.h"

#include <algorithm>
#include <memory>
#include <mutex>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- ticks -------------------------------------------------------------------------------------------------

namespace {

/// Reads the world's callback. btDynamicsWorld has no getter for it, but a derived class may access the
/// protected member.
struct CallbackReader : btDynamicsWorld {
  static btInternalTickCallback read(const btDynamicsWorld& world) {
    return world.*(&CallbackReader::m_internalPreTickCallback);
  }
};

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

bool contains(const std::vector<TickListener*>& listeners, const TickListener* listener) {
  return std::find(listeners.begin(), listeners.end(), listener) != listeners.end();
}

bool hasAny(const std::vector<TickListener*>& listeners) {
  return std::any_of(listeners.begin(), listeners.end(), [](const TickListener* l) { return l; });
}

void eraseRemoved(std::vector<TickListener*>& listeners) {
  listeners.erase(std::remove(listeners.begin(), listeners.end(), nullptr), listeners.end());
}

}  // namespace

TickHook& TickHook::listen(btDynamicsWorld& world, TickListener& listener, bool pretick) {
  HookList& list = hookList();
  const std::lock_guard<std::mutex> lock(list.mutex);
  TickHook* hook = findHook(list, &world);
  if (!hook) {
    list.hooks.emplace_back(&world, std::unique_ptr<TickHook>(new TickHook(world)));
    hook = list.hooks.back().second.get();
  }
  if (!hook->hasListeners()) {
    // an unused hook may still be one of the world's actions, or belong to a world that was deleted
    world.removeAction(hook);
    world.addAction(hook);
  }
  hook->actionListeners_.push_back(&listener);
  if (!pretick) return *hook;
  if (!hasAny(hook->pretickListeners_)) hook->takeSlot();
  hook->pretickListeners_.push_back(&listener);
  return *hook;
}

bool TickHook::hasListeners() const { return hasAny(actionListeners_); }

void TickHook::leave(TickListener& listener, bool worldAlive) {
  const std::lock_guard<std::mutex> lock(hookList().mutex);
  for (auto* listeners : {&actionListeners_, &pretickListeners_})
    std::replace(listeners->begin(), listeners->end(), &listener, static_cast<TickListener*>(nullptr));
  if (calls_ == 0 && worldAlive) detachIfUnused();
}

/// The list must be locked. May delete `this`.
void TickHook::detachIfUnused() {
  eraseRemoved(actionListeners_);
  eraseRemoved(pretickListeners_);
  if (!hasListeners()) detach();
}

void TickHook::detach() {
  world_->removeAction(this);
  // a callback that was set after ours may call it: then the hook stays, and calls the previous callback
  if (!inPlace() && previous_) return;
  releaseSlot();
  auto& hooks = hookList().hooks;
  const auto self = [&](const auto& entry) { return entry.second.get() == this; };
  hooks.erase(std::find_if(hooks.begin(), hooks.end(), self));
}

bool TickHook::inPlace() const { return CallbackReader::read(*world_) == &TickHook::preTick; }

void TickHook::takeSlot() {
  if (inPlace()) return;
  previous_ = CallbackReader::read(*world_);
  world_->setInternalTickCallback(&TickHook::preTick, world_->getWorldUserInfo(), true);
}

void TickHook::releaseSlot() {
  if (inPlace()) world_->setInternalTickCallback(previous_, world_->getWorldUserInfo(), true);
}

void TickHook::preTick(btDynamicsWorld* world, btScalar tick) {
  HookList& list = hookList();
  TickHook* hook = nullptr;
  {
    const std::lock_guard<std::mutex> lock(list.mutex);
    hook = findHook(list, world);
  }
  // a callback that replaced ours and then became our previous one may call us again
  if (!hook || hook->inTick_) return;
  hook->beforeTick(tick);
  const std::lock_guard<std::mutex> lock(list.mutex);
  if (hook->calls_ == 0) hook->detachIfUnused();
}

/// Also calls listeners that are added during the calls.
template <class Call>
void TickHook::callEach(const std::vector<TickListener*>& listeners, Call call) {
  ++calls_;
  for (std::size_t i = 0; i < listeners.size(); ++i)
    if (listeners[i]) call(*listeners[i]);
  --calls_;
}

void TickHook::beforeTick(btScalar tick) {
  inTick_ = true;
  ++calls_;
  if (previous_) previous_(world_, tick);
  --calls_;
  callEach(pretickListeners_, [&](TickListener& listener) { listener.beforeTick(tick); });
  inTick_ = false;
  sawTick_ = true;
}

void TickHook::updateAction(btCollisionWorld*, btScalar tick) {
  const bool sawTick = sawTick_;
  sawTick_ = false;
  callEach(actionListeners_, [&](TickListener& listener) {
    if (sawTick || !contains(pretickListeners_, &listener))
      listener.afterTick(tick);
    else if (!inPlace())
      listener.tickMissed();
    // otherwise it was added after the start of this tick
  });
}

void TickHook::debugDraw(btIDebugDraw* drawer) {
  callEach(actionListeners_, [&](TickListener& listener) { listener.debugDraw(*drawer); });
}

// --- steps -------------------------------------------------------------------------------------------------

namespace {

/// N; any value except 0.
const btVector3 kMarkForce(1, 0, 0);

int boundaryMark;  // see pointMassMark

}  // namespace

class StepBoundary::State final : public btMotionState {
 public:
  explicit State(StepBoundary* owner) : owner_(owner) {}
  ~State() override {
    if (owner_) owner_->state_ = nullptr;
  }
  void disown() { owner_ = nullptr; }
  void getWorldTransform(btTransform& pose) const override { pose.setIdentity(); }
  void setWorldTransform(const btTransform&) override {
    if (owner_) owner_->listener_->motionStatesRequested();
  }

 private:
  StepBoundary* owner_;
};

class StepBoundary::Body final : public btRigidBody {
 public:
  Body(StepBoundary* owner, State* state, btCollisionShape* shape)
      : btRigidBody(btRigidBodyConstructionInfo(0, state, shape)), owner_(owner) {
    internalSetExtensionPointer(&boundaryMark);
    // dynamic for Bullet: else it would not clear its forces or update its motion state
    setCollisionFlags(CF_NO_CONTACT_RESPONSE | CF_DISABLE_VISUALIZE_OBJECT);
    forceActivationState(DISABLE_DEACTIVATION);
  }
  ~Body() override {
    if (owner_) owner_->body_ = nullptr;
  }
  void disown() { owner_ = nullptr; }

 private:
  StepBoundary* owner_;
};

StepBoundary::StepBoundary(btDiscreteDynamicsWorld& world, StepListener& listener)
    : world_(&world), listener_(&listener), state_(new State(this)) {
  body_ = new Body(this, state_, &shape_);
  world.addRigidBody(body_, 0, 0);
}

StepBoundary::~StepBoundary() {
  if (body_) {
    if (isInWorld()) world_->removeRigidBody(body_);
    body_->disown();
    body_->setMotionState(nullptr);
    delete body_;
  }
  if (state_) {
    state_->disown();
    delete state_;
  }
}

bool StepBoundary::stepHasEnded() {
  if (!isInWorld()) return true;
  const bool ended = body_->getTotalForce() != kMarkForce;
  body_->clearForces();
  body_->applyCentralForce(kMarkForce);
  return ended;
}

bool StepBoundary::isOne(const btCollisionObject* object) {
  return object && object->internalGetExtensionPointer() == &boundaryMark;
}

bool StepBoundary::isInWorld() const { return body_ && body_->isInWorld(); }

// --- clock -------------------------------------------------------------------------------------------------

namespace {

/// Reads the world's clock. btDiscreteDynamicsWorld has no getters for it, but a derived class may access the
/// protected members.
struct ClockReader : btDiscreteDynamicsWorld {
  static btScalar timeSinceTick(const btDiscreteDynamicsWorld& world) {
    return world.*(&ClockReader::m_localTime);
  }
  static btScalar fixedTick(const btDiscreteDynamicsWorld& world) {
    return world.*(&ClockReader::m_fixedTimeStep);
  }
  static bool hasLatency(const btDiscreteDynamicsWorld& world) {
    return world.*(&ClockReader::m_latencyMotionStateInterpolation);
  }
};

}  // namespace

// As in btDiscreteDynamicsWorld::synchronizeSingleMotionState: the shown state is later than the last tick by
// m_localTime - m_fixedTimeStep with latency and by m_localTime without. With ticks of variable length the
// world sets m_fixedTimeStep to 0 and always shows the last tick.
double tickFraction(const btDiscreteDynamicsWorld& world) {
  const double tick = double(ClockReader::fixedTick(world));
  if (!(tick > 0.0)) return 1.0;
  const double share = double(ClockReader::timeSinceTick(world)) / tick;
  return ClockReader::hasLatency(world) ? share : 1.0 + share;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
