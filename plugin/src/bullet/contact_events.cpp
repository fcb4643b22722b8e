// SPDX-License-Identifier: Zlib

// This file shows contacts to the user's filter and applies its answers, calls a listener when contacts
// begin, persist and end, and adds manifolds for contacts of surfaces to Bullet's dispatcher between ticks.

#include "bullet/contact_report.h"

#include "bullet/body_in_world.h"
#include "bullet/system_impl.h"
#include "bullet/tick_hook.h"

#include <LinearMath/btAabbUtil2.h>

#include <new>
#include <tuple>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

// --- the triangle of a concave object ----------------------------------------------------------------------

/// Finds the triangle nearest to a point, both in the coordinates of the shape.
struct NearestTriangle final : btTriangleCallback {
  explicit NearestTriangle(const Vector3d& position) : x(position) {}
  Vector3d x;
  double squaredDistance = std::numeric_limits<double>::max();
  int part = -1, triangle = -1;

  void processTriangle(btVector3* corners, int partId, int index) override {
    const Vector3d a = toEigen(corners[0]), b = toEigen(corners[1]), c = toEigen(corners[2]);
    const Vector3d w = nearestBarycentric({a, b, c}, x);
    const double squared = (w[0] * a + w[1] * b + w[2] * c - x).squaredNorm();
    if (!(squared < squaredDistance)) return;
    squaredDistance = squared;
    part = partId;
    triangle = index;
  }
};

/// Searches the shape and the children of compounds within `reach` (m) of a position in the world.
void findTriangle(const btCollisionShape& shape, const btTransform& pose, const btVector3& position,
                  btScalar reach, ShapeCache& shapes, ContactCandidate& c, double& squaredDistance) {
  const btVector3 local = pose.invXform(position), extent(reach, reach, reach);
  if (shape.isCompound()) {
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    forEachChildIn({local - extent, local + extent}, compound, [&](int i) {
      findTriangle(*compound.getChildShape(i), pose * compound.getChildTransform(i), position, reach, shapes,
                   c, squaredDistance);
    });
    return;
  }
  if (!shape.isConcave() || shape.getShapeType() == STATIC_PLANE_PROXYTYPE) return;
  NearestTriangle nearest(toEigen(local));
  nearest.squaredDistance = squaredDistance;
  {
    const std::unique_lock<std::mutex> lock = shapes.lockMesh(shape);
    static_cast<const btConcaveShape&>(shape).processAllTriangles(&nearest, local - extent, local + extent);
  }
  if (nearest.triangle < 0) return;
  squaredDistance = nearest.squaredDistance;
  c.otherPart = nearest.part;
  c.otherTriangle = nearest.triangle;
}

// --- questions ---------------------------------------------------------------------------------------------

/// Asks the filters of both sides, once if they are the same. Makes numbers of the answer valid.
void ask(const SoftBodyData& body, const SoftBodyData* other, ContactCandidate& c) {
  c.body = body.handle;
  if (other) c.otherBody = other->handle;
  if (!other && c.other) {
    double squaredDistance = std::numeric_limits<double>::max();
    const btScalar reach =
        btScalar(2) * (btFabs(static_cast<btScalar>(c.distance)) + static_cast<btScalar>(radiusOf(body)));
    findTriangle(*c.other->getCollisionShape(), c.other->getWorldTransform(),
                 c.position - static_cast<btScalar>(c.distance) * c.normal, reach, *body.shapes, c,
                 squaredDistance);
  }
  if (isFiltered(body)) (*body.filter)(c);
  if (other && other->filter != body.filter && isFiltered(*other)) (*other->filter)(c);
  if (!(c.friction >= 0.0)) c.friction = 0.0;
  if (!isSound(c.surfaceVelocity)) c.surfaceVelocity.setZero();
  if (!isFinite(c.facing)) c.facing.setZero();
  if (!(c.restitution >= 0.0)) c.restitution = 0.0;
  c.restitution = std::min(c.restitution, 1.0);
}

/// Returns the part of a velocity across a unit normal.
Vector3d acrossOf(const btVector3& velocity, const Vector3d& normal) {
  const Vector3d v = toEigen(velocity);
  return v - normal.dot(v) * normal;
}

/// Returns whether the direction is one that a one-sided contact has.
bool isFacing(const Vector3d& normal, const btVector3& facing) {
  return !(normal.dot(toEigen(facing)) < 0.0);
}

// --- plane contacts ----------------------------------------------------------------------------------------

/// Returns the nearest point of the pieces that a following contact follows.
HeldPoint nearestPiece(const PlaneContact& row, const Vector3d& x) {
  HeldPoint best;
  best.height = std::numeric_limits<double>::max();
  const HeldPiece* first = row.around->all->pieces.data() + row.around->begin;
  const HeldPiece* end = row.around->all->pieces.data() + row.around->end;
  for (const HeldPiece* next = first; first != end; first = next) {
    next = endOfSolid(first, end);
    if (first->owner != row.owner) continue;
    const HeldPoint point = nearestOn(first, next, x);
    if (point.height < best.height) best = point;
  }
  return best;
}

/// Returns whether the contact acts, or may act later in the tick. `answer` receives the answer.
bool filterPlane(const SoftBodyData& body, PlaneContact& row, ContactCandidate& answer) {
  const Vector3d x = body.state.position.col(row.point);
  Vector3d normal = row.normal;
  double gap = normal.dot(x - row.touch);
  if (row.away) {
    const HeldPoint nearest = nearestPiece(row, x);
    normal = nearest.normal;
    gap = nearest.height - radiusOf(body);
  }
  answer.other = partnerOf(body, row).handle.object;
  answer.side = pointSide(row.point);
  answer.position = toBullet(x - radiusOf(body) * normal);
  answer.normal = toBullet(normal);
  answer.distance = gap;
  answer.friction = row.friction;
  answer.restitution = row.restitution;
  ask(body, nullptr, answer);
  if (answer.response != ContactResponse::Act) return false;
  row.friction = answer.friction;
  row.restitution = answer.restitution;
  row.surfaceVelocity += acrossOf(answer.surfaceVelocity, normal);
  if (!row.around) return isFacing(normal, answer.facing);
  row.facing = toEigen(answer.facing);
  row.away = row.away || !isFacing(normal, answer.facing);
  return true;
}

/// Removes the entries for which keep(entry), which may change it, is false. Keeps the order.
template <class Entry, class Keep>
void keepOnly(std::vector<Entry>& entries, Keep keep) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (!keep(entries[i])) continue;
    if (count != i) entries[count] = entries[i];
    ++count;
  }
  entries.erase(entries.begin() + static_cast<std::ptrdiff_t>(count), entries.end());
}

/// Makes a contact for the report of a plane contact.
TickContact sensedContact(SoftBodyData& body, const PlaneContact& row, const ContactCandidate& answer) {
  TickContact c;
  static_cast<ContactBase&>(c) = row;
  c.normal = toEigen(answer.normal);
  c.gap = answer.distance;
  c.a = softPoint(body.index, row.point);
  c.b.velocity = row.surfaceVelocity;
  c.source.body = &body;
  c.source.partner = partnerOf(body, row).handle;
  return c;
}

// --- contacts of moving bodies -----------------------------------------------------------------------------

double validMassFactor(double factor) { return factor > 0.0 ? std::clamp(factor, 1e-6, 1e6) : 1.0; }

bool isAsked(const ContactSource& source) {
  return source.body && (isFiltered(*source.body) || (source.other && isFiltered(*source.other)));
}

/// `positions`: of the points of the body on side a.
ContactResponse filterPair(TickContact& contact, const Points& positions) {
  const ContactSource& source = contact.source;
  const SoftBodyData& body = *source.body;
  ContactCandidate answer;
  answer.other = source.partner.object;
  answer.side = sideOf(contact.a);
  if (source.other) answer.otherSide = sideOf(contact.b);
  answer.position = toBullet(positionOf(contact.a, positions) - radiusOf(body) * contact.normal);
  answer.normal = toBullet(contact.normal);
  answer.distance = contact.gap;
  answer.friction = contact.friction;
  answer.restitution = contact.restitution;
  ask(body, source.other, answer);
  contact.friction = answer.friction;
  contact.restitution = answer.restitution;
  if (source.other != source.body) {
    contact.a.massFactor = validMassFactor(answer.massFactor);
    contact.b.massFactor = validMassFactor(answer.otherMassFactor);
  }
  contact.b.velocity += acrossOf(answer.surfaceVelocity, contact.normal);
  const bool acts = answer.response == ContactResponse::Act;
  return acts && !isFacing(contact.normal, answer.facing) ? ContactResponse::Ignore : answer.response;
}

}  // namespace

void SoftBodySystem::setContactFilter(ContactFilter filter) {
  impl_->filter = std::move(filter);
  impl_->wakeAll();
}

void filterPlanes(SoftBodyData& body, std::vector<PlaneContact>& rows, TickContacts* found) {
  keepOnly(rows, [&](PlaneContact& row) {
    ContactCandidate answer;
    if (filterPlane(body, row, answer)) return true;
    if (found && answer.response == ContactResponse::Report)
      found->sensed.push_back(sensedContact(body, row, answer));
    return false;
  });
}

void filterPairs(TickContacts& found, std::vector<std::uint32_t>& newIndex) {
  newIndex.clear();
  std::uint32_t count = 0;
  keepOnly(found.contacts, [&](TickContact& c) {
    newIndex.push_back(count);
    const ContactResponse response =
        isAsked(c.source) ? filterPair(c, c.source.body->state.position) : ContactResponse::Act;
    if (response == ContactResponse::Report) found.sensed.push_back(c);
    if (response == ContactResponse::Act) ++count;
    return response == ContactResponse::Act;
  });
  newIndex.push_back(count);
  for (SurfaceCandidate& m : found.candidates) m.first = newIndex[m.first], m.end = newIndex[m.end];
}

void filterPairs(std::vector<TickContact>& contacts) {
  keepOnly(contacts, [](TickContact& c) {
    return !isAsked(c.source) ||
           filterPair(c, *c.source.body->surface.moving.position) == ContactResponse::Act;
  });
}

// --- calls of the listener ---------------------------------------------------------------------------------

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

void ContactEvents::addEnd(SoftBodyData& body, const TouchingPair& ended) {
  ContactPair pair;
  pair.body = body.handle;
  pair.other = ended.other.object;
  pair.otherBody = ended.otherBody;
  events_.push_back({&ContactListener::contactEnds, &body, ended.other, pair});
}

template <class Ends>
void ContactEvents::endPairs(SoftBodyData& body, Ends ends) {
  const auto endIf = [&](const TouchingPair& pair) {
    if (!ends(pair)) return false;
    addEnd(body, pair);
    return true;
  };
  body.touching.erase(std::remove_if(body.touching.begin(), body.touching.end(), endIf), body.touching.end());
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
  if (body.asleep || !body.report.fresh)
    return endPairs(body, [&](const TouchingPair& pair) { return !isValid(*body.world, pair.other); });
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
    events_.push_back({persists ? &ContactListener::contactPersists : &ContactListener::contactBegins, &body,
                       other, pairs_[i]});
  }
  for (; old != body.touching.end(); ++old) addEnd(body, *old);
  body.touching.swap(now_);
}

void ContactEvents::collectEnds(SoftBodyData& body) {
  endPairs(body, [](const TouchingPair&) { return true; });
}

void ContactEvents::collectEnds(SoftBodyData& body, const SoftBody* other) {
  endPairs(body, [&](const TouchingPair& pair) { return pair.otherBody == other; });
}

void ContactEvents::callBreak(SpringConstraint& spring) {
  const During called(calls_);
  if (listener_) listener_->springBreaks(spring);
}

void ContactEvents::callBreaks(SoftBody& body) {
  SoftBodyData& data = dataOf(body);
  if (data.tears.empty() && data.brokenAnchors.empty()) return;
  const During called(calls_);
  // a callback may change the lists
  const std::vector<BrokenAnchor> anchors = data.brokenAnchors;
  const std::vector<Tear> tears = data.tears;
  for (const BrokenAnchor& anchor : anchors)
    if (listener_) listener_->anchorBreaks(anchor);
  if (listener_ && !tears.empty()) listener_->bodyTears(body, tears);
}

void ContactEvents::call(const btCollisionWorld* world) {
  const During called(calls_);
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
  ReportedManifold(btDispatcher& dispatcher, SoftBodyData& body, const btCollisionObject& other)
      : body_(&body), other_(&other) {
    m_dispatcher = &dispatcher;
    body.shown.push_back(this);
  }
  ~ReportedManifold() override {
    hide();
    body_->shown.erase(std::find(body_->shown.begin(), body_->shown.end(), this));
  }

  const btCollisionObject* other() const { return other_; }
  bool isShown() const { return manifold_ != nullptr; }

  /// Adds a new manifold, without points.
  btPersistentManifold& show() {
    manifold_ = m_dispatcher->getNewManifold(body_->surface.object, other_);
    // if it is still there in a step
    manifold_->setContactProcessingThreshold(kIgnoredByBullet);
    return *manifold_;
  }

  /// Releases the manifold without calling Bullet's contact-ended callbacks.
  void hide() {
    if (!manifold_) return;
    for (int i = 0; i < manifold_->getNumContacts(); ++i)
      manifold_->clearUserCache(manifold_->getContactPoint(i));
    manifold_->setNumContacts(0);
    m_dispatcher->releaseManifold(manifold_);
    manifold_ = nullptr;
  }

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

namespace {

/// Returns the manifold that represents the pair of two objects, or nullptr if there is none.
ReportedManifold* findReported(const SoftBodyData& body, const btCollisionObject& other) {
  for (ReportedManifold* shown : body.shown)
    if (shown->other() == &other) return shown;
  return nullptr;
}

/// Returns the reported manifold of the pair of two objects and creates it on first use. Returns nullptr if
/// Bullet's broadphase has no such pair or the pair has a collision algorithm of Bullet's.
ReportedManifold* reportedManifoldOf(SoftBodyData& body, const btCollisionObject& other) {
  if (ReportedManifold* reported = findReported(body, other)) return reported;
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
  return surface && surface->owner() && findReported(*surface->owner(), *body.surface.object);
}

}  // namespace

void reportManifold(SoftBodyData& body, std::vector<const SoftContact*>& scratch) {
  if (!isSurfaceBody(body) || !body.alive || !anyInWorld(body)) return;
  scratch.clear();
  for (const SoftContact& contact : readReport(body)) scratch.push_back(&contact);
  // by partner, the strongest contacts first
  const auto keyOf = [](const SoftContact* c) { return std::tuple(idOf(*c->other), -c->normalImpulse, c); };
  std::sort(scratch.begin(), scratch.end(),
            [&](const SoftContact* c, const SoftContact* d) { return keyOf(c) < keyOf(d); });
  for (std::size_t i = 0, end = 0; i < scratch.size(); i = end) {
    const btCollisionObject& other = *scratch[i]->other;
    while (end < scratch.size() && scratch[end]->other == &other) ++end;
    ReportedManifold* reported = isReportedByOther(body, other) ? nullptr : reportedManifoldOf(body, other);
    if (!reported || reported->isShown()) continue;
    btPersistentManifold& manifold = reported->show();
    for (std::size_t k = i; k < std::min(end, i + MANIFOLD_CACHE_SIZE); ++k)
      manifold.addManifoldPoint(manifoldPoint(*scratch[k], *body.surface.object, other), true);
  }
}

void removeReportedManifolds(SoftBodyData& body) {
  for (std::size_t i = body.shown.size(); i-- > 0;) body.shown[i]->hide();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
