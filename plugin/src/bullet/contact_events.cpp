// SPDX-License-Identifier: Zlib

// This file calls a listener when contacts begin, persist and end. It also adds manifolds for contacts of
// surfaces to Bullet's dispatcher between ticks.

#include "bullet/body_in_world.h"
#include "bullet/contact_report.h"
#include "bullet/surface_body.h"

#include <algorithm>
#include <new>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

bool before(const TouchingPair& pair, int id) { return pair.other.id < id; }

/// Returns the handle of the object that represents the contact's partner in pairs. The first point
/// represents all points of a soft body.
ObjectHandle pairHandle(const SoftContact& contact, const ObjectHandle& partner) {
  const PointMass* point = PointMass::from(contact.other);
  if (!point || !point->owner()) return partner;
  const PointMass* first = point->owner()->masses.bodies[0];
  return first && first->isInWorld() ? handleOf(*first) : partner;
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

void ContactEvents::add(void (ContactListener::*callback)(const ContactPair&), SoftBodyData& body,
                        const ContactPair& pair, const ObjectHandle& other) {
  events_.push_back({callback, &body, other, pair});
}

void ContactEvents::addEnd(SoftBodyData& body, const TouchingPair& ended) {
  ContactPair pair;
  pair.body = body.handle;
  pair.other = ended.other.object;
  pair.otherBody = ended.otherBody;
  add(&ContactListener::contactEnds, body, pair, ended.other);
}

/// Groups the body's contacts by partner.
void ContactEvents::sumByPartner(SoftBodyData& body) {
  now_.clear();
  pairs_.clear();
  for (std::size_t i = 0; i < body.report.contacts.size(); ++i) {
    const SoftContact& contact = body.report.contacts[i];
    const ObjectHandle other = pairHandle(contact, body.report.partners[i]);
    const auto it = std::lower_bound(now_.begin(), now_.end(), other.id, before);
    const auto index = it - now_.begin();
    if (it == now_.end() || it->other.id != other.id) {
      now_.insert(it, {other, contact.otherBody});
      ContactPair& pair = *pairs_.insert(pairs_.begin() + index, ContactPair());
      pair.body = body.handle;
      pair.other = other.object;
      pair.otherBody = contact.otherBody;
    }
    addTo(pairs_[static_cast<std::size_t>(index)], contact);
  }
}

void ContactEvents::collect(SoftBodyData& body) {
  if (!body.alive || !anyInWorld(body)) return collectEnds(body);
  dropInvalidContacts(body);
  if (body.asleep || !body.report.fresh) {
    const auto gone = [&](const TouchingPair& pair) { return !isValid(*body.world, pair.other); };
    for (const TouchingPair& pair : body.touching)
      if (gone(pair)) addEnd(body, pair);
    body.touching.erase(std::remove_if(body.touching.begin(), body.touching.end(), gone),
                        body.touching.end());
    return;
  }
  sumByPartner(body);
  auto old = body.touching.begin();
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const ObjectHandle& other = now_[i].other;
    for (; old != body.touching.end() && old->other.id < other.id; ++old) addEnd(body, *old);
    const bool sameId = old != body.touching.end() && old->other.id == other.id;
    const bool persists = sameId && old->other.object == other.object;
    // some broadphases reuse their ids
    if (sameId && !persists) addEnd(body, *old);
    if (sameId) ++old;
    add(persists ? &ContactListener::contactPersists : &ContactListener::contactBegins, body, pairs_[i],
        other);
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
  // by index, because a callback may set another listener, which clears the list
  for (std::size_t i = 0; i < events_.size(); ++i) {
    ContactEvent& event = events_[i];
    const bool ends = event.call == &ContactListener::contactEnds;
    event.pair.otherGone = !world || !isValid(*world, event.other);
    // a callback has just removed the object; a pair that persisted before ends after the next tick
    if (event.pair.otherGone && event.call == &ContactListener::contactBegins)
      forget(*event.body, event.other.id);
    if (event.pair.otherGone && !ends) continue;
    if (!ends) findTriangles(event.pair.strongest);
    if (listener_) (listener_->*event.call)(event.pair);
  }
  events_.clear();
  calling_ = false;
}

// --- manifolds ---------------------------------------------------------------------------------------------

// Contacts of bodies with Collision::Surface appear as manifolds in Bullet's dispatcher between ticks.
//
// Each manifold belongs to the pair of the two objects in Bullet's broadphase, like those of Bullet's own
// algorithms. So it is deleted when one of the objects leaves the world, and never refers to a deleted
// object. The manifolds are released before each step of Bullet's solver.

/// The collision algorithm of such a pair in the broadphase. Bullet deletes it with the pair.
class ReportedManifold final : public btCollisionAlgorithm {
 public:
  ReportedManifold(btDispatcher& dispatcher, SoftBodyData& body, const btCollisionObject& other);
  ~ReportedManifold() override;

  const btCollisionObject* other() const { return other_; }
  bool isShown() const { return manifold_ != nullptr; }
  /// Adds a new manifold, without points.
  btPersistentManifold& show();
  /// Releases the manifold without calling Bullet's contact-ended callbacks.
  void hide();

  void processCollision(const btCollisionObjectWrapper*, const btCollisionObjectWrapper*,
                        const btDispatcherInfo&, btManifoldResult*) override {}
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1;
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override {
    if (manifold_) manifolds.push_back(manifold_);
  }

 private:
  SoftBodyData* body_;
  const btCollisionObject* other_;
  btPersistentManifold* manifold_ = nullptr;
};

ReportedManifold::ReportedManifold(btDispatcher& dispatcher, SoftBodyData& body,
                                   const btCollisionObject& other)
    : body_(&body), other_(&other) {
  m_dispatcher = &dispatcher;
  body.shown.push_back(this);
}

ReportedManifold::~ReportedManifold() {
  hide();
  body_->shown.erase(std::find(body_->shown.begin(), body_->shown.end(), this));
}

btPersistentManifold& ReportedManifold::show() {
  manifold_ = m_dispatcher->getNewManifold(body_->surface.object, other_);
  // makes Bullet's solver ignore the manifold if it is still there in a step
  manifold_->setContactProcessingThreshold(-BT_LARGE_FLOAT);
  return *manifold_;
}

void ReportedManifold::hide() {
  if (!manifold_) return;
  for (int i = 0; i < manifold_->getNumContacts(); ++i)
    manifold_->clearUserCache(manifold_->getContactPoint(i));
  manifold_->setNumContacts(0);
  m_dispatcher->releaseManifold(manifold_);
  manifold_ = nullptr;
}

namespace {

/// Inserts the contact if it is among the strongest ones with its partner.
void insertIfStrong(const SoftContact& contact, std::vector<StrongestContacts>& strongest) {
  const auto isOther = [&](const StrongestContacts& s) { return s.other == contact.other; };
  auto it = std::find_if(strongest.begin(), strongest.end(), isOther);
  if (it == strongest.end()) it = strongest.insert(it, {contact.other, 0, {}});
  auto& sorted = it->contacts;
  int index = it->count;
  while (index > 0 && sorted[static_cast<std::size_t>(index - 1)]->normalImpulse < contact.normalImpulse)
    --index;
  if (index == MANIFOLD_CACHE_SIZE) return;
  if (it->count < MANIFOLD_CACHE_SIZE) ++it->count;
  std::copy_backward(sorted.begin() + index, sorted.begin() + it->count - 1, sorted.begin() + it->count);
  sorted[static_cast<std::size_t>(index)] = &contact;
}

/// Returns the reported manifold of the pair of two objects and creates it on first use. Returns nullptr if
/// Bullet's broadphase has no such pair or the pair has a collision algorithm of Bullet's.
ReportedManifold* reportedManifoldOf(SoftBodyData& body, const btCollisionObject& other) {
  for (ReportedManifold* shown : body.shown)
    if (shown->other() == &other) return shown;
  btBroadphaseProxy* own = body.surface.object->getBroadphaseHandle();
  btBroadphaseProxy* theirs = const_cast<btCollisionObject&>(other).getBroadphaseHandle();
  btBroadphasePair* pair = body.world->getPairCache()->findPair(own, theirs);
  if (!pair || pair->m_algorithm) return nullptr;
  // not from Bullet's pool, whose elements have a fixed size
  auto* shown = new (btAlignedAlloc(sizeof(ReportedManifold), 16))
      ReportedManifold(*body.world->getDispatcher(), body, other);
  pair->m_algorithm = shown;
  return shown;
}

btManifoldPoint manifoldPoint(const SoftContact& c, const btCollisionObject& a, const btCollisionObject& b) {
  const btVector3 onB = c.position - static_cast<btScalar>(c.distance) * c.normal;
  btManifoldPoint p(a.getWorldTransform().invXform(c.position), b.getWorldTransform().invXform(onB), c.normal,
                    static_cast<btScalar>(c.distance));
  p.m_positionWorldOnA = c.position;
  p.m_positionWorldOnB = onB;
  btPlaneSpace1(c.normal, p.m_lateralFrictionDir1, p.m_lateralFrictionDir2);
  p.m_appliedImpulse = static_cast<btScalar>(c.normalImpulse);
  p.m_appliedImpulseLateral1 = c.frictionImpulse.dot(p.m_lateralFrictionDir1);
  p.m_appliedImpulseLateral2 = c.frictionImpulse.dot(p.m_lateralFrictionDir2);
  p.m_combinedFriction = gCalculateCombinedFrictionCallback(&a, &b);
  p.m_combinedRestitution = gCalculateCombinedRestitutionCallback(&a, &b);
  p.m_partId0 = p.m_partId1 = 0;
  p.m_index0 = static_cast<int>(c.side.triangle);  // -1: none
  p.m_index1 = static_cast<int>(c.otherSide.triangle);
  return p;
}

/// Returns whether the other soft body already has the manifold of this pair.
bool isReportedByOther(const SoftBodyData& body, const btCollisionObject& other) {
  const SurfaceObject* surface = SurfaceObject::from(&other);
  if (!surface || !surface->owner()) return false;
  for (const ReportedManifold* shown : surface->owner()->shown)
    if (shown->other() == body.surface.object) return true;
  return false;
}

}  // namespace

void reportManifold(SoftBodyData& body, std::vector<StrongestContacts>& scratch) {
  if (!isSurfaceBody(body) || !body.alive || !body.surface.object || !body.surface.object->isInWorld())
    return;
  scratch.clear();
  for (const SoftContact& contact : readReport(body)) insertIfStrong(contact, scratch);
  for (const StrongestContacts& strongest : scratch) {
    if (isReportedByOther(body, *strongest.other)) continue;
    ReportedManifold* shown = reportedManifoldOf(body, *strongest.other);
    if (!shown || shown->isShown()) continue;
    btPersistentManifold& manifold = shown->show();
    for (int i = 0; i < strongest.count; ++i)
      manifold.addManifoldPoint(manifoldPoint(*strongest.contacts[static_cast<std::size_t>(i)],
                                              *body.surface.object, *strongest.other),
                                true);
  }
}

void removeReportedManifolds(SoftBodyData& body) {
  for (std::size_t i = body.shown.size(); i-- > 0;) body.shown[i]->hide();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
