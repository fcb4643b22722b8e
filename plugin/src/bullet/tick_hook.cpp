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

/// The callback gets the world and nothing else, so the way from a world to its hook is process-wide.
HookList& hookList() {
  static HookList list;
  return list;
}

TickHook* findHook(HookList& list, btDynamicsWorld* world) {
  for (auto& [key, hook] : list.hooks)
    if (key == world) return hook.get();
  return nullptr;
}

template <class T>
void eraseValue(std::vector<T>& values, T value) {
  values.erase(std::remove(values.begin(), values.end(), value), values.end());
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
  if (hook->actionListeners_.empty()) {
    // a hook that was abandoned may already be among the world's actions, or stem from a world that is gone
    world.removeAction(hook);
    world.addAction(hook);
  }
  hook->actionListeners_.push_back(&listener);
  if (!pretick) return *hook;
  if (hook->pretickListeners_.empty() && !hook->inPlace()) hook->takeSlot();
  hook->pretickListeners_.push_back(&listener);
  return *hook;
}

void TickHook::leave(TickListener& listener, bool worldAlive) {
  HookList& list = hookList();
  const std::lock_guard<std::mutex> lock(list.mutex);
  eraseValue(actionListeners_, &listener);
  eraseValue(pretickListeners_, &listener);
  if (!worldAlive || !actionListeners_.empty()) return;
  world_->removeAction(this);
  // somebody who took the slot after us may be calling us on: then stay, and pass the call on
  if (pretickListeners_.empty() && CallbackReader::read(*world_) != &TickHook::preTick && previous_) return;
  giveSlotBack();
  const auto self = [&](const auto& entry) { return entry.second.get() == this; };
  list.hooks.erase(std::find_if(list.hooks.begin(), list.hooks.end(), self));
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
  TickHook* hook = nullptr;
  {
    HookList& list = hookList();
    const std::lock_guard<std::mutex> lock(list.mutex);
    hook = findHook(list, world);
  }
  if (hook) hook->beforeTick(tick);
}

void TickHook::beforeTick(btScalar tick) {
  // a callback that took our slot and was then made our predecessor may call us again
  if (inTick_) return;
  inTick_ = true;
  if (previous_) previous_(world_, tick);
  for (TickListener* listener : pretickListeners_) listener->beforeTick(tick);
  inTick_ = false;
  sawTick_ = true;
}

void TickHook::updateAction(btCollisionWorld*, btScalar tick) {
  const bool missed = !sawTick_ && !pretickListeners_.empty();
  sawTick_ = false;
  for (TickListener* listener : actionListeners_) {
    const bool waits = std::count(pretickListeners_.begin(), pretickListeners_.end(), listener) > 0;
    if (missed && waits)
      listener->tickMissed();
    else
      listener->afterTick(tick);
  }
}

void TickHook::debugDraw(btIDebugDraw* drawer) {
  for (TickListener* listener : actionListeners_) listener->debugDraw(*drawer);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
