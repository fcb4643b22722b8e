// SPDX-License-Identifier: Zlib
#include "bullet/shown_contacts.h"

#include "bullet/surface_body.h"

#include <algorithm>
#include <new>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

ShownContacts::ShownContacts(btDispatcher& dispatcher, SoftBodyData& body, const btCollisionObject& other)
    : body_(&body), other_(&other) {
  m_dispatcher = &dispatcher;
  body.shown.push_back(this);
}

ShownContacts::~ShownContacts() {
  hide();
  body_->shown.erase(std::find(body_->shown.begin(), body_->shown.end(), this));
}

btPersistentManifold& ShownContacts::show() {
  manifold_ = m_dispatcher->getNewManifold(body_->surface.object, other_);
  // Bullet's solver leaves it alone, should it ever see it
  manifold_->setContactProcessingThreshold(-BT_LARGE_FLOAT);
  return *manifold_;
}

void ShownContacts::hide() {
  if (!manifold_) return;
  for (int i = 0; i < manifold_->getNumContacts(); ++i)
    manifold_->clearUserCache(manifold_->getContactPoint(i));
  manifold_->setNumContacts(0);
  m_dispatcher->releaseManifold(manifold_);
  manifold_ = nullptr;
}

namespace {

/// Keeps the contact if it is among the strongest with its partner.
void keep(const SoftContact& contact, std::vector<StrongestContacts>& strongest) {
  const auto isOther = [&](const StrongestContacts& s) { return s.other == contact.other; };
  auto it = std::find_if(strongest.begin(), strongest.end(), isOther);
  if (it == strongest.end()) it = strongest.insert(it, {contact.other, 0, {}});
  auto& kept = it->contacts;
  int place = it->count;
  while (place > 0 && kept[static_cast<std::size_t>(place - 1)]->normalImpulse < contact.normalImpulse)
    --place;
  if (place == MANIFOLD_CACHE_SIZE) return;
  if (it->count < MANIFOLD_CACHE_SIZE) ++it->count;
  std::copy_backward(kept.begin() + place, kept.begin() + it->count - 1, kept.begin() + it->count);
  kept[static_cast<std::size_t>(place)] = &contact;
}

/// What the pair of the two objects has, made if need be; nullptr if Bullet's broadphase knows no such pair
/// or somebody else is in charge of it.
ShownContacts* shownOf(SoftBodyData& body, const btCollisionObject& other) {
  for (ShownContacts* shown : body.shown)
    if (shown->other() == &other) return shown;
  btBroadphaseProxy* own = body.surface.object->getBroadphaseHandle();
  btBroadphaseProxy* theirs = const_cast<btCollisionObject&>(other).getBroadphaseHandle();
  btBroadphasePair* pair = body.world->getPairCache()->findPair(own, theirs);
  if (!pair || pair->m_algorithm) return nullptr;
  // not from Bullet's pool, whose elements have a size of their own
  auto* shown = new (btAlignedAlloc(sizeof(ShownContacts), 16))
      ShownContacts(*body.world->getDispatcher(), body, other);
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

/// Of two soft bodies one shows the manifold for both.
bool isOthersTurn(const SoftBodyData& body, const btCollisionObject& other) {
  const SurfaceObject* surface = SurfaceObject::from(&other);
  if (!surface || !surface->owner()) return false;
  for (const ShownContacts* shown : surface->owner()->shown)
    if (shown->other() == body.surface.object) return true;
  return false;
}

}  // namespace

void showContacts(SoftBodyData& body, std::vector<StrongestContacts>& scratch) {
  if (!isSurfaceBody(body) || !body.alive || !body.surface.object || !body.surface.object->isInWorld())
    return;
  scratch.clear();
  for (const SoftContact& contact : readReport(body)) keep(contact, scratch);
  for (const StrongestContacts& strongest : scratch) {
    if (isOthersTurn(body, *strongest.other)) continue;
    ShownContacts* shown = shownOf(body, *strongest.other);
    if (!shown || shown->isShown()) continue;
    btPersistentManifold& manifold = shown->show();
    for (int i = 0; i < strongest.count; ++i)
      manifold.addManifoldPoint(manifoldPoint(*strongest.contacts[static_cast<std::size_t>(i)],
                                              *body.surface.object, *strongest.other),
                                true);
  }
}

void hideContacts(SoftBodyData& body) {
  for (std::size_t i = body.shown.size(); i-- > 0;) body.shown[i]->hide();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
