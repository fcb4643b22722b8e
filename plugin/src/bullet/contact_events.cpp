// SPDX-License-Identifier: Zlib
#include "bullet/contact_events.h"

#include "bullet/body_in_world.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

bool before(const TouchingPair& pair, int id) { return pair.other.id < id; }

/// What stands for the object in pairs: a body in many pieces is one.
PartnerMark pairMark(const SoftContact& contact, const PartnerMark& partner) {
  const PointMass* point = PointMass::from(contact.other);
  if (!point || !point->owner()) return partner;
  const PointMass* first = point->owner()->masses.bodies[0];
  return first && first->isInWorld() ? markOf(*first) : partner;
}

void addTo(ContactPair& pair, const SoftContact& contact) {
  if (pair.contacts == 0 || contact.normalImpulse > pair.strongest.normalImpulse) pair.strongest = contact;
  ++pair.contacts;
  pair.normalImpulse += contact.normalImpulse;
  pair.impulse += contact.impulse;
}

void forget(SoftBodyData& body, int id) {
  const auto it = std::lower_bound(body.touching.begin(), body.touching.end(), id, before);
  if (it != body.touching.end() && it->other.id == id) body.touching.erase(it);
}

}  // namespace

void ContactEvents::setListener(ContactListener* listener,
                                const std::vector<std::unique_ptr<SoftBody>>& bodies) {
  if (listener == listener_) return;
  listener_ = listener;
  events_.clear();
  for (const auto& body : bodies) dataOf(*body).touching.clear();
}

void ContactEvents::add(void (ContactListener::*told)(const ContactPair&), SoftBodyData& body,
                        const ContactPair& pair, const PartnerMark& other) {
  events_.push_back({told, &body, other, pair});
}

void ContactEvents::addEnd(SoftBodyData& body, const TouchingPair& ended) {
  ContactPair pair;
  pair.body = body.handle;
  pair.other = ended.other.object;
  pair.otherBody = ended.otherBody;
  add(&ContactListener::contactEnds, body, pair, ended.other);
}

/// Brings the body's contacts together by partner.
void ContactEvents::sumUp(SoftBodyData& body) {
  now_.clear();
  pairs_.clear();
  for (std::size_t i = 0; i < body.report.contacts.size(); ++i) {
    const SoftContact& contact = body.report.contacts[i];
    const PartnerMark other = pairMark(contact, body.report.partners[i]);
    const auto it = std::lower_bound(now_.begin(), now_.end(), other.id, before);
    const auto place = it - now_.begin();
    if (it == now_.end() || it->other.id != other.id) {
      now_.insert(it, {other, contact.otherBody});
      ContactPair& pair = *pairs_.insert(pairs_.begin() + place, ContactPair());
      pair.body = body.handle;
      pair.other = other.object;
      pair.otherBody = contact.otherBody;
    }
    addTo(pairs_[static_cast<std::size_t>(place)], contact);
  }
}

void ContactEvents::collect(SoftBodyData& body) {
  if (!body.alive || !anyInWorld(body)) return collectEnds(body);
  dropGone(body);
  if (body.asleep || !body.report.fresh) {
    const auto gone = [&](const TouchingPair& pair) { return !isThere(*body.world, pair.other); };
    for (const TouchingPair& pair : body.touching)
      if (gone(pair)) addEnd(body, pair);
    body.touching.erase(std::remove_if(body.touching.begin(), body.touching.end(), gone),
                        body.touching.end());
    return;
  }
  sumUp(body);
  auto old = body.touching.begin();
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const PartnerMark& other = now_[i].other;
    for (; old != body.touching.end() && old->other.id < other.id; ++old) addEnd(body, *old);
    const bool sameId = old != body.touching.end() && old->other.id == other.id;
    const bool known = sameId && old->other.object == other.object;
    // some broadphases use their ids again
    if (sameId && !known) addEnd(body, *old);
    if (sameId) ++old;
    add(known ? &ContactListener::contactPersists : &ContactListener::contactBegins, body, pairs_[i], other);
  }
  for (; old != body.touching.end(); ++old) addEnd(body, *old);
  body.touching.swap(now_);
}

void ContactEvents::collectEnds(SoftBodyData& body) {
  for (const TouchingPair& pair : body.touching) addEnd(body, pair);
  body.touching.clear();
}

void ContactEvents::collectEnds(SoftBodyData& body, const SoftBody* other) {
  const auto isOther = [&](const TouchingPair& pair) { return pair.otherBody == other; };
  for (const TouchingPair& pair : body.touching)
    if (isOther(pair)) addEnd(body, pair);
  body.touching.erase(std::remove_if(body.touching.begin(), body.touching.end(), isOther),
                      body.touching.end());
}

void ContactEvents::call(const btCollisionWorld* world) {
  calling_ = true;
  // by index: a callback may set another listener, which clears them
  for (std::size_t i = 0; i < events_.size(); ++i) {
    ContactEvent& event = events_[i];
    const bool ends = event.call == &ContactListener::contactEnds;
    event.pair.otherGone = !world || !isThere(*world, event.other);
    // what a callback has just removed: a pair that was known ends after the next tick
    if (event.pair.otherGone && event.call == &ContactListener::contactBegins)
      forget(*event.body, event.other.id);
    if (event.pair.otherGone && !ends) continue;
    if (!ends) findTriangles(event.pair.strongest);
    if (listener_) (listener_->*event.call)(event.pair);
  }
  events_.clear();
  calling_ = false;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
