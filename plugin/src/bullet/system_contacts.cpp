// SPDX-License-Identifier: Zlib
#include "bullet/system_impl.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

void SoftBodySystem::Impl::tellOfContacts() {
  if (showsManifolds)
    for (auto& body : bodies) showContacts(*body->data_, strongest);
  if (!events.listening()) return;
  for (auto& body : bodies) events.collect(*body->data_);
  events.call(world);
  // not the hook: it is on the way here
  for (Impl* system : step->systems) system->destroyDoomed();
}

void SoftBodySystem::Impl::hideManifolds() {
  if (!showsManifolds) return;
  for (std::size_t i = bodies.size(); i-- > 0;) hideContacts(*bodies[i]->data_);
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

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
