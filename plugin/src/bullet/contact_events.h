// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/contact_report.h"
#include "bullet/soft_body_data.h"

#include <limber/contact_listener.h>
#include <limber/soft_body_system.h>

#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A call that a listener is to get.
struct ContactEvent {
  void (ContactListener::*call)(const ContactPair&) = nullptr;
  SoftBodyData* body = nullptr;
  PartnerMark other;
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
           const PartnerMark& other);
  void addEnd(SoftBodyData& body, const TouchingPair& ended);

  ContactListener* listener_ = nullptr;
  bool calling_ = false;
  std::vector<ContactEvent> events_;
  // Scratch of one body: what touches now, by id.
  std::vector<TouchingPair> now_;
  std::vector<ContactPair> pairs_;  // #now_
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
