// SPDX-License-Identifier: Zlib

// Users learn of contacts from three things: the report of each body, the calls of a listener, and manifolds
// in Bullet's dispatcher.

#pragma once

#include "bullet/soft_body_data.h"

#include <limber/contact_listener.h>
#include <limber/soft_body_system.h>
#include <limber/soft_contact.h>

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct TickContacts;

// --- the report --------------------------------------------------------------------------------------------

/// After a tick of that length (s), before reportContactImpulses(): fills the reports of all bodies of a
/// system that are awake. `bodies`: those in its groups, which `pairs` names by their index.
void reportContacts(const std::vector<SoftBodyData*>& bodies, const TickContacts& pairs,
                    const btDiscreteDynamicsWorld& world, double tick);

/// Forgets contacts with what has left the world since, or all if the body itself has.
void dropGone(SoftBodyData& body);

/// The contacts with their triangles.
const std::vector<SoftContact>& readReport(SoftBodyData& body);

/// Finds the triangle of a contact's sides.
void findTriangles(SoftContact& contact);

// --- events ------------------------------------------------------------------------------------------------

/// A call that a listener is to get.
struct ContactEvent {
  void (ContactListener::*call)(const ContactPair&) = nullptr;
  SoftBodyData* body = nullptr;
  ObjectHandle other;
  ContactPair pair;
};

/// Compares what touches now with what touched when the listener was last told.
class ContactEvents {
 public:
  void setListener(ContactListener* listener, const std::vector<std::unique_ptr<SoftBody>>& bodies);
  bool listening() const { return listener_ != nullptr; }
  /// Whether calls are under way: bodies must then stay where they are.
  bool calling() const { return calling_; }

  /// After reportContacts(): adds what the listener is to be told of a body.
  void collect(SoftBodyData& body);
  /// Ends all pairs of a body, which is about to go.
  void collectEnds(SoftBodyData& body);
  /// Ends a body's pairs with another body, which is about to go.
  void collectEnds(SoftBodyData& body, const SoftBody* other);
  /// Makes the calls. `world`: nullptr if it may be gone.
  void call(const btCollisionWorld* world);

 private:
  void sumUp(SoftBodyData& body);
  void add(void (ContactListener::*told)(const ContactPair&), SoftBodyData& body, const ContactPair& pair,
           const ObjectHandle& other);
  void addEnd(SoftBodyData& body, const TouchingPair& ended);

  ContactListener* listener_ = nullptr;
  bool calling_ = false;
  std::vector<ContactEvent> events_;
  // Scratch of one body: what touches now, by id.
  std::vector<TouchingPair> now_;
  std::vector<ContactPair> pairs_;  // #now_
};

// --- manifolds ---------------------------------------------------------------------------------------------

/// Scratch of reportManifold().
struct StrongestContacts {
  const btCollisionObject* other;
  int count;
  std::array<const SoftContact*, MANIFOLD_CACHE_SIZE> contacts;  ///< by normal impulse, the largest first
};

/// After a tick: shows what the body's report tells, of each partner the four that bear most.
void reportManifold(SoftBodyData& body, std::vector<StrongestContacts>& scratch);

/// Before a tick.
void removeReportedManifolds(SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
