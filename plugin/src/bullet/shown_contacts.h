// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/contact_report.h"
#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// The contacts of bodies with Collision::Surface, shown between ticks as manifolds in Bullet's dispatcher.
//
// Each manifold belongs to the pair of the two objects in Bullet's broadphase, as those that Bullet's own
// algorithms make: it goes when one of the objects leaves the world, in whatever way, and so never names an
// object that is gone. No step of Bullet's sees one: they are released before it.

/// What a pair in the broadphase has in place of one of Bullet's algorithms. Bullet deletes it with the pair.
class ShownContacts final : public btCollisionAlgorithm {
 public:
  ShownContacts(btDispatcher& dispatcher, SoftBodyData& body, const btCollisionObject& other);
  ~ShownContacts() override;

  const btCollisionObject* other() const { return other_; }
  bool isShown() const { return manifold_ != nullptr; }
  /// A new manifold, without points.
  btPersistentManifold& show();
  /// Releases the manifold, without telling those who listen for the ends of Bullet's own contacts.
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

/// Scratch of showContacts().
struct StrongestContacts {
  const btCollisionObject* other;
  int count;
  std::array<const SoftContact*, MANIFOLD_CACHE_SIZE> contacts;  ///< by normal impulse, the largest first
};

/// After a tick: shows what the body's report tells, of each partner the four that bear most.
void showContacts(SoftBodyData& body, std::vector<StrongestContacts>& scratch);

/// Before a tick.
void hideContacts(SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
