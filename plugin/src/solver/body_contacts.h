// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/verlet_kernel.h"
#include "solver/verlet_step.h"

namespace limber {

inline bool mayTouch(const SteppedBody& body) {
  return (body.contacts && !body.contacts->empty()) || (body.watch && body.watch->on);
}

/// Before a drift: holds back what is on its way into something, foreseen or not.
inline void stopAtContacts(SteppedBody& body, const PointView& points, double time, double dt) {
  if (body.contacts) stopAtContacts(*body.contacts, points, time, dt);
  if (!body.watch || !body.watch->on) return;
  body.watch->look(points, time, dt);
  if (!body.watch->rows.empty()) stopAtContacts(body.watch->rows, points, time, dt);
}

/// After the second kick.
inline void settleContacts(SteppedBody& body, const PointView& points) {
  if (body.contacts) settleContacts(*body.contacts, points);
  if (body.watch && !body.watch->rows.empty()) settleContacts(body.watch->rows, points);
}

/// A body's contacts as the kernels call them. `points` must hold the state of the start of the tick by the
/// time calls() is called.
struct BodyContacts {
  SteppedBody* body;
  PointView points;

  kernel::ContactCalls calls() {
    const bool touches = mayTouch(*body);
    if (touches && body->contacts) prepareContacts(*body->contacts, points);
    return {touches ? this : nullptr, &BodyContacts::stop, &BodyContacts::settle};
  }

 private:
  static void stop(void* context, double time, double dt) {
    auto& self = *static_cast<BodyContacts*>(context);
    stopAtContacts(*self.body, self.points, time, dt);
  }
  static void settle(void* context) {
    auto& self = *static_cast<BodyContacts*>(context);
    settleContacts(*self.body, self.points);
  }
};

}  // namespace limber
