// SPDX-License-Identifier: Zlib

// This header declares how users see contacts: their filter, and the three ways to report contacts: the
// report of each body, the calls of a listener, and manifolds in Bullet's dispatcher.

#pragma once

#include "bullet/parallel.h"
#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"

#include <limber/soft_body_system.h>

#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- the filter, which only worlds that have one call ------------------------------------------------------

inline bool isFiltered(const SoftBodyData& body) { return body.filter && *body.filter; }

/// Asks for plane contacts of a body, and removes those that do not act. Those that are only reported go to
/// `found`; nullptr: they are within a tick, and lost.
void filterPlanes(SoftBodyData& body, std::vector<PlaneContact>& rows, TickContacts* found);

/// Asks for the contacts of moving bodies, and removes those that do not act. Those that are only reported
/// stay in found.sensed. `newIndex` is scratch.
void filterPairs(TickContacts& found, std::vector<std::uint32_t>& newIndex);

/// Asks for contacts found within a tick, and removes those that do not act.
void filterPairs(std::vector<TickContact>& contacts);

// --- the report --------------------------------------------------------------------------------------------

/// Adds an object near the body to SoftBodyData::sensors if either of the two has no contact response.
/// Returns whether it did.
bool addSensor(SoftBodyData& body, btCollisionObject& partner);

/// Returns the side of a soft body in a contact, at one of its points or at a contact point.
ContactSide pointSide(std::uint32_t point);
ContactSide sideOf(const ContactPoint& point);

/// Fills the reports of all bodies that are awake, after a tick of length `tick` (s). Writes the impulses of
/// contacts of point masses in the world to Bullet's manifolds. `bodies`: the bodies in the groups, to which
/// the indices in `pairs` refer.
void reportContacts(const std::vector<SoftBodyData*>& bodies, const TickContacts& pairs,
                    const btDiscreteDynamicsWorld& world, double tick, const Parallel& parallel);

/// Removes contacts with objects that have left the world, or all if the body itself has left it.
void dropInvalidContacts(SoftBodyData& body);

/// Returns the contacts with their triangles.
const std::vector<SoftContact>& readReport(SoftBodyData& body);

/// Finds the triangles of both sides of a contact.
void findTriangles(SoftContact& contact);

// --- events ------------------------------------------------------------------------------------------------

/// A pending call of the listener.
struct ContactEvent {
  void (ContactListener::*call)(const ContactPair&) = nullptr;
  SoftBodyData* body = nullptr;
  ObjectHandle other;
  ContactPair pair;
};

/// Compares the present contacts with those at the last calls of the listener.
class ContactEvents {
 public:
  void setListener(ContactListener* listener, const std::vector<std::unique_ptr<SoftBody>>& bodies);
  bool listening() const { return listener_ != nullptr; }
  /// Returns whether the listener is being called. Bodies must not be destroyed then.
  bool calling() const { return calls_ > 0; }

  /// Adds the calls for a body's contacts, after reportContacts().
  void collect(SoftBodyData& body);
  /// Adds the ends of all pairs of a body that is about to be destroyed.
  void collectEnds(SoftBodyData& body);
  /// Adds the ends of a body's pairs with another body that is about to be destroyed.
  void collectEnds(SoftBodyData& body, const SoftBody* other);
  /// Report what has broken or torn in the last tick.
  void callBreak(SpringConstraint& spring);
  void callBreaks(SoftBody& body);
  /// Makes the calls. `world`: nullptr if it may no longer exist.
  void call(const btCollisionWorld* world);

 private:
  void sumByPartner(SoftBodyData& body);
  void addEnd(SoftBodyData& body, const TouchingPair& ended);
  template <class Ends>
  void endPairs(SoftBodyData& body, Ends ends);

  ContactListener* listener_ = nullptr;
  int calls_ = 0;  // of the listener, in progress
  std::vector<ContactEvent> events_;
  // Scratch of one body: its present pairs, sorted by id.
  std::vector<TouchingPair> now_;
  std::vector<ContactPair> pairs_;  // #now_
};

// --- manifolds ---------------------------------------------------------------------------------------------

/// Adds manifolds with the body's reported contacts, after a tick: for each partner the four contacts with
/// the largest impulses.
void reportManifold(SoftBodyData& body, std::vector<const SoftContact*>& scratch);

/// Removes these manifolds, before a tick.
void removeReportedManifolds(SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
