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
  for (std::size_t i = 0; i < doomed.size(); ++i) destroyNow(doomed[i]);
  doomed.clear();
}

void SoftBodySystem::Impl::hideManifolds() {
  if (!showsManifolds) return;
  for (std::size_t i = bodies.size(); i-- > 0;) hideContacts(*bodies[i]->data_);
}

void SoftBodySystem::Impl::endPairsOf(SoftBody* body) {
  if (!events.listening()) return;
  for (auto& other : bodies)
    if (other.get() == body)
      events.collectEnds(*body->data_);
    else
      events.collectEnds(*other->data_, body);
  events.call(worldAlive() ? world : nullptr);
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
