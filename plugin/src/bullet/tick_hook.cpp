// SPDX-License-Identifier: Zlib
#include "bullet/tick_hook.h"

#include <algorithm>
#include <memory>
#include <mutex>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// btDynamicsWorld has no getter for its callback; a derived class may name the protected member.
struct CallbackReader : btDynamicsWorld {
  static btInternalTickCallback read(const btDynamicsWorld& world) {
    return world.*(&CallbackReader::m_internalPreTickCallback);
  }
};

struct HookList {
  std::mutex mutex;  // worlds may be stepped by several threads
  std::vector<std::pair<btDynamicsWorld*, std::unique_ptr<TickHook>>> hooks;
};

/// The callback gets the world and nothing else, so the way from a world to its hook is process-wide. Never
/// deleted: systems and worlds of static lifetime may need it when the program ends.
HookList& hookList() {
  static HookList& list = *new HookList;
  return list;
}

TickHook* findHook(HookList& list, btDynamicsWorld* world) {
  for (auto& [key, hook] : list.hooks)
    if (key == world) return hook.get();
  return nullptr;
}

bool has(const std::vector<TickListener*>& listeners, const TickListener* listener) {
  return std::find(listeners.begin(), listeners.end(), listener) != listeners.end();
}

bool hasAny(const std::vector<TickListener*>& listeners) {
  return std::any_of(listeners.begin(), listeners.end(), [](const TickListener* l) { return l; });
}

void eraseGone(std::vector<TickListener*>& listeners) {
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
  if (!hook->listened()) {
    // a hook that was left may already be among the world's actions, or stem from a world that is gone
    world.removeAction(hook);
    world.addAction(hook);
  }
  hook->actionListeners_.push_back(&listener);
  if (!pretick) return *hook;
  if (!hasAny(hook->pretickListeners_)) hook->takeSlot();
  hook->pretickListeners_.push_back(&listener);
  return *hook;
}

bool TickHook::listened() const { return hasAny(actionListeners_); }

void TickHook::leave(TickListener& listener, bool worldAlive) {
  const std::lock_guard<std::mutex> lock(hookList().mutex);
  for (auto* listeners : {&actionListeners_, &pretickListeners_})
    std::replace(listeners->begin(), listeners->end(), &listener, static_cast<TickListener*>(nullptr));
  if (calls_ == 0 && worldAlive) detachIfUnused();
}

/// The list must be locked; `this` may be gone afterwards.
void TickHook::detachIfUnused() {
  eraseGone(actionListeners_);
  eraseGone(pretickListeners_);
  if (!listened()) detach();
}

void TickHook::detach() {
  world_->removeAction(this);
  // somebody who took the slot after us may be calling us on: then stay, and pass the call on
  if (!inPlace() && previous_) return;
  giveSlotBack();
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

void TickHook::giveSlotBack() {
  if (inPlace()) world_->setInternalTickCallback(previous_, world_->getWorldUserInfo(), true);
}

void TickHook::preTick(btDynamicsWorld* world, btScalar tick) {
  HookList& list = hookList();
  TickHook* hook = nullptr;
  {
    const std::lock_guard<std::mutex> lock(list.mutex);
    hook = findHook(list, world);
  }
  // a callback that took our slot and was then made our predecessor may call us again
  if (!hook || hook->inTick_) return;
  hook->beforeTick(tick);
  const std::lock_guard<std::mutex> lock(list.mutex);
  if (hook->calls_ == 0) hook->detachIfUnused();
}

/// Also those that join in the meantime.
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
    if (sawTick || !has(pretickListeners_, &listener))
      listener.afterTick(tick);
    else if (!inPlace())
      listener.tickMissed();
    // else it began to listen after the begin of this tick
  });
}

void TickHook::debugDraw(btIDebugDraw* drawer) {
  callEach(actionListeners_, [&](TickListener& listener) { listener.debugDraw(*drawer); });
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
